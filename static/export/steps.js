// Leads a reader through a lesson: a step at a time, with its slider, and a prediction of what a run shows. It
// stands behind the scripts of every page; where the page has no steps it changes nothing.
class StepCard {
  constructor(page, rows) {
    this.page = page;
    this.rows = rows; // of sliders, by parameter
    this.sliders = [...$("sliders").children]; // with what stands above those of a kind
    this.steps = page.manifest.steps.map((step) => ({ ...step, choice: -1, isFixed: false, result: -1, verdict: [] }));
    this.number = 0;
    this.begun = 0; // the number of the step that the flock began with; 0: as the page was made
    this.isHeld = false;
    this.led = 0; // the number of the step that somebody else shows; 0: the reader goes through them
    this.predicted = () => {}; // called when a prediction is made, and when a run has shown something
    this.running = null; // the step whose run goes on, and what is measured of it
    this.build();
    this.show();
  }

  get step() {
    return this.steps[this.number];
  }

  build() {
    const make = (kind, id, ...inner) => {
      const made = Object.assign(document.createElement(kind), { id });
      made.append(...inner);
      return made;
    };
    this.place = make("h2", "step-place");
    this.words = make("p", "step-words");
    // The sentence says what is to be known: to who does not see the picture it would say it twice.
    this.picture = Object.assign(make("img", "step-picture"), { alt: "" });
    const sentence = make("div", "step-sentence", this.place, this.words);
    sentence.setAttribute("aria-live", "polite");
    sentence.setAttribute("aria-atomic", "true");
    this.control = make("div", "step-control");
    this.question = make("legend", "step-question");
    this.answers = make("div", "step-answers");
    this.run = make("button", "step-run");
    this.plan = make("small", "step-plan");
    this.first = make("small", "step-first", "Choose an answer first.");
    this.run.setAttribute("aria-describedby", "step-plan step-first");
    this.progress = make("progress", "step-progress");
    this.progress.setAttribute("aria-label", "Ticks of this run");
    this.prediction = make(
      "fieldset", "step-prediction", this.question, this.answers, this.plan, this.run, this.first, this.progress,
    );
    this.verdict = make("div", "step-verdict");
    this.verdict.setAttribute("role", "status");
    this.back = make("button", "step-back", "Back");
    this.next = make("button", "step-next", "Next");
    this.buttons = make("div", "step-buttons", this.back, this.next);
    const card = make("section", "steps", sentence, this.control, this.prediction, this.verdict, this.buttons);
    card.className = "card";
    card.setAttribute("aria-labelledby", "step-place");
    $("anew").before(card);
    this.run.onclick = () => this.begin();
    this.back.onclick = () => this.moveBy(-1);
    this.next.onclick = () => this.moveBy(1);
  }

  // A button that ends here hands the keyboard to the other one.
  moveBy(by) {
    this.number += by;
    this.show();
    const [pressed, other] = by < 0 ? [this.back, this.next] : [this.next, this.back];
    (pressed.disabled ? other : pressed).focus();
  }

  show() {
    const { step, number, steps } = this;
    this.place.textContent = `Step ${number + 1} of ${steps.length}`;
    this.words.textContent = step.say;
    this.picture.remove();
    if (step.picture) {
      this.picture.src = step.picture;
      this.place.after(this.picture);
    }
    this.back.disabled = !number;
    this.next.disabled = number === steps.length - 1;
    // There is one slider of each parameter: it stands with the step, else among the others.
    $("sliders").prepend(...this.sliders);
    this.control.replaceChildren(...(step.controls ?? []).flatMap((name) => this.rows[name] ?? []));
    this.prediction.hidden = !step.ask;
    this.question.textContent = step.ask ?? "";
    this.answers.replaceChildren(...(step.choices ?? []).map((words, k) => this.makeChoice(words, k)));
    this.plan.replaceChildren(...(step.ask ? this.describeRun(step) : []));
    this.watch(step.watch ?? step.measure);
    this.showState();
  }

  // The first chart shows what the step is about.
  watch(name) {
    const [chart] = this.page.charts, measure = this.page.manifest.measures.find((known) => known.name === name);
    if (!chart || !measure || chart.measure === measure) return;
    chart.canvas.closest(".chart").querySelector("select").value = name;
    chart.show(measure);
    if (this.page.state) this.page.ask({});
  }

  // What the button runs.
  describeRun({ ticks, set = {} }) {
    const values = this.describeValues(set);
    return [`${grouped(ticks)} ticks from the start`, ...(values.length ? [", with ", ...values] : []), "."];
  }

  describeValues(set) {
    return Object.entries(set).flatMap(([name, value], k) => {
      const known = this.page.manifest.parameters.find((parameter) => parameter.name === name);
      const letter = element("i", ""), whose = known?.group ? `${known.group}: ` : "";
      letter.append(...withIndices(known ? known.symbol : name));
      return [...(k ? [", "] : []), whose, letter, ` = ${plain(value)}`];
    });
  }

  makeChoice(words, k) {
    const { step } = this, input = Object.assign(element("input", ""), { type: "radio", name: "step-answer" });
    input.checked = step.choice === k;
    input.onchange = () => {
      step.choice = k;
      this.showState();
    };
    const label = element("label", "");
    label.append(input, element("span", words), element("small", ""));
    return label;
  }

  // What changes while a step is shown.
  showState() {
    const { step } = this, first = this.lacks(step) ? step.than : 0, running = this.running?.step;
    const isRunning = Boolean(running) && (running === step || running === this.steps[step.than - 1]);
    [...this.answers.children].forEach((label, k) => {
      label.firstChild.disabled = step.isFixed;
      const marks = [step.isFixed && k === step.choice && "your prediction", k === step.result && "this run"];
      label.lastChild.textContent = marks.filter(Boolean).join(", ");
    });
    const isChosen = step.isFixed || step.choice >= 0;
    const lack = !isChosen ? "Choose an answer first." : first && !this.led ? `Run step ${first} first.` : "";
    this.run.disabled = lack !== "" || this.isHeld;
    this.run.textContent = first && this.led ? `Run step ${first} first` : step.isFixed ? "Run it again" : "Run it";
    this.first.hidden = !lack;
    this.first.textContent = lack;
    this.progress.hidden = !isRunning;
    if (isRunning) Object.assign(this.progress, { max: running.ticks, value: this.page.state?.tick ?? 0 });
    this.verdict.replaceChildren(...step.verdict.map((words) => element("p", words)));
  }

  // Whether the step is to be compared with one that has shown nothing yet.
  lacks({ than }) {
    return Boolean(than) && this.steps[than - 1].mean === undefined;
  }

  // The step's run, from the start, with its own values: from here on the prediction stays as it is. Who is led
  // cannot go back to a step that it is compared with: that one is run first, without a prediction if there is none.
  async begin() {
    const { page } = this, number = this.lacks(this.step) ? this.step.than : this.number + 1;
    const step = this.steps[number - 1];
    this.cancel("Another run was begun");
    const isReady = this.putBack(number);
    const running = this.running = { step, values: [] };
    page.trial = { measure: step.measure, after: step.ticks / 2, end: step.ticks };
    Object.assign(step, { isFixed: true, result: -1, verdict: [] });
    this.showState();
    this.predicted();
    page.view.canvas.scrollIntoView({ block: "nearest" }); // on a phone it is above
    await isReady;
    if (this.running === running) page.go(true);
  }

  // The flock at its start, with what a step sets, by its number; 0: as the page was made.
  putBack(number) {
    const { page } = this, set = this.steps[number - 1]?.set ?? {};
    for (const { name, value } of page.manifest.parameters) {
      page.values[name] = set[name] ?? value;
      page.shown[name](page.values[name]);
    }
    const [agents, , others] = page.first;
    Object.assign(page, { agents: set.agents ?? agents, others });
    this.begun = number;
    return page.reset();
  }

  // A step that somebody else shows, by its number; 0: the reader's own way.
  lead(number) {
    if (number === this.led) return;
    this.led = number;
    if (number) this.number = number - 1;
    this.buttons.hidden = number > 0;
    this.show();
    if (number) this.place.scrollIntoView({ block: "nearest" });
  }

  // What was predicted before this page was loaded: [the number of the step, choice, what the run showed or null].
  restore(predictions) {
    for (const [number, choice, shown] of predictions) {
      const step = this.steps[number - 1];
      if (step.isFixed && step.choice === choice) continue;
      Object.assign(step, { choice, isFixed: true, result: shown ?? -1 });
      step.verdict = shown === null ? [] : [`Your run showed “${step.choices[shown]}”.`, ...this.compare(step)];
      if (step === this.step) this.show();
    }
  }

  // While the flock is held by somebody else nothing can be begun.
  hold(isHeld) {
    this.isHeld = isHeld;
    this.showState();
  }

  // A run that is another one by now is not judged.
  cancel(why) {
    if (!this.running) return;
    this.running.step.verdict = [`${why}, so this is not the run of this step. It is not judged.`];
    this.end();
  }

  end() {
    this.running = null;
    this.page.trial = undefined;
    this.showState();
  }

  receive({ measured, tick }) {
    if (!this.running) return;
    const { step, values } = this.running;
    values.push(...measured);
    if (tick < step.ticks) return this.showState();
    this.judge(step, values);
    this.end();
    this.verdict.scrollIntoView({ block: "nearest" });
    this.page.go(false);
    this.page.ask({}); // what rested is measured of what is shown
  }

  judge(step, values) {
    const { measure, ticks, bounds, choices, than } = step, name = spoken(measure);
    const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
    if (!Number.isFinite(mean)) {
      step.verdict = [`${name} has no value in this run: it is not judged.`];
      return;
    }
    const { share, unit } = this.page.manifest.measures.find((known) => known.name === measure);
    const few = (value) => `${share ? text(value, 3) : plain(value)}${unit === "1" ? "" : ` ${unit}`}`;
    const first = grouped(ticks - values.length + 1), more = than ? mean - this.steps[than - 1].mean : mean;
    const less = than ? `, ${few(Math.abs(more))} ${more < 0 ? "less" : "more"} than in step ${than}` : "";
    step.mean = mean;
    step.result = bounds.filter((bound) => more >= bound).length;
    step.verdict = [
      `${name}: ${few(mean)}, the mean of ticks ${first} to ${grouped(ticks)}${less}. This run shows “${choices[step.result]}”.`,
      ...this.compare(step),
    ];
    this.predicted();
  }

  // Whether a prediction holds, and why a run shows what it does.
  compare({ choices, choice, result, shows, why }) {
    const verdict = `Your prediction “${choices[choice]}” ${choice === result ? "holds" : "does not hold"}.`;
    return [...(choice < 0 ? [] : [verdict]), ...(why && choices[result] === shows ? [why] : [])];
  }
}

{
  const { addSlider, begin, set, steer, reset, stop, take } = Page.prototype, rows = {};
  Object.assign(Page.prototype, {
    addSlider(parameter) {
      addSlider.call(this, parameter);
      rows[parameter.name] = $("sliders").lastElementChild;
    },
    begin() {
      if (this.manifest.steps) this.card = new StepCard(this, rows);
      return begin.call(this);
    },
    set(parameter, value) {
      const before = this.values[parameter.name];
      set.call(this, parameter, value);
      if (this.values[parameter.name] !== before) this.card?.cancel("You moved a slider");
    },
    steer(heading) {
      steer.call(this, heading);
      this.card?.cancel("You turned the information agent");
    },
    reset() {
      this.card?.cancel("The flock was put back to its start");
      return reset.call(this);
    },
    stop(why) {
      stop.call(this, why);
      this.card?.cancel("The flock stopped");
    },
    take(answer) {
      take.call(this, answer);
      this.card?.receive(answer);
    },
  });
}
