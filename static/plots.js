/* A plot tells the values under the mouse in as many figures as they need, has no value where there
   is none, and a click on it shows it large. */
{
  const told = (value) => {
    if (value === null || value === undefined) return "–";
    if (Number.isInteger(value)) return String(value);
    const size = Math.abs(value);
    return size >= 1e-4 && size < 1e7 ? String(Number(value.toPrecision(5))) : value.toExponential(3);
  };
  /* uPlot knows no NaN: a curve that begins with one leaves the axis of its values without ends. */
  const known = (values) => values.some(Number.isNaN)
    ? Array.from(values, (value) => Number.isNaN(value) ? null : value) : values;
  /* Which share of its times each plot shows: all, until somebody zooms in. uPlot asks for it whenever
     it draws: with ends of its own before it has drawn, with those that it shows while nobody zooms.
     viser asks it too, and is wrong where a chart is made anew and its times have other ends; it
     leaves an axis alone that does not follow by itself. */
  const zooms = new Map();
  const range = (uuid) => (chart, from, to) => {
    const { min, max } = chart.scales.x, first = chart.data[0][0], last = chart.data[0].at(-1), span = last - first;
    if (min != null && (from !== min || to !== max)) {
      zooms.set(uuid, from === first && to === last ? null : [from, to].map((at) => (at - first) / span));
    }
    const zoom = zooms.get(uuid);
    return zoom ? zoom.map((share) => first + share * span) : [first, last];
  };
  viserClient.onMessage((message) => {
    if (message.type === "GuiUplotMessage") zooms.set(message.uuid, null);
    if (message.type === "GuiRemoveMessage") zooms.delete(message.uuid);
    if (!zooms.has(message.uuid)) return;
    const { data, scales, series } = message.props || message.updates || {};
    if (data) data.forEach((values, at) => { data[at] = known(values); });
    if (scales) Object.assign(scales.x, { range: range(message.uuid), auto: () => false });
    if (series) for (const one of series) one.value = (_, value) => told(value);
  });
  const over = (event) => event.target.closest && event.target.closest(".uplot-container .u-over");

  /* A click, but not the second of two, which undoes a zoom, nor the end of a drag, which zooms. */
  let began = null, opening = 0;
  document.addEventListener("pointerdown", (event) => { began = [event.clientX, event.clientY]; }, true);
  document.addEventListener("click", (event) => {
    const plot = over(event);
    clearTimeout(opening);
    const moved = began && Math.hypot(event.clientX - began[0], event.clientY - began[1]) > 4;
    if (!plot || moved || event.detail > 1) return;
    const after = plot.closest(".uplot-container").parentElement.nextElementSibling;
    const button = after && [...after.querySelectorAll("button")].find((one) => one.textContent === "Large");
    if (button) opening = setTimeout(() => button.click(), 250);
  }, true);
  /* Keys act on the flock again once a button of a plot has been pressed. */
  document.addEventListener("click", (event) => {
    const button = event.target.closest && event.target.closest("button");
    if (button && ["Large", "CSV", "PNG", "SVG", "Table"].includes(button.textContent)) button.blur();
  });
}
