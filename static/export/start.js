// Draws starts of a flock, as agents/state/start.py does: of a seed and a number of agents.
class Starter {
  constructor(kernel) {
    this.kernel = kernel;
    this.words = kernel.manifest.start;
  }

  // The flock at tick 0. Throws where so many agents do not fit.
  begin(seed, agents) {
    const { kernel, words } = this, { informed } = words, n = agents + informed + words.others;
    kernel.tick = 0;
    kernel.write("seed", seed);
    kernel.resize(n, (path, shape) => kernel.move(path, shape));
    const view = (name) => kernel.view(`flock.${name}`);
    view("ids").forEach((_, row, ids) => { ids[row] = BigInt(row + 1); });
    view("informed").fill(1, 0, informed);
    view("past").fill(NaN);
    view("crash_record").fill(-1);
    let row = 0;
    for (const [value, count] of words.memory) {
      view("memory").fill(Number(value), n * row, n * (row + count));
      row += count;
    }
    this.prepare(n);
    if (words.whole) {
      this.place(0, informed, 0, 0);
      if (words.corner) view("position").fill(0, 0, informed && kernel.manifest.dim);
    }
    const gap = kernel.manifest.calls.start_gap ? kernel.draw("start_gap") : 0;
    this.place(words.whole ? informed : 0, n, words.spacing, Math.max(gap, words.apart));
    this.sort(n, informed);
    this.settle(n, gap);
    kernel.draw("draw_headings");
    this.lead(informed);
    this.speed(n);
    if (kernel.manifest.runner === "turns") kernel.setOrder();
  }

  // What else agents begin with, before they have their places, and once rows follow space.
  prepare() {}
  settle() {}

  // Try places for the rows [first, end) until all fit.
  place(first, end, spacing, gap) {
    this.kernel.view("start.lacks_place").fill(1);
    this.fit(first, end, spacing, gap);
  }

  // The same for those of them that lack a place.
  fit(first, end, spacing, gap) {
    const { kernel } = this;
    for (const [name, value] of Object.entries({ first, end, spacing, gap })) kernel.write(`start.${name}`, value);
    let lack = end - first;
    for (let attempt = 1; lack && attempt <= kernel.manifest.attempts; attempt++) {
      kernel.write("start.attempt", attempt);
      kernel.draw("draw_places");
      lack = kernel.manifest.calls.count_misplaced ? kernel.draw("count_misplaced") : 0;
    }
    if (lack) throw new Error(`${end} agents do not fit: ${lack} found no free place`);
  }

  // Informed agents know where to go: to the first waypoint, or the goal's heading.
  lead(informed) {
    const { dim } = this.kernel.manifest, position = this.kernel.view("flock.position");
    for (let row = 0; row < informed; row++) {
      const { waypoint, goal } = this.words, at = position.subarray(row * dim, (row + 1) * dim);
      const way = waypoint ? waypoint.map((x, axis) => x - at[axis]) : goal;
      const length = waypoint ? Math.sqrt(way.reduce((sum, x) => sum + x * x, 0)) : 1;
      this.kernel.view("flock.heading").set(way.map((x) => x / length), row * dim);
    }
  }

  // Where the world says nothing of speeds `draw_headings` has left the chance that makes each one.
  speed(n) {
    if (this.words.speeds) return;
    const { kernel } = this, isSaid = "start_speed" in kernel.manifest.calls, chance = kernel.view("flock.speed").slice();
    for (let row = 0; row < n; row++) {
      kernel.write("chance", chance[row]);
      if (kernel.arguments.at) kernel.write("at", row);
      const speed = isSaid ? kernel.draw("start_speed") : 0;
      kernel.view("flock.speed")[row] = speed;
    }
  }

  // Let rows follow space, behind those of the informed.
  sort(n, informed) {
    const { kernel } = this, { dim } = kernel.manifest, low = kernel.view("start.low"), side = kernel.view("start.side");
    const position = kernel.view("flock.position"), strips = Math.max(1, ((n - informed) / 4) ** (1 / dim));
    const strip = (row, axis) => Math.floor((position[row * dim + axis] - low[axis]) / side[axis] * strips);
    const keys = Array.from({ length: n }, (_, row) => Array.from({ length: dim }, (_, axis) => strip(row, dim - 1 - axis)));
    const rows = keys.map((_, row) => row).slice(informed).sort((a, b) => {
      const axis = keys[a].findIndex((key, k) => key !== keys[b][k]);
      return axis < 0 ? a - b : keys[a][axis] - keys[b][axis];
    });
    for (const name of ["position", "ids"]) {
      const values = kernel.view(`flock.${name}`), from = values.slice(), width = values.length / n;
      rows.forEach((row, k) => values.set(from.subarray(row * width, (row + 1) * width), (informed + k) * width));
    }
  }
}
