/* The gallery: what can be opened, as cards with pictures; the scene of the page's address; and the
   run in words to take along. It opens on the picture, by a button there or by G. */
{
  const home = location.pathname.replace(/\/(index\.html)?$/, "");
  const mark = { "X-Flockscope": "scene" };
  const make = (kind, style, text) => {
    const made = document.createElement(kind);
    if (style) made.className = style;
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const button = (style, text, act) => {
    const made = make("button", style, text);
    made.addEventListener("click", act);
    return made;
  };
  const ask = (path) => fetch(home + path, {
    headers: mark, cache: "no-store", credentials: "same-origin" });
  const TOPICS = ["biology", "physics", "robotics", "crowds", "classroom"];  /* of agents.models.declare */
  let shown = null, cards = null, before = null;

  const close = () => {
    if (shown) shown.remove();
    if (shown && before && before.isConnected) before.focus();
    shown = before = null;
  };
  /* A sheet over the page; Escape, a click beside it and its button close it. */
  const sheet = (title, style) => {
    const held = before || document.activeElement;
    close();
    before = held;
    shown = make("div", "fs-sheet");
    const inner = make("div", style), head = make("header");
    head.append(make("h2", "", title), button("fs-close", "Close", close));
    inner.append(head);
    shown.append(inner);
    shown.addEventListener("click", (event) => { if (event.target === shown) close(); });
    shown.setAttribute("role", "dialog");
    shown.setAttribute("aria-label", title);
    shown.setAttribute("aria-modal", "true");
    shown.tabIndex = -1;
    (document.body || document.documentElement).append(shown);
    shown.focus();
    return inner;
  };
  const complain = (inner, words) => {
    const before = inner.querySelector(".fs-wrong");
    if (before) before.remove();
    const wrong = make("p", "fs-wrong", words);
    wrong.setAttribute("role", "alert");
    inner.append(wrong);
  };
  const say = (title, words) => sheet(title, "fs-ask").append(make("p", "", words));

  /* Open a scene; where others watch, only once somebody has said so. `how`: "&sure=1" once that
     is said, "&new=1" of a page that has yet to connect. */
  const open = async (path, how) => {
    let answer;
    try {
      answer = await ask(path + how);
    } catch { return say("Not opened", "The server does not answer."); }
    if (!answer.ok) return say("Not opened", (await answer.text()).trim());
    const { title, asks } = await answer.json();
    if (!asks) {
      const name = new URLSearchParams(path.split("?")[1]).get("scene"), there = `?scene=${encodeURIComponent(name)}`;
      if (name && path.startsWith("/open?") && location.search !== there) history.pushState(null, "", there);
      return close();
    }
    const inner = sheet(`Open “${title}”?`, "fs-ask");
    inner.append(make("p", "", "It replaces the run that others watch too."));
    inner.append(button("fs-main", "Open it for all", () => open(path, "&sure=1")));
    inner.append(button("", "Stay", close));
  };

  window.flockscopeSheet = { make, button, sheet, close, complain, open, ask };  /* others have their own */
  const scene = (name) => `/open?scene=${encodeURIComponent(name)}`;

  /* The picture of a card moves while a mouse is on the card, or it is in focus. */
  const CALM = matchMedia("(prefers-reduced-motion: reduce)");
  const pictureOf = (one, card) => {
    const picture = make("img"), still = `${home}/gallery/${one.picture}`;
    Object.assign(picture, { src: still, alt: "", loading: "lazy", width: 240, height: 160 });
    const move = (event) => {
      if (one.moves && !CALM.matches && event.pointerType !== "touch") picture.src = `${home}/gallery/${one.moves}`;
    };
    const stand = () => { if (!card.matches(":hover, :focus-within")) picture.src = still; };
    card.addEventListener("pointerenter", move);
    card.addEventListener("focusin", move);
    card.addEventListener("pointerleave", stand);
    card.addEventListener("focusout", () => setTimeout(stand));
    return picture;
  };
  const cardOf = (one) => {
    const made = make("div", "fs-entry"), choice = button("fs-choice", "", () => open(scene(one.name), ""));
    choice.append(one.picture ? pictureOf(one, made) : make("i"), make("b", "", one.title), make("span", "", one.line));
    made.append(choice);
    const near = one.related.map((name) => cards.find((other) => other.name === name)).filter(Boolean);
    if (near.length) {
      const line = make("p", "", "See also ");
      near.forEach((other, k) => {
        line.append(k ? " · " : "", button("", other.title, () => open(scene(other.name), "")));
      });
      made.append(line);
    }
    made.dataset.words = 
      [one.title, one.line, one.name, one.group, ...one.tags].join(" ").toLowerCase();
    made.dataset.topics = one.tags.join(" ");
    return made;
  };
  const gallery = async () => {
    const inner = sheet("Gallery", "fs-gallery");
    const search = make("input");
    Object.assign(search, { type: "search", placeholder: "Search scenes, models and worlds" });
    search.setAttribute("aria-label", "Search");
    inner.querySelector("header").insertBefore(search, inner.querySelector(".fs-close"));
    try {
      cards = cards || await (await ask("/gallery.json")).json();
    } catch { return complain(inner, "The server does not answer."); }
    const parts = new Map();
    for (const one of cards) {
      if (!parts.has(one.group)) {
        const part = make("section");
        part.append(make("h3", "", one.group), make("div"));
        parts.set(one.group, part);
        inner.append(part);
      }
      parts.get(one.group).lastChild.append(cardOf(one));
    }
    let topic = "";
    const look = () => {
      const wanted = search.value.toLowerCase().split(/\s+/);
      let found = 0;
      for (const part of parts.values()) {
        const left = [...part.lastChild.children].filter((card) => {
          card.hidden = !wanted.every((word) => card.dataset.words.includes(word)) ||
            !card.dataset.topics.includes(topic);
          return !card.hidden;
        });
        part.hidden = !left.length;
        found += left.length;
      }
      for (const chip of topics.children) chip.setAttribute("aria-pressed", String(chip.value === topic));
      inner.querySelectorAll(".fs-wrong").forEach((one) => one.remove());
      if (!found) complain(inner, `Nothing is called “${search.value}”${topic && ` in ${topic}`}. ` +
        "Try a word such as boids, phase transition, fish, traffic or 3d, or the year of a paper.");
    };
    const topics = make("div", "fs-topics");
    topics.setAttribute("role", "group");
    topics.setAttribute("aria-label", "Topics");
    for (const name of TOPICS) {
      const chip = button("", name, () => { topic = topic === name ? "" : name; look(); });
      chip.value = name;
      topics.append(chip);
    }
    inner.insertBefore(topics, inner.querySelector("section"));
    search.addEventListener("input", look);
    look();
    search.focus();
  };

  const copied = async (field, made) => {
    try { await navigator.clipboard.writeText(field.value); }
    catch { field.select(); document.execCommand("copy"); }
    made.textContent = "Copied";
    setTimeout(() => { made.textContent = "Copy"; }, 1500);
  };
  /* Nobody else reaches a page of this machine's loopback: what they can be given instead. */
  const LOOPBACK = /^(localhost|127(\.\d+){3}|\[::1\])$/;
  const alone = () => {
    const note = make("p", "fs-quiet", "Only this machine opens this address. Give others the line below, or ");
    note.append(button("", "a page that runs by itself", () => window.flockscopeTake()), ".");
    return note;
  };
  const take = async () => {
    const inner = sheet("Share this scene", "fs-share");
    let said;
    try { said = await (await ask("/scene.json")).json(); }
    catch { return complain(inner, "The server does not answer."); }
    const address = said.address.startsWith("?") ?
      location.origin + location.pathname + said.address : said.address;
    for (const [name, text] of [["Address", address], ["Command line", said.command],
      ["Python", said.python]]) {
      const label = make("label", "", name), field = make("textarea");
      Object.assign(field, { value: text, readOnly: true, rows: Math.min(6, text.split("\n").length + 1) });
      const made = button("", "Copy", () => copied(field, made));
      label.append(field);
      inner.append(label, made);
      if (name === "Address" && LOOPBACK.test(location.hostname)) inner.append(alone());
    }
    inner.append(make("p", "", "As a file: Save, Save scene."));
  };

  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && shown) {
      close();
      event.stopPropagation();
    } else if (shown) {
      event.stopPropagation();  /* what is typed here is no key of the laboratory's */
    } else if (event.key.toLowerCase() === "g" && !event.ctrlKey && !event.metaKey && !event.altKey
        && !(event.target.closest && event.target.closest("input, textarea, select"))) {
      event.preventDefault();
      gallery();
    }
  }, true);
  document.addEventListener("DOMContentLoaded", () => {
    const tools = make("nav", "fs-open");
    tools.setAttribute("aria-label", "Scene");
    tools.append(button("", "Gallery", gallery), button("", "Share", take));
    document.body.append(tools);
  });
  setInterval(() => {  /* the tab bears the name of what runs */
    const said = document.querySelector("[data-scene]"), title = said && `${said.dataset.scene} · flockscope`;
    if (title && document.title !== title) document.title = title;
  }, 1000);
  window.addEventListener("popstate", () => {
    const name = new URLSearchParams(location.search).get("scene");
    if (name) open(scene(name), "");
  });
  if (window.flockscopeScene !== null) open(scene(window.flockscopeScene), "&new=1");
}
