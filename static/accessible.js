/* What a screen reader is told of viser's page beyond what its client says: the page's parts and its
   title, what the picture shows, names of fields and buttons that have none, and errors as they come.
   The client writes none of these attributes again: they stay where they are set, until an element
   is made anew. */
{
  const OFTEN = 400;
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const write = (element, name, value) => { if (element.getAttribute(name) !== value) element.setAttribute(name, value); };
  const say = (element, text) => { if (element.textContent !== text) element.textContent = text; };
  const unseen = (kind) => {
    const made = document.createElement(kind);
    made.className = "fs-unseen";
    return made;
  };
  const head = unseen("section"), title = document.createElement("h1"), alarm = unseen("div");
  head.setAttribute("aria-label", "flockscope");
  head.append(title);
  alarm.setAttribute("role", "alert");

  const PARTS = { "[data-dock-region=left]": "Monitors", "[data-dock-region=right]": "Run and settings",
    '.mantine-Paper-root[style*="20em"]': "Panels" };
  const PLAYER = '.mantine-Paper-root:has(> .mantine-ActionIcon-root [class*="tabler-icon-player-"])';
  const NAMES = { ".mantine-Notification-closeButton": "Dismiss this notice", ".mantine-Modal-close": "Close",
    "button:has(.tabler-icon-list-search)": "Commands",
    ".mantine-ActionIcon-root:has(.tabler-icon-player-pause-filled)": "Pause",
    ".mantine-ActionIcon-root:has(.tabler-icon-player-play-filled)": "Play",
    [`${PLAYER} :is(.mantine-NumberInput-input, [role=slider])`]: "Time, s",
    [`${PLAYER} .mantine-Select-input`]: "Speed" };
  const nameParts = () => {
    const page = document.getElementById("root");
    if (page) write(page, "role", "main");
    for (const [part, name] of Object.entries(PARTS)) for (const found of all(part)) {
      write(found, "role", "region");
      write(found, "aria-label", name);
    }
  };
  const hasName = (field) => field.getAttribute("aria-label") || field.labels?.length || field.getAttribute("aria-labelledby");
  /* A row of viser's has its words at the left and its fields at the right: a number stands beside
     its slider, and has no name of its own. */
  const nameFields = () => {
    for (const label of all("label[for]")) {
      const row = label.closest(".mantine-Flex-root");
      if (!row || !label.textContent) continue;
      for (const field of all("input:not([type=hidden]), textarea, [role=slider]", row)) {
        if (!hasName(field) || field.dataset.named !== undefined) {
          write(field, "aria-label", label.textContent);
          field.dataset.named = "";
        }
      }
    }
    for (const [which, name] of Object.entries(NAMES)) for (const found of all(which)) write(found, "aria-label", name);
  };

  const row = (name) => {
    const card = all(".fs-card").find((one) => one.firstChild.textContent === name);
    const line = all(".fs-pair tr").find((one) => one.firstChild.textContent === name);
    const values = card ? [card.lastChild] : line ? [...line.children].slice(1) : [];
    return values.map((value) => value.textContent).join(" and ");
  };
  const describePicture = () => {
    const picture = document.querySelector("canvas[data-engine]");
    if (!picture) return;
    const state = document.querySelector(".fs-caption")?.textContent, cars = all(".fs-cars tr:has(td)").length;
    const agents = row("agents"), tick = row("tick");
    const told = document.querySelector(".told")?.innerText.trim().replace("\n", ", "); /* of a recording */
    const parts = [told, state, cars && `${cars} cars`, agents && `${agents} agents`, tick && `tick ${tick}`];
    write(picture, "role", "img");
    write(picture, "aria-label", `Picture: ${parts.filter(Boolean).join(", ") || "nothing yet"}`);
  };
  const look = () => {
    nameParts();
    nameFields();
    describePicture();
    say(title, document.title);
    say(alarm, all(".fs > .fs-error, .fs-banner:is(.fs-emergency, .fs-failed) b").map((one) => one.textContent).join(" "));
  };
  document.addEventListener("DOMContentLoaded", () => {
    if (!document.querySelector("h1")) document.body.prepend(head);
    document.body.append(alarm);
    setInterval(look, OFTEN);
  });
}
