/* A person steers an agent: by arrow keys or W, A, S, D, and by a stick on the picture. What is held
   is said to the server eight times a second, and at each change; who is silent for a second has let
   go. So has a window that somebody else is in front of, since it would never hear of a key that is
   let up there. */
{
  const { make, button, ask } = window.flockscopeSheet;
  const START = "Steer this agent", EVERY = 125, SOON = 50, LATE = 3000, FAR = 32;
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  const who = [...bytes].map((one) => one.toString(16).padStart(2, "0")).join("");
  const KEYS = {
    ArrowLeft: ["turn", 1], KeyA: ["turn", 1], ArrowRight: ["turn", -1], KeyD: ["turn", -1],
    ArrowUp: ["lean", 1], KeyW: ["lean", 1], ArrowDown: ["lean", -1], KeyS: ["lean", -1],
    KeyE: ["climb", 1], KeyQ: ["climb", -1] };
  let agent = null, number = 0, timer = null, busy = false, sent = "", last = 0, again = null;
  const held = new Map(), stick = { turn: 0, lean: 0 };
  let panel = null, words = null, knob = null, buttons = null;

  const between = (value) => Math.max(-1, Math.min(1, value));
  const can = (way) => agent !== null && agent.ways.includes(way);
  /* Forwards and back is faster and slower, or up and down where nobody can be faster. */
  const motion = () => {
    const sum = { turn: stick.turn, lean: stick.lean, climb: 0 };
    for (const [way, amount] of held.values()) sum[way] += amount;
    if (!can("push")) sum.climb += sum.lean;
    const all = { turn: sum.turn, push: can("push") ? sum.lean : 0, climb: can("climb") ? sum.climb : 0 };
    for (const way in all) all[way] = (between(all[way]) + 0).toFixed(3).replace("-0.000", "0.000");
    return all;
  };

  const send = async () => {
    if (agent === null) return;
    const mine = agent, now = motion(), text = JSON.stringify(now);
    const up = can("push") ? now.push : now.climb;
    knob.style.transform = `translate(${-FAR * now.turn}px, ${-FAR * up}px)`;
    if ( busy || (text === sent && performance.now() - last < EVERY - 10)) return;
    busy = true; sent = text; last = performance.now();
    let why = "";
    try {
      const query = new URLSearchParams({ who, n: ++number, agent: mine.id, run: mine.run, ...now });
      const answer = await Promise.race([ask(`/steer?${query}`),
        new Promise((_, fail) => setTimeout(fail, LATE))]);
      if (!answer.ok) why = answer.status === 429 ? "" : (await answer.text()).trim();
    } catch { why = "the server does not answer"; }
    busy = false;
    if (agent !== mine) return;
    if (why) stop(why);
    else if (JSON.stringify(motion()) !== sent) setTimeout(send, SOON);
  };

  const show = (text, acts) => {
    words.textContent = text;
    buttons.replaceChildren(...acts);
    panel.toggleAttribute("data-lost", agent === null);
  };
  const build = () => {
    if (panel) return;
    panel = make("section", "fs-steer");
    words = make("p");
    words.setAttribute("role", "status");
    const pad = make("div", "fs-stick");
    pad.setAttribute("role", "img");
    pad.setAttribute("aria-label", "Stick: drag it to steer");
    knob = make("i");
    pad.append(knob);
    const lean = (event) => {
      const box = pad.getBoundingClientRect(), half = box.width / 2;
      let x = (event.clientX - box.left - half) / FAR, y = (event.clientY - box.top - half) / FAR;
      const far = Math.hypot(x, y);
      if (far > 1) { x /= far; y /= far; }
      Object.assign(stick, { turn: -x, lean: -y });
      send();
    };
    pad.addEventListener("pointerdown", (event) => { pad.setPointerCapture(event.pointerId); lean(event); });
    pad.addEventListener("pointermove", (event) => { if (pad.hasPointerCapture(event.pointerId)) lean(event); });
    pad.addEventListener("lostpointercapture", () => { rest(); send(); });
    buttons = make("div");
    panel.append(pad, words, buttons);
    for (const kind of ["pointerdown", "wheel", "touchstart"]) {
      panel.addEventListener(kind, (event) => event.stopPropagation());
    }
    document.body.append(panel);
  };
  const rest = () => Object.assign(stick, { turn: 0, lean: 0 });
  const hold = (name, way, amount) => {
    const one = button("", name, () => {});
    const up = () => { held.delete(name); send(); };
    one.addEventListener("pointerdown", () => { held.set(name, [way, amount]); send(); });
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) one.addEventListener(end, up);
    return one;
  };

  const start = (wanted) => {
    if (agent !== null) letGo();
    build();
    agent = again = wanted;
    held.clear();
    rest();
    panel.hidden = false;
    panel.setAttribute("aria-label", `Steering of agent ${agent.id}`);
    const up = can("climb") && can("push") ? [hold("Climb", "climb", 1), hold("Dive", "climb", -1)] : [];
    show(`You steer agent ${agent.id}`, [...up, button("", "Let go", () => stop(""))]);
    if (document.activeElement) document.activeElement.blur();
    sent = "";
    timer = setInterval(send, EVERY);
    send();
  };
  const letGo = () => {
    clearInterval(timer);
    agent = null;
    held.clear();
    rest();
    const query = new URLSearchParams({ who, n: ++number });
    ask(`/steer/end?${query}`).catch(() => {});
  };
  const stop = (why) => {
    if (agent === null) return;
    const { id } = agent;
    letGo();
    panel.hidden = !why;
    const acts = [button("", "Steer again", () => start(again)), button("", "Close", () => { panel.hidden = true; })];
    if (why) show(`You let go of agent ${id}: ${why}.`, acts);
  };

  document.addEventListener("click", (event) => {
    const found = event.target.closest && event.target.closest("button");
    const card = document.querySelector(".fs-agent[data-steer]");
    if (!found || !card || found.textContent.trim() !== START) return;
    const { steer: id, run, ways } = card.dataset;
    start({ id, run, ways: ways.split(" ") });
  });
  const typed = (target) => target.closest
    && target.closest("input, textarea, select, [contenteditable], [role=slider], .fs-sheet");
  window.addEventListener("keydown", (event) => {
    if (agent === null || event.ctrlKey || event.altKey || event.metaKey || typed(event.target)) return;
    if (event.key === "Escape") stop("");
    else if (event.code in KEYS) held.set(event.code, KEYS[event.code]);
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) send();
  }, true);
  window.addEventListener("keyup", (event) => {
    if (!held.delete(event.code)) return;
    event.stopImmediatePropagation();
    send();
  }, true);
  const lost = () => stop("this window was left");
  window.addEventListener("blur", lost);
  window.addEventListener("pagehide", lost);
  document.addEventListener("visibilitychange", () => { if (document.hidden) lost(); });
}
