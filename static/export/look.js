// What the picture's colours mean, and what a reader chooses: colour, trails, text size, light or dark.
const SIZES = ["S", "M", "L"], THEMES = ["auto", "light", "dark"];
const DARK = matchMedia("(prefers-color-scheme: dark)");

// A list of lists of numbers as one of another length, with what lies between blended.
const stretch = (list, count) => Array.from({ length: count }, (_, k) => {
  const at = k * (list.length - 1) / (count - 1), low = Math.min(Math.floor(at), list.length - 2);
  return list[low].map((value, i) => value + (at - low) * (list[low + 1][i] - value));
});
const unhex = (digits) => digits.match(/.{6}/g).map((one) => [0, 2, 4].map((k) => parseInt(one.slice(k, k + 2), 16)));
const css = (ink) => `rgb(${ink.map(Math.round).join()})`;
// A number in three figures or so.
const figures = (value) => String(+value.toPrecision(3)).replace("-", "\u2212");

function isDark() {
  const { theme } = document.documentElement.dataset;
  return theme === "dark" || theme !== "light" && DARK.matches;
}

class Look {
  constructor(view) {
    const { palette, dim } = view.manifest, $ = (id) => document.getElementById(id);
    this.view = view;
    this.dim = dim;
    // From diving to climbing; in the plane there is one row.
    const rows = palette.heading.map((row) => stretch(unhex(row), 361));
    const flat = rows.map((row) => row.flat());
    this.headings = dim === 2 ? flat : stretch(flat, 33);
    this.numbers = stretch(unhex(palette.number), 256);
    for (const name of ["plain", "informed", "crashed", "unknown"]) this[name] = unhex(palette[name])[0];
    this.labels = { group: unhex(palette.group), layer: unhex(palette.layer) };
    this.select = $("colour");
    this.legend = $("legend");
    this.words = $("picked");
    this.size = $("size");
    this.theme = $("theme");
    this.note = $("trailed");
    const { differ, labels } = view.manifest, kind = differ?.kinds.length ? ["kind"] : [];
    for (const colour of ["heading", "speed", ...kind, ...Object.keys({ ...differ?.own, ...labels })]) {
      this.offer(colour, colour);
      if (colour === view.manifest.colour) this.select.value = colour;
    }
    this.select.onchange = () => { view.clear(); view.changed(); };
    $("trails").disabled = !view.gl;
    $("trails").onchange = (event) => { this.trails = event.target.checked; view.changed(); };
    this.size.onchange = this.theme.onchange = () => this.choose();
    addEventListener("hashchange", () => this.read());
    DARK.addEventListener("change", () => view.changed());
    this.read();
  }

  // Offer a colour by another number: `frame.values` are drawn where it is chosen.
  offer(colour, words) {
    if (![...this.select.options].some((one) => one.value === colour)) this.select.add(new Option(words, colour));
  }

  // What is chosen stands in the address: a frame without rights can store nothing.
  read() {
    const said = new URLSearchParams(location.hash.slice(1)), size = said.get("size"), theme = said.get("theme");
    if (SIZES.includes(size)) this.size.value = size;
    if (THEMES.includes(theme)) this.theme.value = theme;
    this.apply();
  }

  choose() {
    const said = new URLSearchParams(location.hash.slice(1));
    said.set("size", this.size.value);
    said.set("theme", this.theme.value);
    try { history.replaceState(null, "", `#${said}`); } catch { /* a frame may forbid it */ }
    this.apply();
  }

  apply() {
    Object.assign(document.documentElement.dataset, { size: this.size.value, theme: this.theme.value });
    this.view.changed();
  }

  // The flock is at its start.
  begin(frame) {
    if (frame.informed.some((one) => one)) this.offer("role", "role");
    this.note.textContent = this.view.flat ? "They need WebGL2, which this browser lacks."
      : frame.ids.length > TRAILED ? `Of the first ${TRAILED / 1000}\u2009000 agents.` : "";
  }

  // Colours of all agents, four bytes each; the last is 0.
  colours(frame) {
    const { informed, crashed, heading } = frame, count = crashed.length, inks = new Uint8Array(4 * count);
    let colour = this.select.value;
    const values = colour === "speed" ? frame.speed : frame.values, isRole = colour === "role";
    const inksOf = this.labels[colour], labels = colour === frame.colour && frame.labels;
    if (!isRole && !inksOf && !values) colour = "heading";
    const isNumber = !isRole && !inksOf && colour !== "heading";
    let low = Infinity, high = -Infinity;
    if (isNumber)
      for (const value of values.filter(Number.isFinite)) { low = Math.min(low, value); high = Math.max(high, value); }
    // What differs by rounding alone is the same.
    const span = high - low > 1e-9 * Math.abs(high) ? high - low : 0, { dim } = this;
    for (let row = 0; row < count; row++) {
      let ink = this.plain;
      if (crashed[row]) ink = this.crashed;
      else if (informed[row]) ink = this.informed; // as in the laboratory, whatever colours mean
      else if (inksOf) {
        // Layers begin at 1; what is more than there are agents is unknown.
        const at = colour === "layer" ? labels[row] - 1 : labels[row];
        ink = at < count ? inksOf[Math.min(at, inksOf.length - 1)] : this.unknown;
      } else if (isNumber) {
        const share = span ? (values[row] - low) / span : 0;
        ink = this.numbers[Math.round(255 * Math.min(1, Math.max(0, share)))] || this.unknown;
      } else if (!isRole) {
        const turn = Math.atan2(heading[dim * row + 1], heading[dim * row]) / (2 * Math.PI);
        const climb = dim === 2 ? 0 : Math.asin(Math.min(1, Math.max(-1, heading[3 * row + 2]))) / Math.PI + 0.5;
        const at = 3 * Math.round(360 * (turn - Math.floor(turn))) || 0;
        ink = (this.headings[Math.round(32 * climb)] || this.headings[0]).slice(at, at + 3);
      }
      inks.set(ink, 4 * row);
    }
    this.explain(colour, isNumber ? [low, span ? high : low] : [], crashed.includes(1), informed.includes(1));
    return inks;
  }

  // The legend, anew only where it says something else.
  explain(colour, range, isCrashed, isLed) {
    const { canvas, ids, tick } = this.view;
    canvas.setAttribute("aria-label", `${ids.length} agents, coloured by ${colour}, tick ${tick}`);
    const ends = range.map(figures), said = [this.view.ids.length, colour, isCrashed, isLed, ...ends].join();
    if (said === this.said) return;
    this.said = said;
    const add = (...part) => this.add(...part), entry = (words, ink) => this.addEntry(words, ink);
    this.legend.replaceChildren();
    if (colour === "heading") {
      const row = this.headings[this.headings.length >> 1], parts = [];
      for (let turn = 360; turn >= 0; turn -= 10) parts.push(css(row.slice(3 * turn, 3 * turn + 3)));
      add("wheel", "", `conic-gradient(from 90deg, ${parts.join()})`);
      add("", this.dim === 3 ? "right: +x, up: +y, lighter: climbing" : "right: 0°, up: 90°");
    } else if (colour === "role") {
      entry("other", this.plain);
    } else if (this.labels[colour]) {
      const inks = this.labels[colour].map(css), share = 100 / inks.length, isLayer = colour === "layer";
      const parts = inks.map((ink, k) => `${ink} ${k * share}% ${(k + 1) * share}%`);
      add("", isLayer ? "layer 1" : "largest");
      add("ramp", "", `linear-gradient(90deg, ${parts.join()})`);
      add("", isLayer ? `${inks.length}+` : "small groups");
      if (isLayer) entry("none", this.unknown);
    } else {
      const parts = this.numbers.filter((_, k) => k % 15 === 0).map(css), single = ends[0] === ends[1];
      add("", single ? `all ${ends[0] ?? ""}` : ends[0]);
      add(single ? "dot" : "ramp", "", single ? parts[0] : `linear-gradient(90deg, ${parts.join()})`);
      if (!single) add("", ends[1]);
    }
    if (isLed && colour !== "layer") entry("information agent", this.informed);
    if (isCrashed) entry("crashed", this.crashed);
  }

  // A part of the legend.
  add(name, words, background) {
    const part = document.createElement("span");
    part.className = name;
    part.textContent = words;
    if (background) part.style.background = background;
    this.legend.append(part);
    return part;
  }

  addEntry(words, ink) {
    this.add("entry", words).prepend(this.add("dot", "", css(ink)));
  }

  // What an agent is, beside that.
  role(frame, row) {
    return frame.informed[row] ? ", information agent" : "";
  }

  // What is said of the picked agent.
  tell(frame, row, neighbours) {
    const { dim } = this, id = row < 0 ? null : frame.ids[row];
    // A screen reader hears whom somebody picks, and not what changes at each tick.
    this.words.setAttribute("aria-live", id === this.told ? "off" : "polite");
    this.told = id;
    if (row < 0) { this.words.textContent = ""; return; }
    const [ux, uy, uz] = frame.heading.subarray(dim * row, dim * row + dim);
    const degrees = (angle) => Math.round(angle * 180 / Math.PI);
    const facts = [`heading ${(degrees(Math.atan2(uy, ux)) + 360) % 360}°`];
    if (dim === 3) facts.push(`climb ${figures(degrees(Math.asin(Math.min(1, Math.max(-1, uz)))))}°`);
    facts.push(`speed ${figures(frame.speed[row])}`, `${neighbours} neighbour${neighbours === 1 ? "" : "s"}`);
    this.words.textContent = `Agent ${id}${this.role(frame, row)}: ${frame.crashed[row] ? "crashed" : facts.join(", ")}`;
  }
}
