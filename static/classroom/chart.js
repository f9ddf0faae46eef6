/* Fetches the results of a class as they grow, not more often than the class can bear: `look` is told of
   them by what a page hears of the class, `draw` gets them and the numbers of one's own. */
window.flockscopeResults = (home, draw) => {
  let newest = null, drawn = "", waits = 0, last = -Infinity, ended = false;
  const look = (told) => {
    newest = told;
    const { version, apart, mine } = told, now = `${version} ${mine}`;
    if (!version || now === drawn || waits) return;
    waits = setTimeout(async () => {
      last = performance.now();
      try {
        const reply = await fetch(`${home}/class/plot.json`, { cache: "no-store", credentials: "same-origin" });
        if (!reply.ok) throw new Error("no results");
        const results = await reply.json();
        drawn = now;
        draw(results, mine);
      } catch { /* it is asked for again below */ }
      waits = 0;
      if (!ended) look(newest);
    }, Math.max(0, last + 1000 * apart - performance.now()));
  };
  return { look, end: () => { ended = true; } };
};
/* The results of a class, as they come in: every result, mean and interval for each value, the curve
   of a sweep behind them. A result can be pressed where `press` is given. `data` is what the class says
   of its question; results whose numbers are in `mine` are marked. A place may say how tall it is at
   least, in pixels (data-least). */
window.flockscopeChart = (place, data, press, mine = []) => {
  const kind = "http://www.w3.org/2000/svg";
  const wide = Math.max(300, place.clientWidth), tall = Math.max(place.dataset.least ?? 240, Math.min(420, wide * 0.5));
  const box = { left: 56, right: wide - 16, top: 16, bottom: tall - 28 };
  const draw = (name, values, inside, words) => {
    const made = document.createElementNS(kind, name);
    for (const key in values) made.setAttribute(key, values[key]);
    if (words !== undefined) made.textContent = words;
    inside.append(made);
    return made;
  };
  const svg = document.createElementNS(kind, "svg");
  svg.setAttribute("viewBox", `0 0 ${wide} ${tall}`);
  svg.setAttribute("role", press ? "group" : "img"); /* points that can be pressed are in it */
  svg.setAttribute("aria-label", `${data.title}: ${data.told}`);
  const curve = data.curve ? data.curve.groups.filter((one) => one[2] !== null) : [];
  const log = data.x.log;
  const bend = (x) => log ? Math.log10(x) : x;
  const [left, right] = data.x.limits.map(bend), [low, high] = data.y.limits;
  const x = (value) => box.left + (bend(value) - left) / (right - left) * (box.right - box.left);
  const y = (value) => box.bottom - (Math.min(Math.max(value, low), high) - low) / (high - low) * (box.bottom - box.top);
  const steps = (from, to) => {
    const rough = (to - from) / 6, unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].find((one) => one * unit >= rough) * unit, made = [];
    for (let at = Math.ceil(from / step) * step; at <= to + 1e-9 * step; at += step) made.push(Number(at.toPrecision(6)));
    return made;
  };
  const marksX = log ? [...Array(13).keys()].flatMap((k) => [1, 2, 5].map((one) => one * 10 ** (k - 6)))
    .filter((one) => Math.log10(one) > left && Math.log10(one) < right) : steps(left, right);
  const lines = draw("g", { class: "fs-lines" }, svg);
  for (const at of steps(low, high)) {
    draw("line", { x1: box.left, x2: box.right, y1: y(at), y2: y(at) }, lines);
    draw("text", { x: box.left - 8, y: y(at) + 4, "text-anchor": "end" }, lines, String(at));
  }
  for (const at of marksX) {
    draw("line", { x1: x(at), x2: x(at), y1: box.top, y2: box.bottom }, lines);
    draw("text", { x: x(at), y: box.bottom + 18, "text-anchor": "middle" }, lines, String(at));
  }
  const unit = (one) => one.unit === "1" || one.unit === one.title ? "" : `, ${one.unit}`;
  const axis = (words) => Object.assign(document.createElement("p"), { className: "fs-axis", textContent: words });
  const up = axis(`${data.y.title}${data.y.title.startsWith("ticks") ? "" : unit(data.y)}`);
  const along = axis(`${data.x.title} ${data.x.symbol}${unit(data.x)}`);
  if (curve.length) {
    const over = curve.map(([at, , mean, , , , end]) => `${x(at)},${y(end ?? mean)}`);
    const under = [...curve].reverse().map(([at, , mean, , , end]) => `${x(at)},${y(end ?? mean)}`);
    draw("polygon", { points: [...over, ...under].join(" "), class: "fs-band" }, svg);
    draw("polyline", { points: curve.map(([at, , mean]) => `${x(at)},${y(mean)}`).join(" "), class: "fs-curve" }, svg);
  }
  for (const [number, name, value, result, counts, differs] of data.points) {
    const absent = result === null, at = absent ? box.bottom - 6 : y(result);
    const own = mine.includes(number);
    const style = `fs-point${own ? " fs-own" : ""}${differs ? " fs-differs" : ""}${counts ? "" : " fs-before"}${absent ? " fs-absent" : ""}`;
    const dot = draw("circle", { cx: x(value), cy: at, r: 6, class: style, ...(press ? { tabindex: 0, role: "button" } : {}) }, svg);
    const said = `${own ? "yours" : name}: ${data.x.symbol} = ${value}, ${absent ? "it did not happen" : result}${differs ? ` (${differs})` : ""}`;
    if (!press) continue;
    draw("title", {}, dot, `${said}. Press to open the run.`);
    dot.setAttribute("aria-label", said);
    dot.addEventListener("click", () => press(number));
    dot.addEventListener("keydown", (event) => { if (event.key === "Enter") press(number); });
  }
  for (const [at, runs, mean, half, , below, above] of data.groups) {
    if (mean === null || runs < 2) continue;
    const group = draw("g", { class: "fs-mean" }, svg), middle = x(at) + 10;
    if (half !== null) draw("line", { x1: middle, x2: middle, y1: y(below), y2: y(above) }, group);
    draw("path", { d: `M${middle} ${y(mean) - 6}l6 6-6 6-6-6z` }, group);
    draw("title", {}, group, `mean of ${runs}: ${mean}${half === null ? "" : ` ± ${half}`}`);
  }
  place.replaceChildren(up, svg, along);
};
