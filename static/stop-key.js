/* The emergency stop in the browser. Its keys work wherever the focus is: viser leaves keys alone
   that are typed into a field, and those that are pressed with Shift, Ctrl or Alt. Keys and buttons
   send the stop by a request of its own as well, which waits for none of viser's messages; until
   one has arrived it is sent again. */
if (!window.flockscopeStopKey) {
  window.flockscopeStopKey = true;
  const stopKeys = { Space: " ", Escape: "Escape" };
  const label = "EMERGENCY STOP";
  const tries = 10, patience = 400;
  const way = location.pathname.replace(/\/(index\.html)?$/, "") + "/emergency";
  let underWay = false;
  const wait = (time) => new Promise((done) => setTimeout(done, time));
  const send = async () => {
    const given = new AbortController();
    const late = setTimeout(() => given.abort(), patience);
    try {
      const answer = await fetch(way, {
        method: "POST", headers: { "X-Flockscope": "stop" }, cache: "no-store",
        credentials: "same-origin", keepalive: true, signal: given.signal });
      return answer.ok;
    } catch { return false; } finally { clearTimeout(late); }
  };
  const stop = async () => {
    if (underWay) return;
    underWay = true;
    for (let k = 0; k < tries && !await send(); k++) await wait(100);
    underWay = false;
  };
  const pass = (code) => document.documentElement.dispatchEvent(
    new KeyboardEvent("keydown", { key: stopKeys[code], code: code, bubbles: true }));
  const down = (event) => {
    if (!event.isTrusted || !(event.code in stopKeys)) return;
    if (!event.repeat) stop();
    const field = event.target.closest && event.target.closest("input, textarea, select");
    const held = event.shiftKey || event.ctrlKey || event.altKey || event.metaKey;
    if (!field && !held) return;
    if (event.code === "Space") { event.preventDefault(); event.stopPropagation(); }
    if (field) field.blur();
    pass(event.code);
  };
  const up = (event) => { if (event.isTrusted && event.code === "Space") event.preventDefault(); };
  const pressed = (event) => {
    const button = event.target.closest && event.target.closest("button");
    const stops = button && (button === large || button.textContent.trim() === label);
    if (event.isTrusted && stops) stop();
  };
  /* It stands on the picture whatever the panels show, and when they are folded away. */
  const large = document.createElement("button");
  large.className = "fs-stop";
  large.textContent = "STOP";
  large.title = "Emergency stop of all cars: Space and Esc do the same";
  document.addEventListener("DOMContentLoaded", () => document.body.append(large));
  window.addEventListener("keydown", down, true);
  window.addEventListener("keyup", up, true);
  window.addEventListener("pointerdown", pressed, true);
  window.addEventListener("click", pressed, true);
}
