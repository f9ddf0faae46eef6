/* The card of an agent opens beside it, in each browser by its own camera, and moves aside when the
   agent comes under it; elsewhere it stays where it is, also where somebody has dragged it. The card
   says where on the display its agent is; the camera is what viser's client tells the server of it.
   viser places its own window: it is given the message that a server would send. */
{
  const root = document.documentElement;
  const AWAY = 26, CLEAR = 14, EDGE = 8, TOOLS = 52, SHORT = 160, REST = 1500;
  let camera = null, sent = 0, shown = null, dragged = false, pressed = null, moved = 0;

  viserClient.onSend((message) => { if (message.type === "ViewerCameraMessage") camera = message; });

  const windowOf = (card) => card && card.closest("[data-floating-window]");
  const canvas = () => document.querySelector("canvas[data-engine]").getBoundingClientRect();
  /* Where the agent is on the screen; null where this browser does not see it. */
  const seen = (card) => {
    const at = (card.dataset.at || "").split(" ").map(Number), area = canvas();
    if (!camera || at.length !== 3 || at.some(Number.isNaN)) return null;
    const [w, x, y, z] = camera.wxyz, [a, b, c] = at.map((one, axis) => one - camera.position[axis]);
    const right = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c;
    const down = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c;
    const ahead = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c;
    const scale = 0.5 * area.height / Math.tan(0.5 * camera.fov) / ahead;
    const here = { x: area.left + 0.5 * area.width + right * scale, y: area.top + 0.5 * area.height + down * scale };
    const inside = here.x > area.left && here.x < area.right && here.y > area.top && here.y < area.bottom;
    return ahead > 0 && inside ? here : null;
  };
  const covers = (box, here) => here !== null && here.x > box.x - CLEAR && here.x < box.x + box.w + CLEAR
    && here.y > box.y - CLEAR && here.y < box.y + box.h + CLEAR;
  const between = (value, low, high) => Math.max(low, Math.min(value, Math.max(low, high)));

  /* The place for a card of this size: beside the agent, on the side with room. One that the agent
     has come under, or that shows nobody in sight, goes to the corner that is farthest off; one that
     has grown stays where it was, if it can. */
  const place = (area, here, w, tall, before) => {
    const box = (x, y, h) => ({ x: between(x, area.left, area.right - w), y: between(y, area.top, area.bottom - h), w, h });
    const from = here || { x: 0.5 * (area.left + area.right), y: 0.5 * (area.top + area.bottom) };
    const h = Math.min(tall, area.bottom - area.top);
    const corners = [area.right, area.left].flatMap((x) => [area.top, area.bottom].map((y) => box(x, y, h)));
    const far = (one) => Math.hypot(one.x + 0.5 * one.w - from.x, one.y + 0.5 * one.h - from.y);
    corners.sort((one, other) => far(other) - far(one));
    if (here === null) return before ? box(before.x, before.y, h) : corners[0];
    const sides = [
      box(here.x + AWAY, here.y - h / 3, h), box(here.x - AWAY - w, here.y - h / 3, h),
      box(here.x - w / 2, here.y + AWAY, h), box(here.x - w / 2, here.y - AWAY - h, h),
    ];
    const wanted = before ? [box(before.x, before.y, h), ...corners, ...sides] : [...sides, ...corners];
    const found = wanted.find((one) => !covers(one, here));
    if (found) return found;
    /* There is no room for all of it: the card is shortened, above or below. */
    const under = area.bottom - here.y - AWAY, over = here.y - AWAY - area.top;
    const low = Math.max(under, over, SHORT);
    return box(here.x - w / 2, under >= over ? area.bottom - low : area.top, low);
  };

  const put = (card, frame, here, again) => {
    const whole = canvas(), now = frame.getBoundingClientRect();
    const area = { left: whole.left + TOOLS, right: whole.right - EDGE, top: whole.top + TOOLS, bottom: whole.bottom - EDGE };
    if (area.right - area.left < now.width) area.left = whole.left + EDGE;
    root.style.setProperty("--fs-card", "none");
    const tall = frame.getBoundingClientRect().height;
    const to = place(area, here, now.width, tall, again ? now : null);
    root.style.setProperty("--fs-card", to.h < tall ? `${to.h}px` : "none");
    const position = { kind: "float", x: Math.max(0, to.x - whole.left), y: Math.max(0, to.y - whole.top) };
    const uuid = card.dataset.panel;
    viserClient.show({ type: "GuiSetPanelPositionMessage", uuid, position, counter: sent++, run_id: "card" });
    moved = performance.now();
  };

  root.setAttribute("data-card", "waits");
  setInterval(() => {
    const card = document.querySelector(".fs-agent"), frame = windowOf(card);
    if (!frame || !viserClient.isThere()) {
      shown = null;
      root.setAttribute("data-card", "waits");
      return;
    }
    const here = seen(card), box = frame.getBoundingClientRect();
    if (card.dataset.agent !== shown) {
      shown = card.dataset.agent;
      dragged = false;
      put(card, frame, here, false);
    } else {
      root.setAttribute("data-card", "placed");
      const over = covers({ x: box.x, y: box.y, w: box.width, h: box.height }, here);
      const out = box.bottom > canvas().bottom;
      const free = !dragged && pressed === null && performance.now() > moved + REST;
      if ((over || out) && free) put(card, frame, here, true);
    }
  }, 100);
  /* While a button of the mouse is down it is only moved by hand. */
  const corner = () => {
    const frame = windowOf(document.querySelector(".fs-agent"));
    return frame ? [frame.getBoundingClientRect().x, frame.getBoundingClientRect().y].join() : null;
  };
  window.addEventListener("pointerdown", () => { pressed = corner(); }, true);
  for (const end of ["pointerup", "pointercancel"]) {
    window.addEventListener(end, () => {
      if (pressed !== null && pressed !== corner()) dragged = true;
      pressed = null;
    }, true);
  }
}
