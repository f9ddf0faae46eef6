// Runs a flock's page in a dialog when its button is pressed; nothing of it is loaded before.
// The page follows the theme of the site.
document.addEventListener("click", (event) => {
  const button = event.target.closest("button[data-run]");
  if (!button) return;
  const theme = document.documentElement.dataset.theme === "dark" ? "dark" : "light";
  const dialog = document.createElement("dialog");
  const name = button.getAttribute("aria-label").replace(/^Run /, "");
  const title = document.createElement("strong");
  title.textContent = name;
  const close = document.createElement("button");
  close.textContent = "Close";
  const frame = document.createElement("iframe");
  frame.title = name;
  frame.setAttribute("allow", "fullscreen");
  frame.src = `${button.dataset.run}#theme=${theme}`;
  const header = document.createElement("header");
  header.append(title, close);
  dialog.className = "flock-dialog";
  dialog.append(header, frame);
  dialog.addEventListener("close", () => { dialog.remove(); button.focus(); });
  dialog.addEventListener("click", (pressed) => { if (pressed.target === dialog) dialog.close(); });
  close.addEventListener("click", () => dialog.close());
  document.body.append(dialog);
  dialog.showModal();
});
