/* The lesson of the class, on the teacher's page: whose step students see, what they predict in it, and
   what their runs showed. */
{
  const { at, make, button, say, changed } = window.flockscopeClass;
  const head = make("div", "fs-row"), body = make("div", "fs-steps");
  let known = null, last = 1; /* the step that was shown last */
  const show = (step) => say({ do: "step", step });
  const own = button("Students go through the steps themselves", () => show(0));
  const led = button("", () => show(known.step || last));
  const back = button("Back", () => show(known.step - 1)), next = button("Next", () => show(known.step + 1));
  const saved = Object.assign(make("a", "fs-button", "Predictions (CSV)"), { href: "class/predictions.csv", download: "" });
  head.append(own, led, back, next, saved);

  const sum = (counts) => counts.reduce((all, count) => all + count, 0);
  const rowOf = (kind, ...words) => {
    const row = make("tr");
    row.append(...words.map((word, k) => make(k ? kind : "th", "", word)));
    return row;
  };
  const stepOf = ({ say: sentence, ask, choices, predicted, shown }, number, students) => {
    const made = make("article", "fs-step"), table = make("table");
    made.append(make("h3", "", `Step ${number}`), make("p", "", sentence));
    if (!ask) return made;
    table.append(rowOf("th", "", "predicted", "runs showed"),
      ...choices.map((choice, k) => rowOf("td", choice, String(predicted[k]), String(shown[k]))));
    made.append(make("b", "", ask), table,
      make("span", "fs-quiet", `${sum(predicted)} of ${students} predicted, ${sum(shown)} ran it`));
    return made;
  };

  let drawn = "";
  changed.push(({ lesson, students }) => {
    const place = at("lesson"), now = JSON.stringify([lesson, students.length]);
    if (now === drawn) return;
    drawn = now;
    known = lesson;
    place.hidden = !lesson;
    if (!lesson) return;
    const { step, steps } = lesson;
    last = Math.min(step || last, steps.length);
    if (!head.isConnected) place.append(head, body);
    own.setAttribute("aria-pressed", String(!step));
    led.setAttribute("aria-pressed", String(step > 0));
    led.textContent = `All students see step ${last} of ${steps.length}`;
    back.hidden = next.hidden = !step;
    back.disabled = step <= 1;
    next.disabled = step === steps.length;
    saved.hidden = !steps.some(({ predicted }) => sum(predicted));
    const shown = steps.map((one, k) => [one, k + 1]).filter(([{ predicted }, number]) => step ? number === step : sum(predicted));
    body.replaceChildren(...shown.map(([one, number]) => stepOf(one, number, students.length)));
  });
}
