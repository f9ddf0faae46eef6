// Draws agents, as darts or by the shape that the manifest has, where they have been, and what is in their world.
const VERTEX = `#version 300 es
in vec3 corner; in vec3 place; in vec3 heading; in vec4 ink;
uniform mat4 camera; uniform float size, space;
out vec3 colour;
void main() {
  vec3 ahead = normalize(heading), up = abs(ahead.z) > .95 ? vec3(1, 0, 0) : vec3(0, 0, 1);
  vec3 side = normalize(cross(up, ahead)), above = cross(ahead, side);
  vec3 point = corner.x * ahead + corner.y * side + corner.z * above;
  gl_Position = camera * vec4(place + size * (1. + ink.a) * point, 1); // the fourth byte makes larger
  colour = ink.rgb * (space > 0. ? .86 + .5 * corner.z : 1.);
}`;
const FRAGMENT = `#version 300 es
precision mediump float; in vec3 colour; out vec4 pixel; void main() { pixel = vec4(colour, 1); }`;
const PLAIN_VERTEX = `#version 300 es
in vec3 corner; uniform mat4 camera; void main() { gl_Position = camera * vec4(corner, 1); }`;
const PLAIN_FRAGMENT = `#version 300 es
precision mediump float; uniform vec4 ink; out vec4 pixel; void main() { pixel = ink; }`;
const KEPT = 60; // pictures that a trail reaches back
const TRAILED = 2000; // agents with trails
// Each picture is a slab of the buffer: one line for each agent. The slab after the newest is the oldest.
const TRAIL_VERTEX = `#version 300 es
in vec3 corner; in vec3 ink; uniform mat4 camera; uniform int newest, lines; out vec4 colour;
void main() {
  gl_Position = camera * vec4(corner, 1);
  int age = (newest - gl_VertexID / (2 * lines) + ${KEPT}) % ${KEPT};
  float strength = .75 * (1. - (float(age) + (gl_VertexID % 2 == 0 ? 1. : 0.)) / ${KEPT}.);
  colour = vec4(ink * strength, strength);
}`;
const TRAIL_FRAGMENT = `#version 300 es
precision mediump float; in vec4 colour; out vec4 pixel; void main() { pixel = colour; }`;
const DART = [
  [1, 0, 0], [-0.75, 0.46, 0], [-0.75, -0.46, 0],
  [1, 0, 0], [-0.75, 0, 0.3], [-0.75, 0.46, 0],
  [1, 0, 0], [-0.75, -0.46, 0], [-0.75, 0, 0.3],
];
const DART_LENGTH = 1.75;
const CAR = [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]; // without WebGL2
const LENS = 2.15; // the box fills the picture, however it is turned
const STILL = 6; // pixels that a finger may slip in a click
const NEAR = 22; // pixels from an agent within which a click picks it
const FEW_INFORMED = 12; // so many are drawn larger, as in the laboratory

function multiply(a, b) {
  const product = new Float32Array(16);
  for (let column = 0; column < 4; column++)
    for (let row = 0; row < 4; row++)
      for (let k = 0; k < 4; k++) product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return product;
}

class View {
  constructor(canvas, manifest) {
    this.canvas = canvas;
    this.marks = document.getElementById("marks");
    this.manifest = manifest;
    this.gl = canvas.getContext("webgl2", { antialias: true });
    this.flat = this.gl ? null : canvas.getContext("2d");
    this.look = new Look(this);
    this.picked = null;
    this.shape = this.gl && manifest.shape ? new AgentShape(this) : null;
    this.clear();
    this.home();
    if (this.gl) this.prepare();
    // The picture of a world in the plane has its shape, within limits; space fills what there is.
    if (manifest.dim === 2) {
      const shape = Math.min(3, Math.max(1, manifest.size[0] / manifest.size[1]));
      canvas.parentElement.style.setProperty("--shape", shape);
    }
    this.listen();
  }

  // Where the camera is at first: it shows all.
  home() {
    const { low, size } = this.manifest;
    this.zoom = 1;
    this.yaw = -0.9;
    this.pitch = 0.5;
    this.centre = [0, 1, 2].map((axis) => axis < size.length ? low[axis] + size[axis] / 2 : 0);
  }

  // Forget where agents have been.
  clear() {
    this.endTrail();
    this.shape?.forget();
    this.begins = true;
  }

  // Its buffers are megabytes, which a browser may not notice that nobody needs.
  endTrail() {
    if (!this.trail) return;
    for (const buffer of [this.trail.places, this.trail.inks]) this.gl.deleteBuffer(buffer);
    this.gl.deleteVertexArray(this.trail.array);
    this.trail = null;
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return program;
  }

  buffer(program, name, size, data, each = 0, bytes = false) {
    const gl = this.gl, buffer = gl.createBuffer(), place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    if (data) gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, bytes, bytes ? 4 : 0, 0);
    gl.vertexAttribDivisor(place, each);
    return buffer;
  }

  array() {
    const array = this.gl.createVertexArray();
    this.gl.bindVertexArray(array);
    return array;
  }

  // Buffers of what each agent has: place, heading and ink.
  instances(program) {
    const vectors = ["place", "heading"].map((name) => this.buffer(program, name, 3, null, 1));
    return [...vectors, this.buffer(program, "ink", 4, null, 1, true)];
  }

  fill(buffers, data) {
    const { gl } = this;
    buffers.forEach((buffer, k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data[k], gl.DYNAMIC_DRAW);
    });
  }

  use(program, array) {
    const { gl } = this;
    gl.useProgram(program);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "camera"), false, this.camera);
    if (array) gl.bindVertexArray(array);
  }

  prepare() {
    this.darts = this.program(VERTEX, FRAGMENT);
    this.dartArray = this.array();
    this.buffer(this.darts, "corner", 3, new Float32Array(DART.flat()));
    this.agents = this.instances(this.darts);
    this.shape?.prepare();
    this.trails = this.program(TRAIL_VERTEX, TRAIL_FRAGMENT);
    this.plain = this.program(PLAIN_VERTEX, PLAIN_FRAGMENT);
    this.shapes = [this.manifest.triangles, [...this.edges(), ...this.manifest.lines]].map((data) => {
      const array = this.array();
      this.buffer(this.plain, "corner", 3, new Float32Array(data.flat()));
      return [array, data.length];
    });
  }

  // The edges of the box, two ends each: whole where solid, dashed where they wrap, dotted where open.
  edges() {
    const { low, size, dim, edges } = this.manifest, ends = [];
    const corner = (bits) => [0, 1, 2].map((axis) => axis < dim ? low[axis] + (bits >> axis & 1) * size[axis] : 0);
    for (let bits = 0; bits < 1 << dim; bits++)
      for (let axis = 0; axis < dim; axis++)
        if (!(bits >> axis & 1)) {
          const faces = edges.filter((_, other) => other !== axis);
          const [count, share] = faces.includes("solid") ? [1, 1] : faces.includes("wrap") ? [48, 0.6] : [96, 0.2];
          const from = corner(bits), to = corner(bits | 1 << axis);
          const at = (part) => from.map((start, k) => start + part * (to[k] - start));
          for (let k = 0; k < count; k++) ends.push(at(k / count), at((k + share) / count));
        }
    return ends;
  }

  // Sets the matrix, and how many pixels a unit of length has at depth 1.
  aim() {
    const { width, height } = this.canvas, { size, dim } = this.manifest, [x, y, z] = this.centre;
    const towards = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1]);
    if (dim === 2) {
      const scale = 2 * this.zoom * Math.min(width / size[0], height / size[1]);
      this.unit = scale / 2;
      const flat = [scale / width, 0, 0, 0, 0, scale / height, 0, 0, 0, 0, -1e-6, 0, 0, 0, 0, 1];
      if (this.shape) flat[10] = -1 / Math.max(...size); // what is higher hides what is lower
      this.camera = multiply(flat, towards);
      return;
    }
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const reach = Math.hypot(...size), away = 1.2 * reach / this.zoom;
    const turn = new Float32Array([cy, -sy * sp, sy * cp, 0, sy, cy * sp, -cy * cp, 0, 0, cp, sp, 0, 0, 0, -away, 1]);
    const near = away / 50, far = away + 2 * reach / Math.min(1, this.zoom), short = Math.min(width, height);
    this.unit = LENS * short / 2;
    const lensed = [
      LENS * short / width, 0, 0, 0, 0, LENS * short / height, 0, 0,
      0, 0, -(far + near) / (far - near), -1, 0, 0, -2 * far * near / (far - near), 0,
    ];
    this.camera = multiply(lensed, multiply(turn, towards));
  }

  // Where a place is in the picture: pixels of the canvas, and the depth, which is below 0 behind the camera.
  project(x, y, z) {
    const m = this.camera, { width, height } = this.canvas, depth = m[3] * x + m[7] * y + m[11] * z + m[15];
    const across = m[0] * x + m[4] * y + m[8] * z + m[12], up = m[1] * x + m[5] * y + m[9] * z + m[13];
    return [(1 + across / depth) * width / 2, (1 - up / depth) * height / 2, depth];
  }

  placeOf(row) {
    return this.places.subarray(3 * row, 3 * row + 3);
  }

  listen() {
    const { canvas } = this, pointers = new Map();
    let start = null; // where a press began that may be a click
    const apart = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      start = pointers.size === 1 && event.button === 0 ? { x: event.clientX, y: event.clientY } : null;
    });
    canvas.addEventListener("pointerup", (event) => {
      if (start && pointers.delete(event.pointerId)) this.pick(event.offsetX, event.offsetY, NEAR);
      pointers.delete(event.pointerId);
      start = null;
    });
    canvas.addEventListener("pointercancel", (event) => { pointers.delete(event.pointerId); start = null; });
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      if (start && Math.hypot(event.clientX - start.x, event.clientY - start.y) < STILL) return;
      start = null;
      const dx = event.clientX - before.x, dy = event.clientY - before.y;
      const gap = pointers.size === 2 ? apart() : 0;
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (gap) this.magnify(apart() / gap);
      else this.shift(dx, dy);
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.magnify(Math.exp(-event.deltaY / 500));
    }, { passive: false });
    canvas.addEventListener("dblclick", () => { this.home(); this.changed(); });
    canvas.addEventListener("keydown", (event) => this.key(event));
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.picked !== null) { this.picked = null; this.changed(); }
    });
    // A phone takes the graphics of a page in the background away.
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.prepare(); this.clear(); this.changed(); });
    new ResizeObserver(() => this.changed()).observe(canvas);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { clientWidth: width, clientHeight: height } = this.canvas, step = Math.min(width, height) / 10;
    const steps = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const larger = { "+": 1.25, "=": 1.25, "-": 0.8 };
    if (event.key in steps) this.shift(...steps[event.key].map((one) => one * step));
    else if (event.key in larger) this.magnify(larger[event.key]);
    else if (event.key === "0") { this.home(); this.changed(); }
    else if (event.key === "Enter") this.pick(width / 2, height / 2, Infinity);
    else return;
    event.preventDefault();
  }

  // Move the picture by pixels of the page, or turn it in space.
  shift(dx, dy) {
    if (this.manifest.dim === 3) {
      this.yaw += dx / 200;
      this.pitch = Math.min(1.5, Math.max(-1.5, this.pitch + dy / 200));
    } else {
      const each = this.canvas.width / this.canvas.clientWidth / this.unit;
      this.centre[0] -= dx * each;
      this.centre[1] += dy * each;
    }
    this.changed();
  }

  magnify(times) {
    this.zoom = Math.min(50, Math.max(0.2, this.zoom * times));
    this.changed();
  }

  // Pick the agent nearest to a point of the picture, in pixels of the page; nobody if none is near.
  pick(x, y, within) {
    const scale = this.canvas.width / this.canvas.clientWidth;
    let least = Infinity;
    this.picked = null;
    for (let row = 0; row < this.ids.length; row++) {
      const [across, down, depth] = this.project(...this.placeOf(row));
      const distance = Math.hypot(across / scale - x, down / scale - y);
      const large = this.length * this.unit / depth / scale; // of a dart, in pixels of the page
      if (depth <= 0 || distance >= least || distance > Math.max(within, large)) continue;
      least = distance;
      this.picked = this.ids[row];
    }
    this.changed();
  }

  changed() {}

  fit() {
    this.scale = Math.min(devicePixelRatio || 1, 2);
    const { clientWidth, clientHeight } = this.canvas;
    const width = Math.round(clientWidth * this.scale), height = Math.round(clientHeight * this.scale);
    for (const canvas of [this.canvas, this.marks])
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  }

  // Arrays (N, dim) as (N, 3) of small numbers.
  inSpace(array, count) {
    const dim = this.manifest.dim, found = new Float32Array(3 * count);
    for (let row = 0; row < count; row++)
      for (let axis = 0; axis < dim; axis++) found[3 * row + axis] = array[dim * row + axis];
    return found;
  }

  draw(frame, dark) {
    this.fit();
    this.aim();
    const count = frame.ids.length, { size, dim } = this.manifest;
    if (frame.tick < this.tick) this.clear();
    this.tick = frame.tick;
    if (this.begins) this.look.begin(frame);
    this.begins = false;
    // A flock of few is drawn larger: from afar its agents would be dots.
    const side = Math.max(...size), length = side / Math.min(130, Math.max(45, 4 * Math.sqrt(count)));
    // In a large world agents are close to each other: they are no larger than what they see.
    this.reach ??= frame.reach;
    this.length = frame.car ? frame.car[0] : Math.max(side / 200, Math.min(length, 0.6 * this.reach));
    this.slim = frame.car ? frame.car[1] / frame.car[0] : 0;
    this.places = this.inSpace(frame.position, count);
    this.ids = frame.ids.slice(); // the memory behind it may be gone when somebody clicks
    const headings = this.inSpace(frame.heading, count), inks = this.look.colours(frame);
    const informed = frame.informed.reduce((sum, one) => sum + one, 0);
    if (informed <= FEW_INFORMED && !frame.car)
      for (let row = 0; row < count; row++) if (frame.informed[row]) inks[4 * row + 3] = dim === 2 ? 190 : 255;
    if (this.flat) this.drawFlat(frame, headings, inks, dark);
    else this.drawLit(headings, inks, frame, dark);
    this.mark(frame, dark);
  }

  drawLit(headings, inks, frame, dark) {
    const gl = this.gl, uniform = (program, name) => gl.getUniformLocation(program, name);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.use(this.plain);
    this.shapes.forEach(([array, corners], lines) => {
      const strength = lines ? 0.35 : 0.5, grey = strength * (dark ? 0.75 : 0.35);
      gl.uniform4f(uniform(this.plain, "ink"), grey, grey, grey, strength);
      gl.bindVertexArray(array);
      if (corners) gl.drawArrays(lines ? gl.LINES : gl.TRIANGLES, 0, corners);
    });
    if (this.look.trails) {
      this.extend(inks, frame.tick);
      const { array, lines, newest } = this.trail;
      this.use(this.trails, array);
      gl.uniform1i(uniform(this.trails, "newest"), newest);
      gl.uniform1i(uniform(this.trails, "lines"), lines);
      gl.depthMask(false); // darts are drawn over trails
      gl.drawArrays(gl.LINES, 0, 2 * lines * KEPT);
      gl.depthMask(true);
    } else this.endTrail();
    if (this.shape?.fits(frame.ids.length)) return this.shape.draw(frame, headings, inks);
    this.use(this.darts, this.dartArray);
    this.fill(this.agents, [this.places, headings, inks]);
    gl.uniform1f(uniform(this.darts, "size"), this.length);
    gl.uniform1f(uniform(this.darts, "space"), this.manifest.dim === 3 ? 1 : 0);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, DART.length, this.ids.length);
  }

  // Add a picture to the trails: of each agent, the line from where it was.
  extend(inks, tick) {
    const gl = this.gl, { size } = this.manifest;
    if (!this.trail) {
      const first = this.ids.slice().sort().subarray(0, TRAILED), lines = first.length, array = this.array();
      const empty = (bytes) => new Uint8Array(2 * lines * KEPT * bytes);
      this.trail = {
        array, lines, newest: 0, tick: null, before: new Float32Array(3 * lines).fill(NaN),
        places: this.buffer(this.trails, "corner", 3, empty(12)),
        inks: this.buffer(this.trails, "ink", 3, empty(4), 0, true),
        line: new Map(Array.from(first, (id, k) => [id, k])),
      };
    }
    const trail = this.trail, { before, lines } = trail;
    if (trail.tick === tick) return;
    const ends = new Float32Array(6 * lines), colours = new Uint8Array(8 * lines);
    this.ids.forEach((id, row) => {
      const k = trail.line.get(id);
      if (k === undefined) return;
      const old = before.subarray(3 * k, 3 * k + 3), now = this.placeOf(row), ink = inks.subarray(4 * row, 4 * row + 4);
      // At a periodic edge the line is broken: it has no length. So has the first, whose old place is no number.
      const goes = size.every((side, axis) => Math.abs(now[axis] - old[axis]) < side / 2);
      ends.set(goes ? old : now, 6 * k);
      ends.set(now, 6 * k + 3);
      colours.set(ink, 8 * k);
      colours.set(ink, 8 * k + 4);
      old.set(now);
    });
    trail.tick = tick;
    trail.newest = (trail.newest + 1) % KEPT;
    for (const [buffer, data] of [[trail.places, ends], [trail.inks, colours]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferSubData(gl.ARRAY_BUFFER, trail.newest * data.byteLength, data);
    }
  }

  // Without WebGL2: the same darts as triangles, cars as rectangles, and no trails.
  drawFlat(frame, headings, inks, dark) {
    const pen = this.flat, { width, height } = this.canvas, { triangles, lines } = this.manifest;
    const path = (corners, closed) => {
      pen.beginPath();
      corners.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y));
      if (closed) pen.fill(); else pen.stroke();
    };
    const several = (data, each, closed) => {
      for (let k = 0; k < data.length; k += each) {
        const corners = data.slice(k, k + each).map((corner) => this.project(...corner));
        if (corners.every((corner) => corner[2] > 0)) path(corners, closed);
      }
    };
    pen.clearRect(0, 0, width, height);
    pen.fillStyle = pen.strokeStyle = dark ? "#6a6f78" : "#abb0b8";
    pen.lineWidth = this.scale / 2;
    several(triangles, 3, true);
    several([...this.edges(), ...lines], 2, false);
    // In space the nearest is drawn last.
    const depths = Array.from(this.ids, (_, row) => [this.project(...this.placeOf(row))[2], row]);
    if (this.manifest.dim === 3) depths.sort(([a], [b]) => b - a);
    for (const [depth, row] of depths) {
      if (depth <= 0) continue;
      const [x, y, z] = this.placeOf(row), [ux, uy, uz] = headings.subarray(3 * row, 3 * row + 3);
      const flat = Math.hypot(ux, uy) || 1, size = this.length * (1 + inks[4 * row + 3] / 255);
      pen.fillStyle = `rgb(${inks.subarray(4 * row, 4 * row + 3).join()})`;
      const outline = frame.car ? CAR.map(([ahead, side]) => [ahead, side * this.slim]) : DART.slice(0, 3);
      path(outline.map(([ahead, side]) => this.project(
        x + size * (ahead * ux - side * uy / flat), y + size * (ahead * uy + side * ux / flat), z + size * ahead * uz,
      )), true);
    }
  }

  // Around whom an agent finds: rows, and vectors to their nearest images. Who has crashed has no neighbours.
  neighbours(frame, row) {
    const { dim, size, images } = this.manifest, { position, crashed, reach, nearest } = frame, found = [];
    if (crashed[row]) return found;
    for (let other = 0; other < crashed.length; other++) {
      const vector = [0, 0, 0];
      for (let axis = 0; axis < dim; axis++) {
        const apart = position[dim * other + axis] - position[dim * row + axis];
        vector[axis] = images[axis] ? apart - size[axis] * Math.round(apart / size[axis]) : apart;
      }
      const far = Math.hypot(...vector);
      if (far > 0 && !crashed[other] && (nearest || far <= reach)) found.push({ row: other, vector, far });
    }
    return nearest ? found.sort((a, b) => a.far - b.far).slice(0, nearest) : found;
  }

  // The picked agent, its neighbours, and what is said of it, on the canvas over the picture.
  mark(frame, dark) {
    const pen = this.marks.getContext("2d"), row = this.picked === null ? -1 : this.ids.indexOf(this.picked);
    pen.clearRect(0, 0, this.marks.width, this.marks.height);
    if (row < 0) this.picked = null;
    const near = row < 0 ? [] : this.neighbours(frame, row);
    this.look.tell(frame, row, near.length);
    if (row < 0) return;
    const { low, size, dim } = this.manifest;
    const line = (from, vector, sign) => {
      // As far as the box reaches: what lies across a periodic edge is drawn from the other side.
      let share = 1;
      for (let axis = 0; axis < dim; axis++) {
        const step = sign * vector[axis], edge = step > 0 ? low[axis] + size[axis] : low[axis];
        if (step) share = Math.min(share, Math.max(0, (edge - from[axis]) / step));
      }
      const ends = [from, from.map((at, axis) => at + share * sign * vector[axis])].map((at) => this.project(...at));
      if (ends.some((end) => end[2] <= 0)) return;
      pen.beginPath();
      for (const [x, y] of ends) pen.lineTo(x, y);
      pen.stroke();
    };
    const ring = (place, times, least) => {
      const [x, y, depth] = this.project(...place);
      if (depth <= 0) return;
      pen.beginPath();
      pen.arc(x, y, Math.max(least * this.scale, times * this.length * this.unit / depth), 0, 7);
      pen.stroke();
    };
    const me = [...this.placeOf(row)];
    const ink = dark ? "#f2f6fc" : "#0f172a";
    pen.strokeStyle = `${ink}90`;
    pen.lineWidth = this.scale;
    for (const { row: other, vector } of near) {
      const place = [...this.placeOf(other)];
      const across = vector.some((far, axis) => Math.abs(me[axis] + far - place[axis]) > size[axis] / 2);
      line(me, vector, 1);
      if (across) line(place, vector, -1);
    }
    pen.lineWidth = 1.5 * this.scale;
    for (const { row: other } of near) ring(this.placeOf(other), 1.15, 5);
    pen.strokeStyle = ink;
    pen.lineWidth = 2.5 * this.scale;
    ring(me, 1.6, 9);
  }
}
