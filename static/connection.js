/* Says when the server does not answer, and loads the page again once it does. viser's client tries
   by itself, but only while its window has the focus, and so often that the browser holds its tries
   off: after a while it never comes back. */
{
  const often = 1000, seldom = 5000, patience = 8000, tolerance = 3000, enough = 10000;
  const way = location.pathname.replace(/\/(index\.html)?$/, "") + "/alive";
  let known = null, connected = false, severed = false, well = performance.now();
  let looking = false, due = 0, sign = null;

  /* The name of the server that answers, or null. */
  const answers = async () => {
    const given = new AbortController();
    const late = setTimeout(() => given.abort(), patience);
    try {
      const answer = await fetch(way, {
        cache: "no-store", credentials: "same-origin", signal: given.signal });
      return answer.ok ? await answer.text() : null;
    } catch { return null; } finally { clearTimeout(late); }
  };
  const say = (seconds) => {
    if (sign === null) {
      sign = document.createElement("div");
      sign.className = "fs-lost";
      sign.setAttribute("role", "alert");
      sign.innerHTML = "<div><b>Connection lost, trying again</b><span aria-live='off'></span></div>";
      document.body.append(sign);
    }
    const text = `for ${Math.round(seconds)} s; what is shown is from before`;
    sign.querySelector("span").textContent = text;
  };
  const silence = () => { if (sign !== null) { sign.remove(); sign = null; } };
  /* A class that has ended says so itself: nobody comes back to it. */
  const ended = () => "ended" in document.documentElement.dataset;
  const look = async () => {
    if (looking) return;
    looking = true;
    clearTimeout(due);
    const name = await answers();
    if (ended()) {
      silence();
      return;
    }
    const away = performance.now() - well;
    const another = known !== null && name !== known;
    if (name !== null && away > tolerance && (another || severed || !connected && away > enough)) {
      location.reload();
      return;
    }
    if (name !== null) known = name;
    const lost = name === null || !connected && away > tolerance;
    if (lost) say(away / 1000); else silence();
    if (name !== null && connected) well = performance.now();
    due = setTimeout(look, lost || !connected ? often : seldom);
    looking = false;
  };
  viserClient.onData(({ type }) => {
    if (type === "connected") connected = true;
    if (type !== "closed") return;
    if (connected) { severed = true; well = performance.now(); look(); }
    connected = false;
  });
  window.addEventListener("online", look);
  document.addEventListener("visibilitychange", () => { if (!document.hidden) look(); });
  due = setTimeout(look, seldom);
}
