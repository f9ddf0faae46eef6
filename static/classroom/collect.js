/* The question of the class, on the teacher's page: asked by a button or by a form, then its results
   as they come in. */
{
  const { at, make, button, say, changed, sheet, close } = window.flockscopeClass;
  let drawn = "", choices = null;

  const chosen = (label, options, now) => {
    const made = make("label", "", label), select = make("select");
    for (const [value, text] of options) select.append(new Option(text, value, false, value === now));
    made.append(select);
    return [made, select];
  };
  const typed = (label, value, kind) => {
    const made = make("label", "", label), field = make("input");
    Object.assign(field, { value, type: kind || "text", required: true, min: 1, max: 20000 });
    made.append(field);
    return [made, field];
  };
  const ask = async (question) => { if (await say({ do: "ask", question })) close(); };
  const HOW = { final: "at the end", over: "mean of the last ticks", until: "ticks until it holds" };
  const form = () => {
    const made = make("form", "fs-form");
    const [a, parameter] = chosen("Parameter", choices.parameters.map((one) =>
      [one.name, `${one.title} ${one.symbol}${one.unit === "1" ? "" : `, ${one.unit}`}`]));
    const [b, values] = typed("Values, in turn; empty: students choose", "");
    values.required = false;
    const [c, observe] = chosen("What is measured", choices.measures.map((one) => [one.name, one.title]));
    const [d, how] = chosen("When", []);
    const [e, condition] = typed("Until", ">= 0.99");
    const [f, over] = typed("Over ticks", "100", "number");
    const [g, ticks] = typed("Ticks of a run", "500", "number");
    const [i, kinds] = chosen("Students play", [["", "all kinds"], ...choices.kinds.length ?
      [[JSON.stringify(choices.kinds), `one kind each: ${choices.kinds.join(", ")}, in turn`]] : [],
      ...choices.kinds.map((kind) => [JSON.stringify([kind]), kind])]);
    i.hidden = !choices.kinds.length;
    const [h, title] = typed("Title", "");
    title.maxLength = 80;
    const fill = () => {
      const one = choices.parameters.find((other) => other.name === parameter.value);
      values.value = one.suggested.join(", ");
      name();
    };
    const name = () => {
      const one = choices.measures.find((other) => other.name === observe.value);
      const before = how.value;
      how.replaceChildren(...one.how.map((kind) => new Option(HOW[kind], kind)));
      if (one.how.includes(before)) how.value = before;
      const x = choices.parameters.find((other) => other.name === parameter.value);
      title.value = `${one.title[0].toUpperCase()}${one.title.slice(1)} against ${x.title.toLowerCase()}`.slice(0, 80);
      show();
    };
    const show = () => {
      e.hidden = how.value !== "until";
      f.hidden = how.value !== "over";
    };
    parameter.addEventListener("change", fill);
    observe.addEventListener("change", name);
    how.addEventListener("change", show);
    const ready = make("button", "fs-main", "Ask it");
    made.append(a, b, c, d, e, f, g, i, h, ready);
    made.addEventListener("submit", (event) => {
      event.preventDefault();
      const measure = how.value === "until" ? { until: `${observe.value} ${condition.value}`, hold: 1 } :
        { observe: observe.value, ...(how.value === "over" ? { over: Number(over.value) } : {}) };
      ask({ title: title.value, parameter: parameter.value, measure, ticks: Number(ticks.value),
        kinds: kinds.value ? JSON.parse(kinds.value) : [],
        values: values.value.split(/[,;\s]+/).filter(Boolean).map(Number) });
    });
    fill();
    return made;
  };
  const offer = async () => {
    try {
      const answer = await fetch("class/choices.json", { credentials: "same-origin", cache: "no-store" });
      choices = await answer.json();
    } catch { return; }
    const inner = make("div", "fs-asking");
    inner.append(make("h2", "", "A question to the class"));
    for (const one of choices.ready) {
      const card = button("", () => ask(one.question), "fs-ready");
      card.append(make("b", "", one.question.title), make("span", "", one.lesson));
      inner.append(card);
    }
    inner.append(make("h3", "", choices.ready.length ? "Or your own" : "Your own"), form());
    inner.append(make("p", "fs-quiet", "All begin anew with the class’s scene, each with a value of their own."));
    inner.append(button("Close", close));
    sheet(inner);
  };
  const link = (text, href) => Object.assign(make("a", "fs-button", text), { href, download: "" });
  const show = (known) => {
    const now = JSON.stringify(known.question) + innerWidth;
    if (now === drawn) return;
    drawn = now;
    const place = at("collect"), question = known.question;
    if (!question) {
      const line = make("div", "fs-row");
      line.append(button("Ask a question", offer, "fs-main"),
        make("span", "fs-quiet", "Each student tries a value; their results draw one plot."));
      place.replaceChildren(line);
      return;
    }
    const words = (one) => one.getAttribute("aria-label") || one.textContent;
    const focused = place.contains(document.activeElement) ? words(document.activeElement) : "";
    const head = make("div", "fs-row"), chart = make("div", "fs-chart"), below = make("div", "fs-row");
    head.append(make("h2", "", question.title), make("span", "fs-quiet", question.told));
    const curve = question.curve ? `curve: sweep ${question.curve.name}` +
      (question.curve.differs.length ? ` (${question.curve.differs.join("; ")})` : "") : "";
    if (question.open) below.append(button("No more results", () => say({ do: "stop-asking" })));
    below.append(button("Ask another", offer));
    if (!question.making) below.append(button(question.curve ? "Make the curve anew" : "Make the curve", () => say({ do: "curve" })));
    below.append(link("CSV", "class/results.csv"), link("PNG", "class/results.png"),
      link("SVG", "class/results.svg"), link("PDF", "class/results.pdf"));
    below.append(make("span", "fs-quiet", [question.open ? "" : "no more results are taken", question.making || curve]
      .filter(Boolean).join("; ")));
    place.replaceChildren(head, chart, below);
    window.flockscopeChart(chart, question, (number) => say({ do: "open-point", points: [number] }));
    const again = focused && [...place.querySelectorAll("button, a, circle")].find((one) => words(one) === focused);
    if (again) again.focus({ preventScroll: true });
  };
  changed.push(show);
  window.addEventListener("resize", () => { const known = window.flockscopeClass.known(); if (known) show(known); });
}
