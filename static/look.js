/* How the page looks in this browser: light or dark, how large its text is, and whether the panels
   are there, as the browser keeps it; and buttons on the picture for all that and for the cameras.
   viser's client takes light or dark from a message of the server, which knows no browser's choice:
   it is written into that message as it comes in, and the message is given to the client again when
   the choice changes. */
{
  const root = document.documentElement;
  const choices = { theme: ["light", "dark"], text: ["M", "L", "S"], panels: ["shown", "plots", "hidden"] };
  const keys = { KeyM: "theme", KeyX: "text", KeyP: "panels" };
  const words = {
    theme: (now) => `Light or dark: now ${now} (key M)`,
    text: (now) => `Size of the text, S, M or L: now ${now} (key X)`,
    panels: (now) => ({
      shown: "Hide the panels but the plots (key P)",
      plots: "Hide the plots, too (key P)",
      hidden: "Show the panels (key P)",
    })[now],
  };
  const drawn = (way) => `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${way}"/></svg>`;
  const signs = {
    theme: () => drawn("M12 3a9 9 0 1 0 0 18V3M12 3a9 9 0 0 1 0 18M12 8h6M12 12h8M12 16h6"),
    text: (now) => drawn("M5 20 12 4l7 16M8 14h8") + now,
    panels: () => drawn("M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5"),
  };
  const cameras = {
    1: "M4 4h16v16H4zM4 12h16M12 4v16",
    2: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM12 12l8-4.5M12 12v9M12 12L4 7.5",
    3: "M2 16h20l-4-6H6zM12 10v6",
    F: "M12 8a4 4 0 1 0 0 8a4 4 0 0 0 0-8M12 2v4M12 18v4M2 12h4M18 12h4",
    B: "M4 20 12 4l8 16-8-5z",
  };
  const buttons = {};
  const kept = (name) => { try { return localStorage.getItem(`flockscope-${name}`); } catch { return null; } };
  const keep = (name, now) => { try { localStorage.setItem(`flockscope-${name}`, now); } catch { } };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let told = null;

  const now = (name) => root.getAttribute(`data-${name}`);
  const set = (name, chosen) => {
    root.setAttribute(`data-${name}`, chosen);
    if (name in buttons) {
      buttons[name].innerHTML = signs[name](chosen);
      buttons[name].title = words[name](chosen);
      buttons[name].setAttribute("aria-label", words[name](chosen));
    }
    if (name === "theme" && told) viserClient.show({ ...told });
  };
  const next = (name) => {
    const among = choices[name];
    const chosen = among[(among.indexOf(now(name)) + 1) % among.length];
    if (name !== "panels") keep(name, chosen);
    set(name, chosen);
  };
  const first = (name) => choices[name].includes(kept(name)) ? kept(name) : choices[name][0];
  set("theme", choices.theme.includes(kept("theme")) ? kept("theme") : dark.matches ? "dark" : "light");
  set("text", first("text"));
  set("panels", "shown");
  dark.addEventListener("change", () => {
    if (kept("theme") === null) set("theme", dark.matches ? "dark" : "light");
  });

  viserClient.onMessage((message) => {
    if (message.type === "RegisterCommandMessage") offerCamera(message.props);
    if (message.type !== "ThemeConfigurationMessage") return;
    message.dark_mode = now("theme") === "dark";
    told = message;
  });
  window.addEventListener("keydown", (event) => {
    const held = event.shiftKey || event.ctrlKey || event.altKey || event.metaKey || event.repeat;
    const field = event.target.closest && event.target.closest("input, textarea, select");
    if (!held && !field && event.code in keys) next(keys[event.code]);
  });

  window.addEventListener("flockscope-panels", () => set("panels", "shown")); /* layout.js opens a drawer */

  /* The buttons stand in the corner of the picture, wherever the panels leave it. */
  const tools = document.createElement("div");
  tools.className = "fs-tools";
  tools.setAttribute("role", "region");
  tools.setAttribute("aria-label", "Look of the page");
  for (const name of ["theme", "text", "panels"]) {
    const button = buttons[name] = document.createElement("button");
    button.type = "button";
    button.addEventListener("click", () => { next(name); button.blur(); });
    tools.append(button);
    set(name, now(name));
  }
  /* Above them, a button for each camera that this page has a key for: it does what the key does. */
  const views = document.createElement("div");
  views.className = "fs-tools fs-views";
  views.setAttribute("role", "region");
  views.setAttribute("aria-label", "Cameras");
  const offerCamera = ({ hotkey, label }) => {
    if (!(hotkey in cameras) || hotkey in buttons) return;
    const button = buttons[hotkey] = document.createElement("button"), digit = /\d/.test(hotkey);
    button.type = "button";
    button.innerHTML = drawn(cameras[hotkey]);
    button.title = `${label} (key ${hotkey})`;
    button.setAttribute("aria-label", button.title);
    const pressed = { key: hotkey.toLowerCase(), code: (digit ? "Digit" : "Key") + hotkey, bubbles: true };
    button.addEventListener("click", (event) => {
      document.body.dispatchEvent(new KeyboardEvent("keydown", pressed));
      if (event.detail > 0) button.blur();
    });
    views.append(button);
    views.append(...Object.keys(cameras).filter((key) => key in buttons).map((key) => buttons[key]));
  };
  /* What stands at the top of the panels: seen while that is hidden, and told to who hears the page. */
  const caption = document.createElement("div");
  caption.className = "fs-caption";
  caption.setAttribute("role", "status");
  setInterval(() => {
    const said = document.querySelector(".fs-banner b, .fs-status > span:not(.fs-dot), .fs > .fs-error");
    const text = [...said ? said.childNodes : []]
      .filter((part) => !(part.classList && part.classList.contains("fs-compiling")))
      .map((part) => part.textContent).join("");
    if (caption.textContent !== text) caption.textContent = text;
  }, 250);
  const place = (canvas) => {
    const at = canvas.getBoundingClientRect();
    root.style.setProperty("--fs-left", `${at.left}px`);
    root.style.setProperty("--fs-right", `${innerWidth - at.right}px`);
    root.style.setProperty("--fs-bottom", `${innerHeight - at.bottom}px`);
    root.style.setProperty("--fs-middle", `${(at.left + at.right) / 2}px`);
  };
  const find = () => {
    const canvas = document.querySelector("canvas[data-engine]");
    if (canvas === null) return;
    looking.disconnect();
    const placing = new ResizeObserver(() => place(canvas));
    placing.observe(canvas);
    placing.observe(root);
  };
  const looking = new MutationObserver(find);
  document.addEventListener("DOMContentLoaded", () => {
    document.body.append(tools, views, caption);
    looking.observe(document.body, { childList: true, subtree: true });
  });
}
