// A student's page whose flock runs in it: what the class says, the sliders that it names, the number
// that it asks for, and its results. It stands behind the scripts of every page of a flock.
(() => {
  let current = null; // the page, once the flock is there
  const { flock, name, sliders, measure } = JSON.parse($("class").textContent);
  const root = document.documentElement, home = location.pathname.replace(/\/(index\.html)?$/, "");
  const make = (kind, style, ...inner) => {
    const made = document.createElement(kind);
    made.className = style;
    made.append(...inner);
    return made;
  };
  const state = make("span", ""), word = make("p", "word"), number = make("output", "");
  const led = make("p", "led", "Your teacher leads: all see this step.");
  const title = make("h2", ""), task = make("p", ""), until = make("small", ""), answer = make("p", "answer");
  const begun = make("p", "begun"), back = make("button", "", "Back to the class’s flock");
  const hand = make("button", "hand", "Hand in my run"), chart = make("div", "fs-chart"), told = make("small", "");
  const live = make("div", "live", number, until);
  const asked = make("div", "card asked", title, task, live, begun, back, hand, answer);
  const plot = make("div", "card plot", make("h2", "", "The class"), told, chart);
  const more = make("details", "card more", make("summary", "", "More"), $("tries"), $("look"), $("charts"), $("saves"));
  for (const one of [word, answer]) one.setAttribute("role", "status");
  number.setAttribute("aria-live", "off"); // it changes with every tick
  asked.hidden = plot.hidden = word.hidden = led.hidden = begun.hidden = back.hidden = true;
  document.querySelector("h1").after(make("p", "who", make("b", "", name), state));
  document.querySelector("header").append(word);
  $("sliders").after(asked, plot, more);
  $("sliders").hidden = !sliders.length;
  more.ontoggle = () => current?.show();

  // What the class does not name has no slider, and nothing proposes to move it.
  const { addSlider, addStep, go, set, key, reset, show, begin } = Page.prototype;
  Object.assign(Page.prototype, {
    addSlider(parameter) {
      if (sliders.includes(parameter.name)) addSlider.call(this, parameter);
      else this.shown[parameter.name] = () => {};
    },
    addStep(step) {
      if (Object.keys(step.set).every((one) => sliders.includes(one))) addStep.call(this, step);
    },
    async begin() {
      const first = this.charts[0];
      if (measure && first?.measure.name === measure.observable)
        live.before(first.canvas.closest(".chart"));
      $("anew").hidden = true; // the class says which seed, and how many agents
      await begin.call(this);
      current = this;
      back.onclick = () => this.card.putBack(0);
      hold(held);
      follow();
      if (!held) this.go(true);
    },
    // An address that says another seed changes nothing.
    beginAnew() { return this.reset(); },
    go(going) { go.call(this, going && !held); },
    set(parameter, value) { if (!held) set.call(this, parameter, value); },
    reset() { return held && current ? undefined : reset.call(this); },
    key(event) { if (!held) key.call(this, event); },
    show() { show.call(this); tell(this); tellBegun(this); },
  });

  // What a step has set that no slider shows is handed in, too.
  let beganWith = 0;
  function tellBegun({ card }) {
    if (!card || card.begun === beganWith) return;
    beganWith = card.begun;
    const set = Object.entries(card.steps[beganWith - 1]?.set ?? {}).filter(([one]) => !sliders.includes(one));
    begun.hidden = back.hidden = !set.length;
    begun.replaceChildren(`Your flock began with step ${beganWith}: `, ...card.describeValues(Object.fromEntries(set)), ".");
  }

  // The number that is asked for, as far as the run is.
  const HOLDS = { ">=": (a, b) => a >= b, "<=": (a, b) => a <= b, ">": (a, b) => a > b, "<": (a, b) => a < b };
  function tell({ state: now, charts }) {
    if (!measure || !now || !charts.length || charts[0].measure.name !== measure.observable) return;
    const few = (value) => !Number.isFinite(value) ? "none" : charts[0].measure.share ? text(value, 3) : plain(value);
    const points = charts[0].points.filter(([tick]) => tick <= measure.ticks);
    if (!points.length) return;
    let so = "";
    if (measure.until) {
      const [sign, bound] = measure.until, { hold: long } = measure;
      let since = null;
      for (const [tick, value] of points) {
        if (!HOLDS[sign](value, bound)) since = null;
        else if ((since ??= tick) <= tick - long + 1) break;
      }
      const holds = since === null ? 0 : points.at(-1)[0] - since + 1;
      number.textContent = holds ? grouped(since) : "not yet";
      if (holds && holds < long) so = `, it holds for ${holds} so far`;
    } else {
      const part = measure.over ? points.filter(([tick]) => tick > points.at(-1)[0] - measure.over) : points.slice(-1);
      number.textContent = few(part.reduce((sum, [, value]) => sum + value, 0) / part.length);
    }
    until.textContent = `${measure.words}: tick ${grouped(Math.min(now.tick, measure.ticks))} of ${grouped(measure.ticks)}${so}`;
  }

  let held = false, ended = false, before = "";
  function hold(now) {
    held = now;
    root.dataset.held = String(held);
    if (held) current?.go(false);
    for (const one of document.querySelectorAll("#go, #step, #reset, #sliders input, #step-control input")) one.disabled = held || !current;
    hand.disabled = held || busy || !current;
    back.disabled = held;
    if (current?.card && current.card.isHeld !== held) current.card.hold(held);
    state.textContent = held ? "held by the teacher" : "";
  }

  const send = (what, body) => fetch(`${home}/class/${what}`, {
    method: "POST", cache: "no-store", credentials: "same-origin", body,
    headers: { "X-Flockscope": "class", "Content-Type": "application/json" },
  });

  // The run is made anew by the class: all that it is told is where the sliders stand, and with which step of
  // the lesson the flock began.
  let busy = false;
  hand.onclick = async () => {
    busy = hand.disabled = true;
    answer.textContent = "Your run is made and measured …";
    const { values, card } = current;
    try {
      const own = Object.fromEntries(sliders.map((one) => [one, values[one]]));
      const reply = await send("hand-in", JSON.stringify({ values: own, step: card?.begun ?? 0 }));
      answer.textContent = (await reply.text()).trim();
    } catch { answer.textContent = "The class does not answer."; }
    busy = false;
    hold(held);
  };

  // The step that the teacher shows, and predictions: the class keeps them, and a page that is loaded again has
  // them from it.
  let lesson = null, isTelling = false, isNews = false;
  const answered = {}; // by step, what the class has answered to, whether or not it took it
  function follow() {
    const card = current?.card;
    if (!card || !lesson) return;
    if (!led.isConnected) {
      $("step-place").after(led);
      card.predicted = tellPredictions;
    }
    led.hidden = !lesson.step;
    card.restore(lesson.predictions);
    card.lead(lesson.step);
    tellPredictions();
  }
  async function tellPredictions() {
    isNews = true;
    if (isTelling) return;
    isTelling = true;
    try {
      while (isNews && lesson && !held) {
        isNews = false;
        await tellEach();
      }
    } catch { setTimeout(tellPredictions, 2000); }
    isTelling = false;
  }
  async function tellEach() {
    for (const [k, { isFixed, choice, result }] of current.card.steps.entries()) {
      const known = lesson?.predictions.find(([number]) => number === k + 1);
      const isKnown = known && known[1] === choice && (result < 0 || known[2] === result);
      const said = JSON.stringify({ step: k + 1, choice, ...(result < 0 ? {} : { shown: result }) });
      if (!isFixed || choice < 0 || isKnown || answered[k] === said) continue;
      const { status } = await send("predict", said);
      if (status === 429) throw new Error("too much at once");
      answered[k] = said;
    }
  }

  const ask = (question) => {
    asked.hidden = !question && !measure;
    hand.hidden = task.hidden = !question;
    title.textContent = question ? question.title : "What to watch";
    if (!question) return;
    if (before !== question.title + question.value) answer.textContent = question.answer;
    before = question.title + question.value;
    task.textContent = question.value === null ?
      `Choose ${question.parameter.toLowerCase()} and watch ${question.measured}.` :
      `Yours: ${question.parameter.toLowerCase()} ${question.value}. Watch ${question.measured}.`;
    hand.textContent = question.handed ? `Hand in again (${question.handed})` : "Hand in my run";
  };

  const results = window.flockscopeResults(home, (found, mine) => {
    plot.hidden = false;
    told.textContent = found.told;
    window.flockscopeChart(chart, found, null, mine);
  });
  const shown = (text, line) => {
    const now = JSON.parse(text);
    if (now.over) {
      ended = true;
      line.close();
      results.end();
      ask(null);
      lesson = null;
      led.hidden = true;
      current?.card?.lead(0);
      hold(Boolean(now.removed));
      state.textContent = now.removed ? "you are no longer in this class" : "the class has ended";
      word.textContent = now.removed ? "The code on the wall lets you in again." : "Your flock stays on this page: go on with it.";
      word.hidden = false;
      return;
    }
    if (now.page !== "flock" || (now.flock && now.flock !== flock)) {
      line.close();
      location.reload(); // another flock, or the teacher's
      return;
    }
    word.textContent = now.word;
    word.hidden = !now.word;
    ask(now.question);
    hold(now.frozen);
    // What was refused because the class was not so far is told again as it goes on.
    if (now.lesson?.step !== lesson?.step) for (const step of Object.keys(answered)) delete answered[step];
    lesson = now.lesson;
    follow();
    results.look(now.plot);
  };
  const listen = () => {
    const line = new EventSource(`${home}/class/mine`);
    line.onmessage = (event) => shown(event.data, line);
    line.onerror = () => {
      if (ended) return;
      state.textContent = "The class does not answer: trying again.";
      if (line.readyState === EventSource.CLOSED) setTimeout(listen, 2000);
    };
  };
  listen();
})();
