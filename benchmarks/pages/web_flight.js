// Runs exported flocks without their page, by the page's own class Kernel: in Chromium, Firefox, node.
const fromBase64 = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

async function kernelOf({ module, manifest, image }) {
  return new Kernel(await WebAssembly.compile(fromBase64(module)), manifest, fromBase64(image));
}

// The functions that a module asks the page for.
async function importsOf({ module }) {
  const all = WebAssembly.Module.imports(await WebAssembly.compile(fromBase64(module)));
  return all.filter((one) => one.kind === "function").map((one) => one.name);
}

// The bits of all positions, in base 64.
function bitsOf(kernel) {
  const { buffer, byteOffset, byteLength } = kernel.view("flock.position");
  const letters = Array.from(new Uint8Array(buffer, byteOffset, byteLength), (byte) => String.fromCharCode(byte));
  return btoa(letters.join(""));
}

// They after so many ticks from the start, and so many; and after the first of these from another start.
function positionsAfter(kernel, ticks) {
  kernel.reset();
  let tick = 0;
  const found = ticks.map((until) => {
    kernel.run(until - tick);
    tick = until;
    return bitsOf(kernel);
  });
  const { agents, start } = kernel.manifest;
  if (start) {
    kernel.reset();
    new Starter(kernel).begin("11", agents - start.informed + 3);
    kernel.run(ticks[0]);
    found.push(bitsOf(kernel));
    kernel.reset();
  }
  return found;
}

// Seconds by the clock that so many ticks more take.
function secondsOf(kernel, ticks) {
  const began = performance.now();
  kernel.run(ticks);
  return (performance.now() - began) / 1000;
}
