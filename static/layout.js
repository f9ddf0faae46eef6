/* How the page is laid out. A wide window has its panels at both sides of the picture. A small one has
   the picture first, and beside it a strip with Go and a button for each drawer: the run, the
   monitors, and each tab. At most one drawer is open. What is in a drawer is viser's own sheet for
   small windows, of which page.css shows the part that is wanted. */
{
  const root = document.documentElement;
  const ask = window.matchMedia.bind(window);
  const SMALL = "(max-width: 62em), (max-height: 28em)";
  const small = ask(SMALL), flat = ask("(min-aspect-ratio: 6/5)");
  /* viser's sheet begins at this width: it begins where ours does, so that there is one small layout. */
  window.matchMedia = (query) => ask(query === "(max-width: 36em)" ? SMALL : query);

  const strip = document.createElement("nav");
  strip.className = "fs-strip";
  strip.setAttribute("aria-label", "Panels");
  const slot = document.createElement("i"); /* Go stands there, where a page has one */
  const buttons = new Map();
  let opened = null;

  const sheet = () => document.querySelector('.mantine-Paper-root[style*="20em"]');
  const tabs = () => {
    const list = sheet()?.querySelector(".mantine-Tabs-root > .mantine-Tabs-list");
    return list ? [...list.querySelectorAll("[role=tab]")] : [];
  };
  /* What opens and closes the monitors. Of several tabs it stands beside them while it is open. */
  const monitors = () => sheet()?.querySelector(
    ".mantine-Tabs-root:not(:has(.fs-agent)) [role=button]:is([aria-label^='Expand panel'], [aria-label^='Collapse panel'])");
  const card = () => sheet()?.querySelector(".mantine-Tabs-root:has(.fs-agent)");
  const isShown = (tab) => tab.getAttribute("aria-selected") === "true";
  const setExpanded = (wanted) => {
    const head = monitors();
    if (head && head.getAttribute("aria-label").startsWith("Collapse") !== wanted) head.click();
  };

  /* Open a drawer by its name, or close the one that is open by "". The card of an agent is one, too. */
  const open = (name) => {
    opened = name;
    [...card()?.querySelectorAll("button") ?? []].find((one) => one.textContent.trim() === "Close")?.click();
    if (root.dataset.panels !== "shown") window.dispatchEvent(new Event("flockscope-panels"));
    const tab = tabs().find((one) => one.textContent === name);
    if (tab && !isShown(tab)) tab.click();
    update();
  };
  const nameOf = (head) => head.getAttribute("aria-label").replace(/^\w+ panel /, "");
  const kindOf = (name) => {
    const place = names().indexOf(name);
    return !name ? "none" : place === 0 ? "run" : place === 1 ? "monitors" : "tab";
  };
  const names = () => {
    const first = root.querySelector(".fs-stop") ? "State" : "Run";
    return [first, nameOf(monitors()), ...tabs().map((tab) => tab.textContent)];
  };
  const build = (wanted) => {
    buttons.clear();
    strip.replaceChildren(slot);
    for (const name of wanted) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.addEventListener("click", (event) => {
        open(opened === name ? "" : name);
        if (event.detail > 0) button.blur(); /* keys act on the flock again */
      });
      buttons.set(name, button);
      strip.append(button);
    }
  };
  /* viser forgets how wide the server wants a panel once the panel has been a sheet: it is told again. */
  const widths = new Map();
  let told = 0, isForgotten = false;
  viserClient.onMessage((message) => {
    if (message.type === "GuiSetPanelWidthMessage") widths.set(message.uuid, message.width);
  });
  const restoreWidths = () => {
    if (!isForgotten || !widths.size || !document.querySelector("[data-dock-region=right]")) return;
    isForgotten = false;
    const messages = [...widths].map(([uuid, width]) => (
      { type: "GuiSetPanelWidthMessage", uuid, width, counter: told++, run_id: "layout" }));
    viserClient.show(...messages);
  };
  const update = () => {
    const layout = !small.matches ? "wide" : flat.matches ? "flat" : "tall";
    if (root.dataset.layout !== layout) root.dataset.layout = layout;
    if (layout === "wide") restoreWidths(); else isForgotten = true;
    if (layout === "wide" || !monitors()) {
      if (document.querySelector(".fs-question")) measure();
      return;
    }
    const wanted = names();
    if (wanted.join() !== [...buttons.keys()].join()) build(wanted);
    slot.hidden = !sheet().querySelector('[data-block] svg[class*="tabler-player-p"]');
    /* Where there is room for it the run is open at first; that of cars always. */
    if (opened === null) opened = layout === "tall" && innerHeight > 600 || wanted[0] === "State" ? wanted[0] : "";
    if (opened && !wanted.includes(opened)) opened = "";
    const { panels } = root.dataset;
    const kind = panels === "plots" ? "monitors" : panels === "hidden" ? "none" : card() ? "card" : kindOf(opened);
    /* A tab that something else on the page has opened is the one that is open. */
    if (kind === "tab") opened = tabs().find(isShown)?.textContent ?? opened;
    if (root.dataset.drawer !== kind) root.dataset.drawer = kind;
    setExpanded(kind === "monitors");
    for (const [name, button] of buttons) button.setAttribute("aria-expanded", String(name === opened && kind !== "card"));
    measure();
    watching.takeRecords(); /* of what was just written */
  };
  const measure = () => {
    const box = sheet();
    for (const one of [box, document.querySelector(".fs-question")]) if (one) measuring.observe(one);
    root.style.setProperty("--fs-sheet-high", `${box ? box.offsetHeight : 0}px`);
    const asked = document.querySelector(".fs-question");
    root.style.setProperty("--fs-asked", `${asked ? asked.offsetHeight : 0}px`);
    root.style.setProperty("--fs-strip-high", `${strip.offsetHeight}px`);
    root.style.setProperty("--fs-strip-wide", `${strip.offsetWidth}px`);
  };
  window.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !opened || root.dataset.layout === "wide") return;
    if (event.target.closest?.("input, textarea")) return; /* it closes a list */
    if (document.querySelector(".mantine-Modal-content, .fs-sheet, .fs-stop")) return;
    buttons.get(opened)?.focus();
    open("");
  });
  const measuring = new ResizeObserver(() => measure());
  const watching = new MutationObserver(() => update());
  for (const query of [small, flat]) query.addEventListener("change", update);
  update();
  document.addEventListener("DOMContentLoaded", () => {
    document.body.append(strip);
    measuring.observe(strip);
    watching.observe(root, {
      subtree: true, childList: true, attributes: true,
      attributeFilter: ["aria-selected", "aria-expanded", "aria-label", "data-panels"],
    });
  });
}
