/* Rows of runs: their buttons ask the server by HTTP, as the gallery does. */
{
  const { make, button, sheet, close, complain, open, ask } = window.flockscopeSheet;

  const attempt = async (act, run, to, inner) => {
    let words = "";
    try {
      const answer = await ask(`/runs/${act}?${new URLSearchParams({ run, to })}`);
      if (!answer.ok) words = (await answer.text()).trim();
    } catch { words = "The server does not answer."; }
    if (words) complain(inner ?? sheet("Not done", "fs-ask"), words);
    else close();
  };
  const acts = {
    open: (run) => open(`/runs/open?run=${run}`, ""),
    show: (run, from) => attempt("show", run, from.getAttribute("aria-checked") === "true" ? "off" : "on"),
    name: (run, from) => {
      const inner = sheet(`Name of run ${run}`, "fs-ask"), form = make("form"), field = make("input");
      field.value = from.dataset.name;
      field.maxLength = 60;
      field.setAttribute("aria-label", "Name");
      const done = button("fs-main", "Name it", () => {});
      done.type = "submit";
      form.append(field, done);
      form.addEventListener("submit", (event) => {
        event.preventDefault();
        attempt("name", run, field.value, inner);
      });
      inner.append(form);
      field.select();
    },
    delete: (run) => {
      const inner = sheet(`Delete run ${run}?`, "fs-ask");
      inner.append(make("p", "", "It leaves the list and the file for good."));
      inner.append(button("fs-main", "Delete it", () => attempt("delete", run, "", inner)));
      inner.append(button("", "Keep it", close));
    } };
  document.addEventListener("click", (event) => {
    const found = event.target.closest && event.target.closest("button[data-act]");
    if (found) acts[found.dataset.act](found.dataset.run, found);
  });
  /* Keys that a button heeds are not the flock's. */
  document.addEventListener("keydown", (event) => {
    const on = event.target.closest && event.target.closest("button[data-act]");
    if (on && (event.key === "Enter" || event.key === " ")) event.stopPropagation();
  }, true);
}
