// Has a kernel run in a worker, so that the picture never waits for it; where a page may have none,
// on the page's own thread. One request after the other: each is answered by how the flock stands.
class Runner {
  constructor(module, manifest, image) {
    this.kernel = this.build(module, manifest, image);
    this.manifest = manifest;
    this.shown = [];
    this.rest = {};
    this.labelled = {};
    this.rows = [];
  }

  build(...program) {
    const kernel = new Kernel(...program);
    this.starter = new Starter(kernel);
    return kernel;
  }

  // Do what is asked for, in the order of these names; `budget` is the most time to run in, ms. A `trial` ends
  // the run at a tick, and has one measure taken at each tick after another one.
  answer({ ticks = 0, budget = Infinity, set = [], reset = false, start, shown, colour, heading, trial }) {
    const { kernel } = this;
    let error = "";
    if (reset) kernel.reset();
    if (heading) this.steer(heading);
    const { measures } = this.manifest;
    if (shown) this.shown = shown.map((name) => measures.find((one) => one.name === name)).filter(Boolean);
    this.rows = [];
    const until = performance.now() + budget;
    let ran = 0;
    const { measure, after, end = Infinity } = trial ?? {}, measured = [];
    try {
      this.set(set);
      if (start) this.begin(start, set);
      while (ran < ticks && kernel.tick < end && (!ran || performance.now() < until)) {
        kernel.run(1);
        ran += 1;
        if (kernel.tick > after) measured.push(kernel.measure(measures.find((one) => one.name === measure)));
        if (ran < ticks) this.measure(true);
      }
    } catch (stopped) {
      error = stopped.message;
    }
    this.measure(false, budget < Infinity);
    const labels = colour in this.manifest.labels ? this.labels(colour, budget < Infinity) : null;
    return { ...this.state(), colour, labels, ran, error, shown: this.shown.map((one) => one.name), rows: this.rows, measured };
  }

  set(values) {
    for (const [name, value] of values) {
      const parameter = this.manifest.parameters.find((one) => one.name === name);
      if (parameter.slots.length || parameter.of) this.kernel.set(parameter, value);
    }
  }

  // Another start; where there is none, the flock stays as the page was made.
  begin(start, set) {
    this.rest = {};
    try {
      this.starter.begin(...start);
    } catch (refusal) {
      this.kernel.reset();
      this.set(set);
      throw refusal;
    }
  }

  // Turn the information agents: they keep a heading that they have.
  steer(heading) {
    const headings = this.kernel.view("flock.heading");
    this.kernel.view("flock.informed").forEach((informed, row) => {
      if (informed) headings.set(heading, heading.length * row);
    });
  }

  // A row of what is shown. What takes long is left out between pictures, and while the flock goes on
  // it rests four times as long.
  measure(between, rests) {
    const row = this.shown.map((measure) => {
      const now = performance.now();
      if (!measure.quick && (between || (rests && now < (this.rest[measure.name] ?? 0)))) return null;
      const value = this.kernel.measure(measure);
      this.rest[measure.name] = performance.now() + 4 * (performance.now() - now);
      return value;
    });
    if (!between || row.some((value) => value !== null)) this.rows.push([this.kernel.tick, ...row]);
  }

  // The group of each agent, 0 the largest, or its layer: what agents are coloured by. It rests as measures do.
  labels(kind, rests) {
    const { kernel } = this, now = performance.now();
    if (rests && now < (this.rest[kind] ?? 0)) return this.labelled[kind];
    kernel.measure(this.manifest.labels[kind]);
    const labels = kernel.view("cells.parent").slice();
    if (kind === "group") {
      const sizes = new Map();
      labels.forEach((of, row) => {
        of = labels[row] = labels[of]; // an agent of a row before, whose own is known
        if (!this.isOut(row)) sizes.set(of, (sizes.get(of) ?? 0) + 1);
      });
      const ranks = [...sizes].sort(([a, many], [b, few]) => few - many || a - b).map(([of], rank) => [of, rank]);
      const rank = new Map(ranks);
      labels.forEach((of, row) => { labels[row] = rank.get(of); });
    }
    this.rest[kind] = performance.now() + 4 * (performance.now() - now);
    return this.labelled[kind] = labels;
  }

  isOut(row) {
    return this.hasCrashed(row);
  }

  hasCrashed(row) {
    const [rows, columns] = this.kernel.arguments["flock.crash_record"].shape;
    return rows > 0 && this.kernel.view("flock.crash_record")[row * columns] >= 0;
  }

  // Copies: the kernel's own arrays move as its memory grows.
  state() {
    const { kernel } = this, copy = (name) => kernel.view(`flock.${name}`).slice();
    return {
      tick: kernel.tick, time: kernel.tick * kernel.read("context.lasts"),
      position: copy("position"), heading: copy("heading"), speed: copy("speed"),
      ids: copy("ids"), informed: copy("informed"),
      crashed: Uint8Array.from({ length: kernel.arguments["flock.ids"].shape[0] }, (_, row) => this.hasCrashed(row)),
      car: this.manifest.car && Object.entries(this.manifest.car).map(([name, side]) => {
        const path = `context.parameters.${name}`;
        return path in kernel.arguments ? kernel.read(path) : side;
      }),
      reach: kernel.read("context.reach"), nearest: kernel.read("context.nearest"),
    };
  }
}

// Asks a runner for its answers: one at a time, as a page draws no more.
class Requests {
  constructor(module, manifest, image) {
    this.kind = manifest.differ ? KindRunner : Runner;
    const classes = [Kernel, Starter, Runner, ...(manifest.differ ? [KindKernel, KindStarter, KindRunner] : [])];
    const source = `"use strict";\n${classes.join("\n")}\nlet runner;
      onmessage = ({ data: { begin, number, request } }) => {
        try {
          if (begin) runner = new ${this.kind.name}(...begin);
          postMessage({ number, answer: runner.answer(request) });
        } catch (error) { postMessage({ number, error: error.message }); }
      };`;
    this.waiting = new Map();
    this.number = 0;
    try {
      const place = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
      this.worker = new Worker(place);
      this.worker.onmessage = ({ data }) => this.take(data);
      this.worker.onerror = (event) => this.lose(event.message, module, manifest, image);
      this.begin = [module, manifest, image];
    } catch {
      this.stay(module, manifest, image);
    }
  }

  // A worker that does not begin is done without; one that ends is told of.
  lose(message, ...program) {
    if (!this.hasAnswered) return this.stay(...program);
    for (const { reject } of this.waiting.values()) reject(new Error(message || "its worker ended"));
    this.waiting.clear();
  }

  // On the page's own thread.
  stay(module, manifest, image) {
    this.worker = null;
    this.runner = new this.kind(module, manifest, image);
    for (const [number, { request }] of this.waiting) this.take({ number, answer: this.runner.answer(request) });
  }

  ask(request) {
    if (!this.worker) return Promise.resolve().then(() => this.runner.answer(request));
    return new Promise((resolve, reject) => {
      const number = this.number++;
      this.waiting.set(number, { resolve, reject, request });
      this.worker.postMessage({ begin: this.begin, number, request });
      this.begin = undefined;
    });
  }

  take({ number, answer, error }) {
    this.hasAnswered = true;
    const { resolve, reject } = this.waiting.get(number);
    this.waiting.delete(number);
    if (error === undefined) resolve(answer);
    else reject(new Error(error));
  }
}
