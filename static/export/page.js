// The page of one flock: buttons, sliders, what is measured, and its plot.
const $ = (id) => document.getElementById(id);
const THIN = "\u2009";
const text = (value, digits) => Number(value).toFixed(digits).replace(/^-0(\.0*)?$/, "0$1").replace("-", "\u2212");
const grouped = (value) => String(value).replace(/\B(?=(\d{3})+$)/g, THIN);
const dark = matchMedia("(prefers-color-scheme: dark)");

async function unpack(id) {
  const packed = Uint8Array.from(atob($(id).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Page {
  constructor(module, manifest, image) {
    this.manifest = manifest;
    this.kernel = new Kernel(module, manifest, image);
    this.view = new View($("picture"), manifest);
    this.view.changed = () => this.show();
    this.values = Object.fromEntries(manifest.parameters.map((one) => [one.name, one.value]));
    this.going = false;
    this.owed = 0;
    for (const parameter of manifest.parameters) this.addSlider(parameter);
    $("go").onclick = () => this.go(!this.going);
    $("step").onclick = () => { this.go(false); this.run(1); this.show(); };
    $("reset").onclick = () => this.reset();
    $("save").onclick = () => this.save();
    document.addEventListener("keydown", (event) => this.key(event));
    dark.addEventListener("change", () => this.show());
    addEventListener("resize", () => this.show());
    this.reset();
    for (const name of ["go", "step", "reset", "save"]) $(name).disabled = false;
  }

  addSlider(parameter) {
    const { name, symbol, unit, words, description, low, high, step, value } = parameter;
    const row = $("slider").content.firstElementChild.cloneNode(true), input = row.querySelector("input");
    row.querySelector(".words").textContent = words;
    row.querySelector("i").textContent = symbol;
    row.querySelector("small").textContent = unit === "1" ? "" : unit;
    row.title = description;
    const logarithmic = low > 0 && high / low > 100;
    const digits = Math.max(0, Math.min(6, Math.ceil(-Math.log10(step || (high - low) / 200) - 1e-9)));
    parameter.shown = (number) => {
      row.querySelector("output").textContent = text(number, digits);
      row.classList.toggle("changed", number !== value);
      input.value = logarithmic ? Math.log(number) : number;
    };
    Object.assign(input, logarithmic
      ? { min: Math.log(low), max: Math.log(high), step: (Math.log(high) - Math.log(low)) / 400 }
      : { min: low, max: high, step: step || (high - low) / 400 });
    input.setAttribute("aria-label", `${words}${unit === "1" ? "" : `, ${unit}`}`);
    if (!parameter.slots.length) {
      input.disabled = true;
      row.title = `${description} It cannot be changed in this page.`;
    }
    input.oninput = () => this.set(parameter, logarithmic ? Math.exp(+input.value) : +input.value);
    row.ondblclick = () => this.set(parameter, value);
    $("sliders").append(row);
    parameter.shown(value);
  }

  // Zones that would be out of order are refused, as the laboratory does.
  set(parameter, value) {
    const before = this.values[parameter.name];
    this.values[parameter.name] = value;
    const radii = this.manifest.zones.map((zone) => zone.reduce((sum, [name, times]) => sum + times * this.values[name], 0));
    if (radii.some((radius, k) => k && radius < radii[k - 1] - 1e-12)) {
      this.values[parameter.name] = before;
      this.say(`${parameter.words} stops at ${text(before, 2)}: zones keep their order.`);
    } else {
      this.kernel.set(parameter, value);
      this.say("");
    }
    parameter.shown(this.values[parameter.name]);
  }

  reset() {
    this.go(false);
    this.kernel.reset();
    for (const parameter of this.manifest.parameters)
      if (parameter.slots.length) this.kernel.set(parameter, this.values[parameter.name]);
    this.series = [[0, this.polarisation()]];
    this.say("");
    this.show();
  }

  go(going) {
    this.going = going;
    $("go").textContent = going ? "Pause" : "Go";
    if (going) { this.rate = this.speed(); this.last = performance.now(); requestAnimationFrame((now) => this.frame(now)); }
  }

  frame(now) {
    if (!this.going) return;
    const spent = Math.max(1, now - this.last) / 1000, tick = this.kernel.tick;
    this.owed += Math.min(0.25, spent) * this.speed();
    this.last = now;
    const until = performance.now() + 25; // the picture never waits longer
    while (this.owed >= 1 && performance.now() < until && this.going) { this.run(1); this.owed -= 1; }
    this.owed = Math.min(this.owed, 1);
    this.rate += 0.1 * ((this.kernel.tick - tick) / spent - this.rate);
    this.show();
    requestAnimationFrame((next) => this.frame(next));
  }

  speed() {
    return Math.round(10 ** +$("speed").value);
  }

  run(ticks) {
    try {
      this.kernel.run(ticks);
    } catch (error) {
      this.go(false);
      this.say(`The flock stopped: ${error.message}.`);
      return;
    }
    this.series.push([this.kernel.tick, this.polarisation()]);
  }

  // The length of the mean heading, as agents.observables.order.polarisation.
  polarisation() {
    const heading = this.kernel.view("flock.heading"), { dim, agents } = this.manifest, sum = [0, 0, 0];
    for (let row = 0; row < agents; row++) for (let axis = 0; axis < dim; axis++) sum[axis] += heading[dim * row + axis];
    return Math.min(1, Math.hypot(...sum) / agents);
  }

  say(words) {
    $("say").textContent = words;
  }

  show() {
    this.view.draw(this.kernel.view("flock.position"), this.kernel.view("flock.heading"), dark.matches);
    $("tick").textContent = grouped(this.kernel.tick);
    $("time").textContent = text(this.kernel.tick * this.manifest.dt, 1);
    $("order").textContent = text(this.series.at(-1)[1], 3);
    const behind = this.going && this.rate < 0.8 * this.speed() ? `${Math.round(this.rate)} of ` : "";
    $("pace").textContent = `${behind}${this.speed()} ticks a second`;
    this.plot();
  }

  plot() {
    const canvas = $("plot"), scale = Math.min(devicePixelRatio || 1, 2), pen = canvas.getContext("2d");
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    const style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue(name);
    const left = 30 * scale, right = 8 * scale, top = 8 * scale, bottom = 20 * scale;
    const width = canvas.width - left - right, height = canvas.height - top - bottom;
    const end = Math.max(10, this.series.at(-1)[0]);
    const x = (tick) => left + tick / end * width, y = (value) => top + (1 - value) * height;
    pen.font = `${11 * scale}px system-ui, sans-serif`;
    pen.fillStyle = colour("--soft");
    pen.strokeStyle = colour("--line");
    pen.lineWidth = scale;
    pen.textBaseline = "middle";
    pen.textAlign = "right";
    for (const value of [0, 0.5, 1]) {
      pen.beginPath();
      pen.moveTo(left, y(value));
      pen.lineTo(left + width, y(value));
      pen.stroke();
      pen.fillText(value, left - 6 * scale, y(value));
    }
    pen.textBaseline = "alphabetic";
    pen.fillText(`tick ${grouped(end)}`, left + width, canvas.height - 5 * scale);
    pen.textAlign = "left";
    pen.fillText("0", left, canvas.height - 5 * scale);
    pen.strokeStyle = colour("--accent");
    pen.lineWidth = 2 * scale;
    pen.beginPath();
    const every = Math.ceil(this.series.length / 2000); // more points than the plot has pixels
    for (let k = 0; k < this.series.length; k += every) pen.lineTo(x(this.series[k][0]), y(this.series[k][1]));
    pen.stroke();
  }

  save() {
    const lines = ["tick,polarisation", ...this.series.map((one) => one.join(","))].join("\n");
    const link = Object.assign(document.createElement("a"), {
      href: `data:text/csv;charset=utf-8,${encodeURIComponent(`${lines}\n`)}`,
      download: `${this.manifest.model}-polarisation.csv`,
    });
    link.click();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input, summary")) return;
    if (event.key === " " && !event.target.matches("button")) { event.preventDefault(); this.go(!this.going); }
    if (event.key === "s") $("step").click();
    if (event.key === "r") this.reset();
  }
}

(async () => {
  try {
    const manifest = JSON.parse($("manifest").textContent);
    const [code, image] = await Promise.all([unpack("module"), unpack("memory")]);
    globalThis.page = new Page(await WebAssembly.compile(code), manifest, image);
  } catch (error) {
    $("say").textContent = `This browser cannot run the flock: ${error.message}`;
  }
})();
