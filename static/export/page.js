// The page of one flock: buttons, sliders, what is measured, and its charts.
const $ = (id) => document.getElementById(id);
const THIN = "\u2009", MOST_AGENTS = 20000;
const text = (value, digits) => Number(value).toFixed(digits).replace(/^-0(\.0*)?$/, "0$1").replace("-", "\u2212");
const grouped = (value) => String(value).replace(/\B(?=(\d{3})+$)/g, THIN);
// A number in four figures, or whole.
const plain = (value) => Math.abs(value) < 1000
  ? String(+value.toPrecision(4)).replace("-", "\u2212") : grouped(text(value, 0));
// The unit vector of an azimuth, and of a climb in space, in degrees.
function headingOf(angles) {
  const [azimuth, climb = 0] = angles.map((angle) => angle * Math.PI / 180), level = Math.cos(climb);
  return [level * Math.cos(azimuth), level * Math.sin(azimuth), Math.sin(climb)].slice(0, angles.length + 1);
}
// The ends of an axis that begins at 0 where all is above it, in round numbers.
function rounded(most, least) {
  const step = 10 ** Math.floor(Math.log10(Math.max(most - least, 1e-9))) / 2, low = Math.floor(least / step) * step;
  return [low, Math.max(Math.ceil(most / step) * step, low + step)];
}
// Of some points the least and the greatest, as they came; where none has a number, the first.
function extremes(points) {
  const known = points.filter(([, value]) => Number.isFinite(value)), some = known.length ? known : points;
  const least = some.reduce((found, one) => one[1] < found[1] ? one : found);
  const most = some.reduce((found, one) => one[1] > found[1] ? one : found);
  return least === most ? [least] : least[0] < most[0] ? [least, most] : [most, least];
}
const MOST = 4000; // points that a chart keeps: an hour at 1000 ticks a second is 3.6 million
// The page's colours and letters, as somebody has chosen them.
const style = getComputedStyle(document.documentElement);
const colour = (name) => style.getPropertyValue(name);
const letters = (times) => `${times * parseFloat(style.fontSize)}px system-ui, sans-serif`;
// A canvas to save, and its pen.
function sheet(width, height, ground) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height }), pen = canvas.getContext("2d");
  pen.fillStyle = colour(ground);
  pen.fillRect(0, 0, width, height);
  return [canvas, pen];
}
function download(href, name) {
  Object.assign(document.createElement("a"), { href, download: name }).click();
}
const element = (kind, textContent) => Object.assign(document.createElement(kind), { textContent });
// Letters that Unicode has no small ones for stand behind `_` and `^`, as do powers of a unit.
const withIndices = (words) => words.split(/([_^][^\s_^/]+)/).map((part) => {
  const kind = { _: "sub", "^": "sup" }[part[0]];
  return kind ? element(kind, part.slice(1)) : part;
});
const spoken = (name) => name[0].toUpperCase() + name.slice(1).replaceAll("-", " ");

// Of a page of one file it stands in the page; of a page in a folder, in a file beside it.
async function unpack(id) {
  const { file } = $(id).dataset;
  if (file) {
    const answer = await fetch(file);
    if (!answer.ok) throw new Error(`${file} is not there`);
    return new Uint8Array(await answer.arrayBuffer());
  }
  const packed = Uint8Array.from(atob($(id).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// One measure over ticks.
class Chart {
  constructor(page, measure) {
    const row = $("chart").content.firstElementChild.cloneNode(true), [choice] = row.getElementsByTagName("select");
    this.number = row.querySelector("output");
    this.canvas = row.querySelector("canvas");
    for (const one of page.manifest.measures)
      choice.add(new Option(spoken(one.name), one.name, false, one === measure));
    choice.onchange = () => {
      this.show(page.manifest.measures.find((one) => one.name === choice.value));
      page.ask({});
    };
    $("charts").append(row);
    this.show(measure);
  }

  // Of a measure that is chosen later the curve begins then: what was not measured is not drawn.
  show(measure) {
    this.measure = measure;
    this.canvas.title = measure.title;
    this.clear();
  }

  clear() {
    this.points = [];
    this.each = 2; // of so many ticks the least and the greatest are kept: of two, all
    this.number.textContent = "";
  }

  add(tick, value) {
    if (value === null || value === undefined) return;
    if (this.points.at(-1)?.[0] === tick) this.points.pop();
    this.keep([tick, value]);
    if (this.points.length <= MOST) return;
    const points = this.points;
    this.points = [];
    this.each *= 2;
    for (const point of points) this.keep(point);
  }

  // The newest is kept as it is; where three before it are of the same few ticks, their extremes are.
  keep(point) {
    const { points, each } = this, few = (k) => Math.floor(points.at(k)?.[0] / each);
    if (few(-1) === few(-3)) points.push(...extremes(points.splice(-3)));
    points.push(point);
  }

  draw(end) {
    const { canvas } = this, { clientWidth, clientHeight } = canvas, scale = Math.min(devicePixelRatio || 1, 2);
    canvas.width = Math.round(clientWidth * scale);
    canvas.height = Math.round(clientHeight * scale);
    const pen = canvas.getContext("2d"), shown = this.points.length ? this.points.at(-1)[1] : NaN;
    const number = this.measure.share ? text(shown, 3) : plain(shown);
    this.number.textContent = Number.isFinite(shown) ? `${number}${this.unit(" ")}` : "none";
    canvas.setAttribute("aria-label", `${spoken(this.measure.name)}: ${this.number.textContent} at tick ${end}`);
    pen.scale(scale, scale);
    this.paint(pen, clientWidth, clientHeight, end);
  }

  // What stands behind a number or a name.
  unit(before) {
    return this.measure.unit === "1" ? "" : before + this.measure.unit;
  }

  // The axes and the curve.
  paint(pen, wide, tall, end) {
    const { share } = this.measure, known = this.points.filter(([, value]) => Number.isFinite(value));
    const most = known.reduce((found, [, value]) => Math.max(found, value), 0);
    const least = known.reduce((found, [, value]) => Math.min(found, value), 0);
    const [low, high] = share ? [0, 1] : rounded(most, least);
    const marks = [low, (low + high) / 2, high].map((value) => [value, plain(value)]);
    pen.font = letters(0.73);
    const left = Math.max(...marks.map(([, words]) => pen.measureText(words).width)) + 12;
    const width = wide - left - 8, top = 8, height = tall - top - 18, last = Math.max(10, end);
    const x = (tick) => left + tick / last * width, y = (value) => top + (high - value) / (high - low) * height;
    pen.fillStyle = colour("--soft");
    pen.strokeStyle = colour("--line");
    pen.lineWidth = 1;
    pen.textBaseline = "middle";
    pen.textAlign = "right";
    for (const [value, words] of marks) {
      pen.beginPath();
      pen.moveTo(left, y(value));
      pen.lineTo(left + width, y(value));
      pen.stroke();
      pen.fillText(words, left - 6, y(value));
    }
    pen.textBaseline = "alphabetic";
    pen.fillText(`tick ${grouped(last)}`, left + width, tall - 4);
    pen.textAlign = "left";
    pen.fillText("0", left, tall - 4);
    pen.strokeStyle = colour("--accent");
    pen.lineWidth = 2;
    pen.beginPath();
    // Of more points than the plot has pixels the least and the greatest of each few: no peak is left out.
    const few = Math.ceil(known.length / 1000);
    for (let k = 0; k < known.length; k += few)
      for (const [tick, value] of extremes(known.slice(k, k + few))) pen.lineTo(x(tick), y(value));
    pen.stroke();
  }
}

class Page {
  constructor(requests, manifest) {
    this.manifest = manifest;
    this.requests = requests;
    this.view = new View($("picture"), manifest);
    this.view.changed = () => this.show();
    this.values = Object.fromEntries(manifest.parameters.map((one) => [one.name, one.value]));
    this.shown = {}; // shows a value of each parameter
    this.pending = {};
    this.going = false;
    this.busy = 0; // requests that are not answered yet
    this.run = 0; // since which Reset
    $("time").parentElement.hidden = manifest.time_unit === "ticks"; // which stand beside it
    this.charts = manifest.measures.slice(0, 2).map((measure) => new Chart(this, measure));
    for (const parameter of manifest.parameters) this.addSlider(parameter);
    const angles = ["Heading", "Climb"].slice(0, manifest.steered ? manifest.dim - 1 : 0);
    this.angles = angles.map((name) => this.addAngle(name));
    for (const step of manifest.tries) this.addStep(step);
    $("colour").addEventListener("change", () => { if ($("colour").value in manifest.labels) this.ask({}); });
    $("go").onclick = () => this.toggle();
    $("step").onclick = () => { this.go(false); this.ask({ ticks: 1 }); };
    $("reset").onclick = () => this.reset();
    this.kinds = (manifest.differ?.kinds ?? []).slice(1); // beside the ordinary agents
    [this.agents, this.seed, this.others] = this.first;
    $("anew").hidden = !manifest.start;
    $("stays").hidden = !manifest.start?.stays;
    $("agents").onchange = $("seed").onchange = () => this.beginAnew($("agents").value, $("seed").value);
    $("another").onclick = () => this.beginAnew($("agents").value, String(Math.floor(1e6 * Math.random())));
    $("save").onclick = () => this.save();
    $("save-charts").onclick = () => this.saveCharts();
    $("save-picture").onclick = () => this.savePicture();
    document.addEventListener("keydown", (event) => this.key(event));
    // A page of two flocks, or a site that frames this one, may press its buttons.
    addEventListener("message", ({ source, data }) => {
      const presses = {
        go: () => this.go(true), pause: () => this.go(false),
        step: () => $("step").click(), reset: () => this.reset(),
      };
      if (source === parent && parent !== window && Object.hasOwn(presses, data?.press)) presses[data.press]();
    });
  }

  // What the flock began with as the page was made: ordinary agents, seed, and the number of agents of each kind.
  get first() {
    const { start, agents, seed } = this.manifest;
    return [start?.agents ?? agents, seed, this.kinds.map((kind) => kind.agents)];
  }

  // The names of the same in the address.
  get names() {
    return ["agents", "seed", ...this.kinds.map(({ name }) => `${name}.agents`)];
  }

  async begin() {
    const said = new URLSearchParams(location.hash.slice(1)), { names } = this;
    if (!names.some((name) => said.has(name))) await this.reset();
    else {
      const [agents, seed, ...others] = [this.agents, this.seed, ...this.others].map((now, k) => said.get(names[k]) ?? now);
      await this.beginAnew(agents, seed, others);
    }
    for (const name of ["go", "step", "reset", "save", "save-charts", "save-picture"]) $(name).disabled = false;
  }

  // Something to try: a button that sets the sliders, and what one sees once it is pressed.
  addStep({ words, set, see }) {
    const box = element("div", ""), button = element("button", "Do it"), told = element("p", see);
    box.append(element("p", words));
    told.hidden = true;
    if (Object.keys(set).length) box.append(button, told);
    button.onclick = () => {
      for (const parameter of this.manifest.parameters)
        if (parameter.name in set) this.set(parameter, set[parameter.name]);
      told.hidden = false;
      this.go(true);
    };
    $("tries").append(box);
    $("tries").hidden = false;
  }

  addSlider(parameter) {
    const { name, symbol, unit, words, description, low, high, step, value } = parameter;
    const row = $("slider").content.firstElementChild.cloneNode(true), input = row.querySelector("input");
    row.querySelector(".words").textContent = words;
    row.querySelector("i").append(...withIndices(symbol));
    row.querySelector("small").append(...withIndices(unit === "1" ? "" : unit));
    row.title = description;
    const logarithmic = low > 0 && high / low > 100;
    const digits = Math.max(0, Math.min(6, Math.ceil(-Math.log10(step || (high - low) / 200) - 1e-9)));
    const shown = this.shown[name] = (number) => {
      row.querySelector("output").textContent = text(number, digits);
      input.setAttribute("aria-valuetext", `${text(number, digits)}${unit === "1" ? "" : ` ${unit}`}`);
      row.classList.toggle("changed", number !== value);
      input.value = logarithmic ? Math.log(number) : number;
    };
    Object.assign(input, logarithmic
      ? { min: Math.log(low), max: Math.log(high), step: (Math.log(high) - Math.log(low)) / 400 }
      : { min: low, max: high, step: step || (high - low) / 400 });
    input.setAttribute("aria-label", `${words}${unit === "1" ? "" : `, ${unit}`}`);
    if (!parameter.slots.length && !parameter.of) {
      input.disabled = true;
      row.title = `${description} It cannot be changed in this page.`;
    }
    input.oninput = () => this.set(parameter, logarithmic ? Math.exp(+input.value) : +input.value);
    row.ondblclick = () => this.set(parameter, value);
    $("sliders").append(row);
    shown(value);
  }

  // A slider that turns the information agents, in degrees.
  addAngle(name) {
    const row = $("slider").content.firstElementChild.cloneNode(true), input = row.querySelector("input");
    const words = `${name} of the information agent${this.manifest.steered > 1 ? "s" : ""}`;
    row.querySelector(".words").textContent = words;
    row.title = "An information agent listens to nobody: it keeps this heading.";
    Object.assign(input, name === "Climb" ? { min: -90, max: 90 } : { min: 0, max: 359 });
    input.setAttribute("aria-label", `${words}, deg`);
    input.oninput = () => this.steer(headingOf(this.angles.map((one) => +one.input.value)));
    row.ondblclick = () => this.steer(this.start);
    $("sliders").append(row);
    return { input, output: row.querySelector("output") };
  }

  steer(heading) {
    this.turn = heading;
    if (!this.going && !this.busy) this.ask({});
  }

  // What the sliders of the heading say: what it is by now, unless somebody has just moved them.
  showAngles({ informed, heading }) {
    const { dim } = this.manifest, at = dim * informed.indexOf(1), now = heading.slice(at, at + dim);
    this.start ??= now;
    if (this.turn) return;
    this.angles.forEach(({ input, output }, k) => {
      const turn = k ? Math.asin(Math.min(1, Math.max(-1, now[2]))) : Math.atan2(now[1], now[0]);
      const angle = Math.round(turn * 180 / Math.PI);
      input.value = k ? angle : (angle + 360) % 360;
      output.textContent = `${text(input.value, 0)}°`;
    });
  }

  // Zones that would be out of order are refused, as the laboratory does.
  set(parameter, value) {
    const before = this.values[parameter.name];
    this.values[parameter.name] = value;
    if (!this.areZonesInOrder((name) => this.values[name])) {
      this.values[parameter.name] = before;
      this.say(`${parameter.words} stops at ${text(before, 2)}: zones keep their order.`);
    } else {
      this.pending[parameter.name] = value;
      this.say("");
      if (!this.going && !this.busy) this.ask({});
    }
    this.shown[parameter.name](this.values[parameter.name]);
  }

  areZonesInOrder(valueOf) {
    const radius = (zone) => zone.reduce((sum, [name, times]) => sum + times * valueOf(name), 0);
    const radii = this.manifest.zones.map(radius);
    return radii.every((one, k) => !k || one >= radii[k - 1] - 1e-12);
  }

  // Have the flock do something, after what the sliders say by now; its answer is shown.
  async ask(request) {
    const set = Object.entries(this.pending), heading = this.turn;
    const { run } = this;
    this.pending = {};
    this.turn = undefined;
    this.busy += 1;
    try {
      const shown = this.charts.map((one) => one.measure.name);
      const colour = $("colour").value;
      const answer = await this.requests.ask({
        ...request, set: [...(request.set ?? []), ...set], shown, colour, heading, trial: this.trial,
      });
      if (run === this.run) this.take(answer); // what was asked for before a Reset is of another run
      return answer;
    } catch (error) {
      this.stop(error.message);
    } finally {
      this.busy -= 1;
      if (!this.going && !this.busy && (this.turn || Object.keys(this.pending).length)) this.ask({});
    }
  }

  take(answer) {
    this.state = answer;
    // A chart may show another measure by now.
    this.charts.forEach((chart, k) => {
      if (answer.shown[k] === chart.measure.name) for (const row of answer.rows) chart.add(row[0], row[1 + k]);
    });
    if (answer.error) this.stop(answer.error);
    if (this.angles.length) this.showAngles(answer);
    this.show();
  }

  stop(why) {
    this.go(false);
    this.say(`The flock stopped: ${why}.`);
  }

  reset() {
    this.go(false);
    for (const chart of this.charts) chart.clear();
    this.say("");
    this.pending = {};
    this.turn = undefined;
    this.run += 1;
    this.view.clear();
    const { manifest, agents, seed, others } = this;
    Object.assign($("agents"), { value: agents });
    Object.assign($("seed"), { value: seed });
    // At tick 0 what sliders say may count: how fast agents begin, and how far from what is solid.
    const isMoved = !manifest.tick && manifest.parameters.some((one) => this.values[one.name] !== one.value);
    const anew = manifest.start && (isMoved || String([agents, seed, others]) !== String(this.first));
    return this.ask({ reset: true, set: Object.entries(this.values), start: anew ? [seed, agents, others] : undefined });
  }

  // The flock from another start; where there is none, the one before. `others`: of each kind its number of agents.
  async beginAnew(agents, seed, others = this.others) {
    const before = [this.agents, this.seed, this.others], ordinary = this.kinds.length ? "flock" : "Agents";
    const fault = !this.manifest.start ? "This flock has no other start."
      : !/^[1-9]\d{0,4}$/.test(agents) || agents > MOST_AGENTS ? `${ordinary}: 1 to ${grouped(MOST_AGENTS)}.`
      : !/^\d{1,18}$/.test(seed) ? "Seed: a whole number of at most 18 digits." : this.faultOfKinds(+agents, others);
    if (!fault) [this.agents, this.seed, this.others] = [+agents, String(BigInt(seed)), others.map(Number)];
    const refused = fault || (await this.reset())?.error;
    if (!refused) return this.remember();
    [this.agents, this.seed, this.others] = before;
    await this.reset();
    this.say(refused);
  }

  faultOfKinds() {
    return "";
  }

  // What begins a run stands in the address.
  remember() {
    const said = new URLSearchParams(location.hash.slice(1));
    [this.agents, this.seed, ...this.others].forEach((value, k) => said.set(this.names[k], value));
    try { history.replaceState(null, "", `#${said}`); } catch { /* a frame may forbid it */ }
  }

  go(going) {
    if (going === this.going) return;
    this.going = going;
    $("go").textContent = going ? "Pause" : "Go";
    if (!going) return;
    this.flight = { rate: this.speed(), last: performance.now(), owed: 0 };
    this.next(this.flight);
  }

  // Once it pauses, what rested is measured of what is shown.
  toggle() {
    this.go(!this.going);
    if (!this.going) this.ask({});
  }

  next(flight) {
    requestAnimationFrame((now) => this.frame(now, flight));
  }

  // Between two pictures: what is owed by the time that has passed, as far as the flock comes.
  async frame(now, flight) {
    if (!this.going || flight !== this.flight) return; // paused, and perhaps gone on since
    const spent = Math.max(1, now - flight.last) / 1000;
    flight.owed += Math.min(0.25, spent) * this.speed();
    flight.last = now;
    const ticks = Math.floor(flight.owed);
    const ran = ticks ? (await this.ask({ ticks, budget: 25 }))?.ran ?? 0 : 0;
    flight.owed = Math.min(1, flight.owed - ran);
    flight.rate += 0.1 * (ran / spent - flight.rate);
    this.next(flight);
  }

  speed() {
    return Math.round(10 ** +$("speed").value);
  }

  say(words) {
    $("say").textContent = words;
  }

  show() {
    if (!this.state) return;
    this.view.draw(this.state, isDark());
    $("tick").textContent = grouped(this.state.tick);
    $("time").textContent = `${text(this.state.time, 1)} ${this.manifest.time_unit}`;
    const isBehind = this.going && this.flight.rate < 0.8 * this.speed();
    const behind = isBehind ? `${Math.round(this.flight.rate)} of ` : "";
    $("pace").textContent = `${behind}${this.speed()} ticks a second`;
    $("speed").setAttribute("aria-valuetext", `${this.speed()}`);
    for (const chart of this.charts) chart.draw(this.state.tick);
    const each = this.each();
    $("kept").textContent = each > 2
      ? `Of this long run the curves keep the least and the greatest value of every ${grouped(each)} ticks.` : "";
  }

  each() {
    return Math.max(...this.charts.map((chart) => chart.each));
  }

  // All curves in one table: a tick at which one was not measured has no value of it. A table that does not
  // have them all says so in its name, which stays with it.
  save() {
    const names = this.charts.map((chart) => chart.measure.name), table = new Map(), each = this.each();
    this.charts.forEach((chart, k) => {
      for (const [tick, value] of chart.points) {
        if (!table.has(tick)) table.set(tick, names.map(() => ""));
        table.get(tick)[k] = value;
      }
    });
    const rows = [...table].sort(([a], [b]) => a - b).map(([tick, values]) => [tick, ...values].join(","));
    const content = encodeURIComponent([["tick", ...names].join(","), ...rows, ""].join("\n"));
    const kept = each > 2 ? `-extremes-of-${each}-ticks` : "";
    download(`data:text/csv;charset=utf-8,${content}`, `${this.manifest.model}-${names.join("-")}${kept}.csv`);
  }

  // Both charts, twice as fine as they are here.
  saveCharts() {
    const { model } = this.manifest, { tick, ids } = this.state, wide = 640, tall = 240, head = 60;
    const [canvas, pen] = sheet(2 * wide, 2 * (head + this.charts.length * tall), "--card");
    const write = (words, down, times, ink) => {
      pen.font = letters(times);
      pen.fillStyle = colour(ink);
      pen.fillText(words, 16, down, wide - 32);
    };
    pen.scale(2, 2);
    write(document.title, 30, 1.2, "--ink");
    write(`${ids.length} agents, seed ${this.seed}, tick ${grouped(tick)}`, 50, 0.87, "--soft");
    for (const chart of this.charts) {
      pen.translate(0, head);
      write(spoken(chart.measure.name) + chart.unit(", "), 26, 0.95, "--ink");
      pen.translate(8, 34);
      chart.paint(pen, wide - 16, tall - 40, tick);
      pen.translate(-8, tall - 34 - head);
    }
    download(canvas.toDataURL(), `${model}-${this.charts.map((chart) => chart.measure.name).join("-")}.png`);
  }

  // The picture as it is shown. WebGL forgets it once it is: so it is drawn again, and taken at once.
  savePicture() {
    this.show();
    const { canvas: shown, marks } = this.view, [canvas, pen] = sheet(shown.width, shown.height, "--picture");
    pen.drawImage(shown, 0, 0);
    pen.drawImage(marks, 0, 0);
    download(canvas.toDataURL(), `${this.manifest.model}-tick-${this.state.tick}.png`);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input, select, summary")) return;
    if (event.key === " " && !event.target.matches("button")) { event.preventDefault(); this.toggle(); }
    if (event.key === "s") $("step").click();
    if (event.key === "r") this.reset();
  }
}

(async () => {
  try {
    const manifest = JSON.parse($("manifest").textContent);
    const [code, image] = await Promise.all([unpack("module"), unpack("memory")]);
    if (manifest.differ) showKinds();
    const page = new Page(new Requests(await WebAssembly.compile(code), manifest, image), manifest);
    await page.begin();
    globalThis.page = page;
  } catch (error) {
    $("say").textContent = `This browser cannot run the flock: ${error.message}`;
  }
})();
