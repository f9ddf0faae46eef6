/* The teacher's own laboratory: a way to the class, and its code large, by key Q. */
{
  const home = location.pathname.replace(/\/(index\.html)?$/, "");
  const { make, button, sheet, close } = window.flockscopeSheet;
  const bar = make("div", "fs-class"), count = make("span", "");
  let known = null;
  const say = (values) => fetch(`${home}/class/do`, {
    method: "POST", credentials: "same-origin", cache: "no-store", body: JSON.stringify(values),
    headers: { "X-Flockscope": "class", "Content-Type": "application/json" } });
  const wall = () => {
    if (!known) return;
    const inner = sheet("The class", "fs-gallery");
    inner.append(window.flockscopeWall(known.links, async (values) => {
      await say(values);
      setTimeout(wall, 600);
    }, close));
  };
  const listen = () => {
    const line = new EventSource(`${home}/class/roster`);
    line.onmessage = (event) => {
      known = JSON.parse(event.data);
      if (known.over) {
        line.close();
        window.flockscopeEnded("The class has ended", "What you see here stands still.");
      }
      count.textContent = `${known.students.filter((one) => one.here).length} here`;
    };
    line.onerror = () => { if (line.readyState === EventSource.CLOSED) setTimeout(listen, 2000); };
  };
  window.addEventListener("keydown", (event) => {
    const field = event.target.closest && event.target.closest("input, textarea, select");
    if (event.key.toLowerCase() !== "q" || field || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (document.querySelector(".fs-wall")) close(); else wall();
  }, true);
  document.addEventListener("DOMContentLoaded", () => {
    const way = make("a", "", "Class");
    Object.assign(way, { href: `${home}/class`, target: "flockscope-class" });
    bar.append(way, count, button("", "Code (Q)", wall));
    document.body.append(bar);
    listen();
  });
}
