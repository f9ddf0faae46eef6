/* Sliders as their parameters want them. viser's is linear over all that is allowed: in its place
   stands one that spans what the server proposes, by logarithms where it says so, and that a double
   click puts back. Only its looks are ours: the value is read from viser's slider, which is still
   there, and given to viser's client and to the server as its slider would do it. */
{
  const patience = 250, rate = 50, slack = 3;
  let text = "", dials = {}, held = null, waiting = null;
  const drawn = new WeakMap(), sent = { at: 0, due: 0, last: null };

  /* At most one message in `rate` ms; the last is always sent. */
  const flush = () => {
    clearTimeout(sent.due);
    if (sent.last === null) return;
    viserClient.send(sent.last);
    sent.at = performance.now();
    sent.last = null;
  };
  const give = (uuid, value) => {
    const slider = document.getElementById(uuid);
    if (!viserClient.isThere() || slider === null || slider.hasAttribute("data-disabled")) return;
    const message = { type: "GuiUpdateMessage", uuid, updates: { value } };
    viserClient.show(message);
    if (sent.last !== null && sent.last.uuid !== uuid) flush();
    clearTimeout(sent.due);
    sent.last = message;
    sent.due = setTimeout(flush, Math.max(0, sent.at + rate - performance.now()));
  };

  const place = ({ log, stops }, value) => {
    const low = stops[0], high = stops[stops.length - 1];
    const at = value <= low ? 0 : log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.min(1, at);
  };
  const nearest = (dial, at) => dial.stops.reduce((best, one) =>
    Math.abs(place(dial, one) - at) < Math.abs(place(dial, best) - at) ? one : best);
  const next = (dial, value, steps) => {
    const above = dial.stops.findIndex((one) => one > value);
    const count = dial.stops.length, first = above < 0 ? count : above;
    const on = first > 0 && dial.stops[first - 1] === value;
    const to = steps > 0 ? first - 1 + steps : first - 1 + steps + (on ? 0 : 1);
    return dial.stops[Math.max(0, Math.min(count - 1, to))];
  };

  const show = (uuid, made, value) => {
    const dial = dials[uuid];
    made.value = value;
    made.root.style.setProperty("--fs-at", place(dial, value));
    made.root.style.setProperty("--fs-usual-at", place(dial, dial.default));
    made.thumb.setAttribute("aria-valuenow", value);
    if (made.dial === dial) return;
    made.dial = dial;
    made.root.toggleAttribute("data-log", dial.log);
    const ends = [dial.stops[0], dial.stops[dial.stops.length - 1]];
    made.ends.forEach((end, k) => { end.textContent = ends[k]; });
    made.thumb.setAttribute("aria-valuemin", ends[0]);
    made.thumb.setAttribute("aria-valuemax", ends[1]);
  };
  const element = (name, kind, inside) => {
    const made = document.createElement(kind);
    made.className = name;
    if (inside) inside.append(made);
    return made;
  };
  const build = (uuid, slider) => {
    const root = element("fs-dial", "div"), rail = element("fs-rail", "div", root);
    element("fs-filled", "i", rail);
    element("fs-usual-mark", "i", rail);
    const thumb = element("fs-thumb", "div", rail);
    const made = { root, rail, thumb, ends: [element("", "span", root), element("", "span", root)] };
    const label = document.querySelector(`label[for="${uuid}"]`);
    thumb.tabIndex = 0;
    thumb.setAttribute("role", "slider");
    thumb.setAttribute("aria-label", label ? label.textContent : "");
    root.dataset.of = uuid;
    root.addEventListener("pointerdown", (event) => take(uuid, made, event));
    root.addEventListener("pointermove", (event) => drag(uuid, made, event));
    thumb.addEventListener("keydown", (event) => step(uuid, made, event));
    slider.before(root);
    drawn.set(slider, made);
    return made;
  };

  const at = (made, x) => {
    const { left, width } = made.rail.getBoundingClientRect();
    return (x - left) / width;
  };
  const take = (uuid, made, event) => {
    if (event.button !== 0 || !event.isPrimary) return;
    event.preventDefault();
    const { left, right } = made.thumb.getBoundingClientRect(), x = event.clientX;
    const on = x >= left - slack && x <= right + slack;
    held = { uuid, made, x, on, by: on ? x - (left + right) / 2 : 0, moved: false };
    made.root.setPointerCapture(event.pointerId);
    made.thumb.focus({ preventScroll: true });
    document.documentElement.setAttribute("data-dragging", "");
  };
  const drag = (uuid, made, event) => {
    if (held === null || held.uuid !== uuid) return;
    held.moved = held.moved || Math.abs(event.clientX - held.x) > slack;
    if (!held.moved) return;
    const value = nearest(dials[uuid], at(made, event.clientX - held.by));
    if (value === made.value) return;
    show(uuid, made, value);
    give(uuid, value);
  };
  /* A click beside the thumb brings it there, once it is no half of a double click. */
  const drop = (event) => {
    if (held === null || !event.isPrimary) return;
    const { uuid, made, on, moved } = held, x = event.clientX;
    held = null;
    document.documentElement.removeAttribute("data-dragging");
    clearTimeout(waiting);
    if (event.type === "pointerup" && !moved && !on)
      waiting = setTimeout(() => { if (uuid in dials) give(uuid, nearest(dials[uuid], at(made, x))); }, patience);
    look();
  };
  /* Wherever that is: a slider may be taken away while it is held. */
  for (const end of ["pointerup", "pointercancel"]) window.addEventListener(end, drop);
  const step = (uuid, made, event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    const { stops } = dials[uuid], end = { Home: stops[0], End: stops[stops.length - 1] }[event.key];
    if (steps === undefined && end === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    give(uuid, end === undefined ? next(dials[uuid], made.value, steps * (event.shiftKey ? 10 : 1)) : end);
  };
  document.addEventListener("dblclick", (event) => {
    const on = event.target.closest && event.target.closest(".fs-dial, label[for]");
    const uuid = on && (on.dataset.of || on.htmlFor);
    if (!uuid || !(uuid in dials)) return;
    clearTimeout(waiting);
    getSelection().removeAllRanges();
    give(uuid, dials[uuid].default);
  });

  const read = () => {
    const told = [...document.querySelectorAll("[data-dials]")].map((one) => one.dataset.dials);
    const now = told.join("\n");
    if (now === text) return;
    text = now;
    dials = Object.assign({}, ...told.map((one) => JSON.parse(one)));
  };
  const look = () => {
    if (held !== null) return;
    read();
    for (const uuid in dials) {
      const slider = document.getElementById(uuid);
      const thumb = slider && slider.querySelector("[role=slider]");
      if (!thumb) continue;
      const made = drawn.get(slider) || build(uuid, slider);
      const value = Number(thumb.getAttribute("aria-valuenow"));
      made.root.toggleAttribute("data-disabled", slider.hasAttribute("data-disabled"));
      if (value !== made.value || dials[uuid] !== made.dial) show(uuid, made, value);
    }
  };
  document.addEventListener("DOMContentLoaded", () => new MutationObserver(look).observe(
    document.body, { subtree: true, childList: true, attributeFilter: ["aria-valuenow", "data-dials", "data-disabled"] }));
}
