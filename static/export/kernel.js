// Runs a flock's compiled loop: its memory, its arguments, and the calls that a tick needs, as the
// engines of agents/engine/runner.py make them.
class Kernel {
  // Also in a worker, which is made of the text of this class: so nothing stands outside it.
  static VIEWS = {
    float64: Float64Array, int64: BigInt64Array, uint64: BigUint64Array, int32: Int32Array,
    bool: Uint8Array, uint8: Uint8Array, int8: Int8Array,
  };
  static PAGE = 65536;
  static STACK = 1024 * 1024;
  static SLOT = 8;

  constructor(module, manifest, image) {
    this.manifest = manifest;
    this.image = image;
    this.memory = new WebAssembly.Memory({ initial: Math.ceil((manifest.base + image.length) / Kernel.PAGE) + 2 });
    const env = {
      __linear_memory: this.memory,
      __stack_pointer: new WebAssembly.Global({ value: "i32", mutable: true }, Kernel.STACK),
      __indirect_function_table: new WebAssembly.Table({ initial: 64, element: "anyfunc" }),
      sched_yield: () => 0,
      fmod: (a, b) => a % b,
    };
    for (const name of Object.getOwnPropertyNames(Math))
      if (typeof Math[name] === "function") env[name] = Math[name];
    this.exports = new WebAssembly.Instance(module, { env }).exports;
    this.reset();
  }

  // The flock as the page was made. What is written to slots before (the sliders) is lost.
  reset() {
    this.tick = this.manifest.tick;
    this.scratch = undefined;
    this.top = this.manifest.base + this.image.length;
    new Uint8Array(this.memory.buffer).set(this.image, this.manifest.base);
    this.arguments = {};
    for (const [path, [slot, kind, address, shape]] of Object.entries(this.manifest.arguments))
      this.arguments[path] = { slot, kind, address, shape: [...shape] };
  }

  // Memory grows, and all views of it are void: each is made anew where it is needed.
  view(path) {
    const { kind, address, shape } = this.arguments[path];
    return new Kernel.VIEWS[kind](this.memory.buffer, address, shape.reduce((a, b) => a * b, 1));
  }

  writeDouble(slot, value) {
    new DataView(this.memory.buffer).setFloat64(this.manifest.block + Kernel.SLOT * slot, value, true);
  }

  write(path, value) {
    const { slot, kind } = this.arguments[path];
    const view = new DataView(this.memory.buffer), place = this.manifest.block + Kernel.SLOT * slot;
    if (kind === "float64") view.setFloat64(place, value, true);
    else if (kind === "bool") view.setUint8(place, value);
    else view.setBigInt64(place, BigInt(value), true);
  }

  answer(number) {
    return Number(new BigInt64Array(this.memory.buffer, this.manifest.answer, 8)[number]);
  }

  call() {
    const status = this.exports.advance(this.manifest.block);
    if (status) throw new Error(`the loop ends with ${status}`);
  }

  // Room for so many bytes; its address.
  allot(size) {
    const address = Math.ceil(this.top / 64) * 64;
    this.top = address + size;
    const lacks = this.top + Kernel.PAGE - this.memory.buffer.byteLength;
    if (lacks > 0) this.memory.grow(Math.ceil(lacks / Kernel.PAGE));
    return address;
  }

  // Give an array new room, all zeros, for another shape.
  move(path, shape) {
    const argument = this.arguments[path], bytes = Kernel.VIEWS[argument.kind].BYTES_PER_ELEMENT;
    argument.address = this.allot(Math.max(Kernel.SLOT, bytes * shape.reduce((a, b) => a * b, 1)));
    this.reshape(path, shape);
    this.view(path).fill(argument.kind.includes("64") && argument.kind !== "float64" ? 0n : 0);
  }

  // Give an array another shape where it is.
  reshape(path, shape) {
    const argument = this.arguments[path], bytes = Kernel.VIEWS[argument.kind].BYTES_PER_ELEMENT;
    const size = shape.reduce((a, b) => a * b, 1), axes = shape.length;
    argument.shape = shape;
    const view = new DataView(this.memory.buffer), at = (k) => this.manifest.block + Kernel.SLOT * (argument.slot + k);
    view.setBigInt64(at(2), BigInt(size), true);
    view.setUint32(at(4), argument.address, true);
    let stride = bytes;
    for (let axis = axes - 1; axis >= 0; axis--) {
      view.setBigInt64(at(5 + axis), BigInt(shape[axis]), true);
      view.setBigInt64(at(5 + axes + axis), BigInt(stride), true);
      stride *= shape[axis];
    }
  }

  // Have all that grows with the number of agents be of so many; `change` gives an array another shape.
  resize(n, change) {
    for (const [path, axes] of Object.entries(this.manifest.grows)) {
      // The grid has as many cells as are worth having: agents.engine.arrays.empty_grid.
      const count = path.startsWith("grid.") ? Math.max(64, n) : n;
      const sizes = axes.map(([each, more]) => each * count + more);
      if (this.arguments[path].shape.length) change(path, sizes);
      else this.write(path, sizes[0]);
    }
  }

  // As agents.engine.arrays.empty_workspace.
  widen(capacity) {
    const shape = (name) => this.arguments[`workspace.${name}`].shape;
    for (const name of ["block", "signals", "close", "close_signals"])
      this.move(`workspace.${name}`, [shape(name)[0], capacity]);
    for (const name of ["apart", "chosen"]) this.move(`workspace.${name}`, [capacity]);
    this.move("workspace.spare", [4, Math.max(capacity, shape("found")[0])]);
  }

  refuse(row) {
    const id = this.view("flock.ids")[row];
    throw new Error(`agent ${id} has no place at tick ${this.tick}: its position is no number`);
  }

  run(ticks) {
    const { runner, calls } = this.manifest;
    if (runner !== "turns" && !calls.blow) this.together(ticks);
    else for (let k = 0; k < ticks; k++) {
      this.write("tick", this.tick);
      if (calls.blow) this.draw("blow");
      if (runner !== "turns") this.together(1);
      else this.turns();
    }
  }

  together(ticks) {
    const widens = this.manifest.runner === "synchronous";
    while (ticks > 0) {
      this.write("tick", this.tick);
      this.write("ticks", ticks);
      this.write("context.since", this.tick);
      this.call();
      const done = this.answer(0), bad = this.answer(2), need = widens ? this.answer(3) : 0;
      this.tick += done;
      ticks -= done;
      if (bad >= 0) this.refuse(bad);
      if (need > 0) this.widen(2 * need);
      else if (!done) throw new Error("the loop stands still");
    }
  }

  // Agents act by identity, or in a random order, another in each tick.
  setOrder() {
    const isRandom = "draw_order" in this.manifest.calls;
    if (isRandom) this.draw("draw_order");
    const keys = this.view(isRandom ? "keys" : "flock.ids");
    const rows = [...keys.keys()].sort((a, b) => keys[a] < keys[b] ? -1 : 1);
    this.view("order").set(rows.map(BigInt));
  }

  turns() {
    if (this.manifest.calls.draw_order) this.setOrder();
    this.write("context.since", this.tick);
    const rows = this.arguments.order.shape[0];
    for (let first = 0, opens = 1; ; opens = 0) {
      this.write("first", first);
      this.write("opens", opens);
      this.call();
      first = this.answer(0);
      if (this.answer(1) >= 0) this.refuse(this.answer(1));
      if (first === rows) break;
      this.widen(2 * this.arguments["workspace.block"].shape[1]);
    }
    this.tick += 1;
  }

  // A parameter, and the reach that follows from it.
  set(parameter, value) {
    if (parameter.ticks) this.write("messages.delay", Math.round(value / parameter.ticks));
    else for (const slot of parameter.slots) this.writeDouble(slot, value);
    if (this.manifest.reach === parameter.name) this.write("context.reach", value);
    if (this.exports.reach) this.write("context.reach", this.reach());
  }

  reach() {
    return this.compute("reach", ["context.parameters"]);
  }

  read(path) {
    const { slot, kind } = this.arguments[path];
    const view = new DataView(this.memory.buffer), place = this.manifest.block + Kernel.SLOT * slot;
    return kind === "float64" ? view.getFloat64(place, true) : Number(view.getBigInt64(place, true));
  }

  // The first and the last slot of an argument, or of all that stands under a name.
  slots(name) {
    this.known ??= {};
    return this.known[name] ??= Object.entries(this.arguments)
      .filter(([path]) => path === name || path.startsWith(`${name}.`))
      .map(([, { slot, shape }]) => [slot, slot + (shape.length ? 5 + 2 * shape.length : 1)])
      .reduce(([first, last], [from, to]) => [Math.min(first, from), Math.max(last, to)], [Infinity, 0]);
  }

  // The number that a function gives of some of the arguments, which are copied side by side.
  compute(name, paths) {
    // An array of the last takes at most 11.
    const last = () => Math.max(...Object.values(this.arguments).map((one) => one.slot));
    this.scratch ??= this.allot(Kernel.SLOT * (last() + 18));
    const bytes = new Uint8Array(this.memory.buffer), { block } = this.manifest;
    bytes.copyWithin(this.scratch, block, block + 2 * Kernel.SLOT);
    let place = this.scratch + 2 * Kernel.SLOT;
    for (const path of paths) {
      const [first, last] = this.slots(path);
      bytes.copyWithin(place, block + Kernel.SLOT * first, block + Kernel.SLOT * last);
      place += Kernel.SLOT * (last - first);
    }
    const status = this.exports[name](this.scratch);
    if (status) throw new Error(`${name} ends with ${status}`);
    return new Float64Array(this.memory.buffer, this.manifest.answer, 1)[0];
  }

  // What the flock draws by itself: see agents/web/web_draws.py.
  draw(name) {
    return this.compute(name, this.manifest.calls[name]);
  }

  // One of the manifest's measures, as the observable of that name.
  measure({ export: name, arguments: paths }) {
    this.write("tick", this.tick);
    return this.compute(name, paths);
  }
}
