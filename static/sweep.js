/* Sweeps: a mark at every slider that can be swept over, and clicks on what a sweep has come to. The
   server says which sliders these are; a click asks it by HTTP, as the gallery does. The picture is
   replaced while a sweep runs: a press and its release need not find the same element. */
{
  const { make, button, sheet, open, ask } = window.flockscopeSheet;
  /* Docked tabs of viser's heed the pointer, those of a narrow page a click. */
  const openTab = () => {
    const tab = [...document.querySelectorAll('[role="tab"]')].find((one) => one.textContent === "Sweep");
    if (!tab) return;
    const { x, y } = tab.getBoundingClientRect();
    for (const kind of ["pointerdown", "pointerup"]) tab.dispatchEvent(new PointerEvent(kind, {
      bubbles: true, cancelable: true, isPrimary: true, pointerId: 1, clientX: x + 4, clientY: y + 4 }));
    tab.click();
  };
  const bring = (style) => setTimeout(() => {
    const found = document.querySelector(style);
    if (found) found.scrollIntoView({ block: "start" });
  }, 300);
  let text = "", marks = {};

  const choose = async (what, name, title, part) => {
    let words = "";
    try {
      const answer = await ask(`/sweep/${what}?name=${encodeURIComponent(name)}`);
      if (!answer.ok) words = (await answer.text()).trim();
    } catch { words = "The server does not answer."; }
    if (words) return sheet(title, "fs-ask").append(make("p", "", words));
    openTab();
    bring(part);
  };
  const sweep = (name) => choose("over", name, "Not swept", ".fs-new-sweep");
  const look = () => {
    const told = document.querySelector("[data-sweeps]");
    const now = told ? told.dataset.sweeps : "";
    if (now !== text) {
      text = now;
      marks = now ? JSON.parse(now) : {};
    }
    for (const uuid in marks) {
      const label = document.querySelector(`label[for="${uuid}"]`);
      if (!label || label.parentElement.querySelector(".fs-sweep-this")) continue;
      const made = button("fs-sweep-this", "sweep", (event) => {
        event.preventDefault();
        event.stopPropagation();
        sweep(marks[made.dataset.slider]);
      });
      made.type = "button";
      made.dataset.slider = uuid;
      made.title = "Sweep this: runs over its values";
      made.setAttribute("aria-label", `Sweep ${label.textContent}`);
      label.after(made);
    }
  };
  document.addEventListener("DOMContentLoaded", () => new MutationObserver(look).observe(
    document.body, { subtree: true, childList: true, attributeFilter: ["data-sweeps"] }));

  const cell = (event) => event.target.closest && event.target.closest("[data-sweep]");
  const show = (found) => open(
    `/sweep/run?sweep=${encodeURIComponent(found.dataset.sweep)}&cell=${found.dataset.cell}`, "");
  let pressed = null;
  document.addEventListener("pointerdown", (event) => {
    const found = event.button === 0 && cell(event);
    pressed = found ? { found, x: event.clientX, y: event.clientY } : null;
  }, true);
  window.addEventListener("pointercancel", () => { pressed = null; }, true);
  document.addEventListener("pointerup", (event) => {
    if (pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 6) show(pressed.found);
    pressed = null;
  }, true);
  document.addEventListener("keydown", (event) => {
    const found = (event.key === "Enter" || event.key === " ") && cell(event);
    if (!found) return;
    event.preventDefault();
    event.stopPropagation();
    show(found);
  }, true);
  document.addEventListener("click", (event) => {
    const pressed = event.target.closest && event.target.closest("button");
    if (pressed && pressed.dataset.sweepName) choose("show", pressed.dataset.sweepName, "Not shown", ".fs-sweeps");
    if (pressed && pressed.textContent === "Start the sweep") bring(".fs-sweeps");
  }, true);
}
