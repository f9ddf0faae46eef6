// Agents that differ: numbers of their own, kinds, relations between them, and who is caught, as agents/individuals.py,
// agents/kinds.py and agents/motion/hunting_motion.py have them. Only pages of such flocks have this.
class KindKernel extends Kernel {
  // As agents/web/web_kinds.py and agents/engine/heeding.py count them.
  static SAME = 0;
  static UNIFORM = 3;
  static EACH = 5;
  static COLUMNS = 6;
  static RADIUS = 2;
  static CATCH = 5;
  static CAUGHT = -1;
  static SEEDS = 2n ** 63n;
  static STRIDE = 0x9E3779B97F4A7C15n;

  reset() {
    super.reset();
    const { draws, kinds } = this.manifest.differ;
    this.draws = draws.map(([column, kind, family, numbers]) => ({ column, kind, family, numbers: [...numbers] }));
    this.kinds = kinds;
    this.now = {}; // values of sliders that were moved
    this.catches = []; // of the last tick: [identity of who was caught, of who caught it]
    this.caught = [...this.manifest.differ.caught]; // how many of each kind so far
  }

  // A number of a slider. Where agents differ it is the mean, or the spread.
  set(parameter, value) {
    const { of: [what, which, cells] = [], name, value: first } = parameter;
    const before = this.now[name] ?? first;
    if (value === before) return;
    if (what === "relation")
      for (const [kind, other, sign] of cells) this.relations()[this.cell(kind, other) + which] = sign * value;
    else if (what) this.redraw(this.draws[which], what, value, value - before);
    this.now[name] = value;
    super.set(parameter, value);
  }

  relations() {
    return this.view("context.relations");
  }

  cell(kind, other) {
    return KindKernel.COLUMNS * (kind * this.kinds.length + other);
  }

  // How far agents notice each other; relations without a radius reach as far as the rule does at most.
  reach() {
    const reach = this.draw("reach"), table = this.relations(), { far } = this.manifest.differ;
    for (const [kind, other] of far) table[this.cell(kind, other) + KindKernel.RADIUS] = reach;
    this.write("together", this.draw("together"));
    return table.reduce((most, value, k) => k % KindKernel.COLUMNS === KindKernel.RADIUS ? Math.max(most, value) : most, reach);
  }

  // Draw anew, as Distribution.about and Distribution.with_moments of agents/individuals.py.
  redraw(draw, what, value, by) {
    const before = draw.numbers, { SAME, UNIFORM, EACH } = KindKernel, middle = 0.5 * (before[0] + before[1]);
    if (draw.family === EACH) return this.shift(draw, by);
    if (what === "spread") draw.numbers = draw.family === UNIFORM ? [middle - value, middle + value] : [before[0], value];
    else if (draw.family < UNIFORM) draw.numbers = draw.family === SAME ? [value] : [value, before[1]];
    else draw.numbers = before.map((number) => number + by);
    try {
      this.fill(draw);
    } catch (refusal) {
      draw.numbers = before;
      this.fill(draw);
      throw refusal;
    }
  }

  // Numbers that were given agent by agent move together.
  shift(draw, by) {
    draw.numbers = draw.numbers.map((number) => number + by);
    const own = this.view("flock.own"), [, wide] = this.arguments["flock.own"].shape;
    for (const row of this.takers(draw)) own[row * wide + draw.column] += by;
  }

  // The rows that have their number of a draw: kinds have their own before that of all.
  takers(draw) {
    const takes = this.takes(draw), kind = this.view("flock.kind"), count = this.arguments["flock.ids"].shape[0];
    return Array.from({ length: count }, (_, row) => row).filter((row) => takes(kind[row] ?? 0));
  }

  takes({ column, kind }) {
    const own = new Set(this.draws.filter((one) => one.kind && one.column === column).map((one) => one.kind));
    return (of) => kind ? of === kind : !own.has(of);
  }

  // Give agents their numbers of one draw.
  fill(draw) {
    const { column, kind, family, numbers } = draw, own = this.view("flock.own");
    const [, wide] = this.arguments["flock.own"].shape, [key, low, high] = this.manifest.differ.columns[column];
    if (family === KindKernel.SAME || family === KindKernel.EACH) {
      const rows = this.takers(draw), count = kind ? rows.length : this.arguments["flock.ids"].shape[0];
      const isListed = family === KindKernel.EACH;
      if (isListed && numbers.length !== count) throw new Error(`there are numbers of ${numbers.length} agents, and ${count} agents`);
      rows.forEach((row, k) => { own[row * wide + column] = numbers[isListed ? (kind ? k : row) : 0]; });
      return;
    }
    const takes = this.takes(draw);
    this.view("draw.takes").forEach((_, k, all) => { all[k] = takes(k - 1) ? 1 : 0; });
    this.view("draw.values").set(numbers);
    const words = { column, family, number: numbers.length, low: low ?? -Infinity, high: high ?? Infinity, key };
    for (const [name, value] of Object.entries(words)) this.write(`draw.${name}`, value);
    if (this.draw("draw_own") < 0) throw new Error(`next to no number drawn is in [${low ?? "-inf"}, ${high ?? "inf"}]`);
  }

  fillAll() {
    for (const draw of this.draws) this.fill(draw);
  }

  // Ticks, and those who are caught at the end of each.
  run(ticks) {
    if (!this.manifest.calls.claim_prey) return super.run(ticks);
    for (let k = 0; k < ticks; k++) {
      this.view("hunt.step").set(this.view("flock.position"));
      super.run(1);
      this.hunt();
    }
  }

  hunt() {
    this.catches = [];
    this.draw("note_steps");
    for (const [hunter, prey, becomes] of this.manifest.differ.catchers) {
      const reach = this.relations()[this.cell(hunter, prey) + KindKernel.CATCH];
      if (!(reach > 0)) continue;
      for (const [name, value] of Object.entries({ hunter, prey, reach })) this.write(`hunt.${name}`, value);
      if (!this.draw("claim_prey")) continue;
      const ids = this.view("flock.ids"), claimed = Array.from(this.view("hunt.claimed"), Number);
      const rows = [...claimed.keys()].filter((row) => claimed[row] >= 0);
      for (const row of rows) this.catches.push([Number(ids[row]), Number(ids[claimed[row]])]);
      this.caught[prey] += rows.length;
      if (becomes === "taken") this.keep([...claimed.keys()].filter((row) => claimed[row] < 0));
      if (becomes === "frozen") for (const row of rows) {
        this.view("flock.kind")[row] = KindKernel.CAUGHT;
        this.view("flock.speed")[row] = 0;
      }
      if (becomes === "moved") this.moveElsewhere(rows);
    }
    this.write("caught", this.read("caught") + this.catches.length);
  }

  // What is of one kind alone is measured as if the others were caught.
  measure(one) {
    if (one.kind === undefined) return super.measure(one);
    const before = this.view("flock.kind").slice(), caught = this.read("caught");
    this.view("flock.kind").forEach((kind, row, all) => { if (kind !== one.kind) all[row] = KindKernel.CAUGHT; });
    this.write("caught", this.caught[one.kind] ?? 0);
    try {
      return super.measure(one);
    } finally {
      this.view("flock.kind").set(before);
      this.write("caught", caught);
    }
  }

  // Let some rows be all there are.
  keep(rows) {
    const before = this.arguments["flock.ids"].shape[0];
    this.resize(rows.length, (path, shape) => {
      if (path.startsWith("flock.") || path === "hunt.step") this.pack(path, rows, before);
      this.reshape(path, shape);
    });
    if (this.manifest.runner === "turns") this.setOrder();
    this.write("context.reach", this.reach());
  }

  // Agents are the memory's last axis, else the first.
  pack(path, rows, before) {
    const view = this.view(path), sides = path === "flock.memory" ? this.arguments[path].shape[0] : 1;
    const wide = view.length / sides / before;
    for (let side = 0; side < sides; side++) rows.forEach((row, k) => {
      const from = (side * before + row) * wide;
      view.copyWithin((side * rows.length + k) * wide, from, from + wide);
    });
  }

  // Who is caught begins anew elsewhere.
  moveElsewhere(rows) {
    const { low, size, dim, block } = this.manifest;
    const seed = new DataView(this.memory.buffer).getBigInt64(block + Kernel.SLOT * this.arguments.seed.slot, true);
    const kept = ["start.low", "start.side", "start.slow", "flock.heading", "flock.speed"].map((path) => [path, this.view(path).slice()]);
    const density = this.read("start.density");
    const lacks = this.view("start.lacks_place").fill(0);
    for (const row of rows) lacks[row] = 1;
    const gap = this.manifest.calls.start_gap ? this.draw("start_gap") : 0;
    this.write("seed", (seed + BigInt(this.tick + 1) * KindKernel.STRIDE) % KindKernel.SEEDS);
    try {
      this.fit(rows, low, size, gap);
      this.view("start.slow").fill(NaN); // of headings the seed alone decides
      this.draw("draw_headings");
    } finally {
      const headings = rows.map((row) => this.view("flock.heading").slice(row * dim, row * dim + dim));
      for (const [path, values] of kept) this.view(path).set(values);
      rows.forEach((row, k) => this.view("flock.heading").set(headings[k], row * dim));
      this.write("start.density", density);
      this.write("seed", seed);
    }
    const memory = this.view("flock.memory"), { length } = this.view("flock.ids");
    this.manifest.differ.memory.forEach((value, column) => {
      for (const row of rows) memory[column * length + row] = Number(value);
    });
  }

  // Try places in a box for some rows until all fit.
  fit(rows, low, side, gap) {
    const { dim } = this.manifest, lacks = this.view("start.lacks_place").fill(0);
    for (const row of rows) lacks[row] = 1;
    this.view("start.low").set(low.slice(0, dim));
    this.view("start.side").set(side.slice(0, dim));
    this.write("start.density", 0);
    const words = { first: 0, end: lacks.length, spacing: 0, gap };
    for (const [name, value] of Object.entries(words)) this.write(`start.${name}`, value);
    let lack = rows.length;
    for (let attempt = 1; lack && attempt <= this.manifest.attempts; attempt++) {
      this.write("start.attempt", attempt);
      this.draw("draw_places");
      lack = this.manifest.calls.count_misplaced ? this.draw("count_misplaced") : 0;
    }
    if (lack) throw new Error(`${rows.length} agents do not fit: ${lack} found no free place`);
  }
}

class KindStarter extends Starter {
  // `others`: of each kind beside the ordinary agents how many there are.
  begin(seed, agents, others) {
    const { kernel } = this, counts = [0, ...others];
    kernel.kinds = kernel.kinds.map((kind, number) => ({ ...kind, agents: counts[number] }));
    this.words = { ...this.words, others: counts.reduce((sum, count) => sum + count, 0) };
    super.begin(seed, agents);
  }

  // Kinds and own numbers follow from identities: the agents of kinds have the last ones.
  prepare(n) {
    const { kernel } = this;
    this.setKinds(n);
    kernel.fillAll();
    kernel.view("start.lacks_place").fill(1); // how far from what is solid they begin is asked for all
  }

  setKinds(n) {
    const { kernel } = this, kind = kernel.view("flock.kind"), ids = kernel.view("flock.ids");
    if (!kind.length) return;
    const last = kernel.kinds.reduceRight((ends, { agents }) => [ends[0] - agents, ...ends], [n]);
    ids.forEach((id, row) => { kind[row] = last.slice(1, -1).filter((end) => Number(id) > end).length; });
  }

  settle(n, gap) {
    const { kernel } = this;
    this.setKinds(n);
    const kind = kernel.view("flock.kind"), rows = (number) => [...kind.keys()].filter((row) => kind[row] === number);
    kernel.kinds.forEach(({ start }, number) => {
      if (start) kernel.fit(rows(number), start[0], start[1].map((high, axis) => high - start[0][axis]), gap);
    });
    kernel.fillAll();
    kernel.write("caught", 0);
    kernel.caught.fill(0);
    kernel.write("context.reach", kernel.reach());
  }
}

class KindRunner extends Runner {
  build(...program) {
    const kernel = new KindKernel(...program);
    this.starter = new KindStarter(kernel);
    return kernel;
  }

  isOut(row) {
    return this.kernel.view("flock.kind")[row] < 0 || super.isOut(row);
  }

  state() {
    const { kernel } = this;
    kernel.draw("reach"); // notes it for each
    const copy = (name) => kernel.view(name).slice(), table = copy("flock.own"), [, wide] = kernel.arguments["flock.own"].shape;
    const own = Object.fromEntries(Object.entries(this.manifest.differ.own).map(([name, column]) =>
      [name, table.filter((_, at) => at % wide === column)]));
    return { ...super.state(), kind: copy("flock.kind"), reaches: copy("reaches"), own };
  }
}
