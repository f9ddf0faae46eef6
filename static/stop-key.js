/* The emergency stop's keys work wherever the focus is: viser leaves keys alone that are typed into
   a field, and those that are pressed with Shift, Ctrl or Alt. */
if (!window.flockscopeStopKey) {
  window.flockscopeStopKey = true;
  const stopKeys = { Space: " ", Escape: "Escape" };
  const pass = (code) => document.documentElement.dispatchEvent(
    new KeyboardEvent("keydown", { key: stopKeys[code], code: code, bubbles: true }));
  const down = (event) => {
    if (!event.isTrusted || !(event.code in stopKeys)) return;
    const field = event.target.closest && event.target.closest("input, textarea, select");
    const held = event.shiftKey || event.ctrlKey || event.altKey || event.metaKey;
    if (!field && !held) return;
    if (event.code === "Space") { event.preventDefault(); event.stopPropagation(); }
    if (field) field.blur();
    pass(event.code);
  };
  const up = (event) => { if (event.isTrusted && event.code === "Space") event.preventDefault(); };
  window.addEventListener("keydown", down, true);
  window.addEventListener("keyup", up, true);
}
