/* A plot tells the values under the mouse in as many figures as they need, and a click on it shows
   it large. viser has its charts at hand for tests: they are taken from there when the mouse comes
   to one; without that they would tell three decimals. */
{
  const dressed = new WeakSet();
  const told = (value) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "–";
    if (Number.isInteger(value)) return String(value);
    const size = Math.abs(value);
    return size >= 1e-4 && size < 1e7 ? String(Number(value.toPrecision(5))) : value.toExponential(3);
  };
  const dress = (root) => {
    const all = (window.__viserTestpoints && window.__viserTestpoints.uplots) || {};
    for (const { chart } of Object.values(all)) {
      if (chart.root !== root || dressed.has(chart)) continue;
      dressed.add(chart);
      for (const one of chart.series) one.value = (_, value) => told(value);
      /* Marks on a curve, which are no line, are not told of. */
      root.querySelectorAll(".u-legend .u-series").forEach((row, at) => {
        row.classList.toggle("fs-mark", at > 0 && chart.series[at].width === 0);
      });
      /* Where a curve has no value it has no dot either. */
      chart.cursor.dataIdx = (_, curve, at) => Number.isNaN(chart.data[curve][at]) ? null : at;
    }
  };
  const over = (event) => event.target.closest && event.target.closest(".uplot-container .u-over");
  document.addEventListener("pointerover", (event) => {
    const plot = over(event);
    if (plot) dress(plot.closest(".uplot"));
  }, true);

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
