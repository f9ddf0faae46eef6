// Draws agents as darts, in the plane and in space, and what is in their world.
const VERTEX = `#version 300 es
in vec3 corner; in vec3 place; in vec3 heading;
uniform mat4 camera; uniform float size, dark, space;
out vec3 colour;
const float TURN = 6.2831853;
void main() {
  vec3 ahead = normalize(heading), up = abs(ahead.z) > .95 ? vec3(1, 0, 0) : vec3(0, 0, 1);
  vec3 side = normalize(cross(up, ahead)), above = cross(ahead, side);
  gl_Position = camera * vec4(place + size * (corner.x * ahead + corner.y * side + corner.z * above), 1);
  float angle = atan(heading.y, heading.x);
  vec3 wheel = .5 + .36 * cos(angle + vec3(.3, 2.4, 4.5));
  float shade = space > 0. ? .75 + .25 * (corner.z * 2. + ahead.z * .5) : 1.;
  colour = mix(wheel * shade, vec3(dark), .08);
}`;
const FRAGMENT = `#version 300 es
precision mediump float; in vec3 colour; out vec4 pixel; void main() { pixel = vec4(colour, 1); }`;
const PLAIN_VERTEX = `#version 300 es
in vec3 corner; uniform mat4 camera; void main() { gl_Position = camera * vec4(corner, 1); }`;
const PLAIN_FRAGMENT = `#version 300 es
precision mediump float; uniform vec4 ink; out vec4 pixel; void main() { pixel = ink; }`;
const DART = [
  [1, 0, 0], [-0.75, 0.46, 0], [-0.75, -0.46, 0],
  [1, 0, 0], [-0.75, 0, 0.3], [-0.75, 0.46, 0],
  [1, 0, 0], [-0.75, -0.46, 0], [-0.75, 0, 0.3],
];

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
    this.manifest = manifest;
    this.gl = canvas.getContext("webgl2", { antialias: true });
    this.flat = this.gl ? null : canvas.getContext("2d");
    this.zoom = 1;
    this.yaw = -0.9;
    this.pitch = 0.5;
    this.centre = manifest.low.map((low, axis) => low + manifest.size[axis] / 2);
    while (this.centre.length < 3) this.centre.push(0);
    if (this.gl) this.prepare();
    this.listen();
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

  buffer(program, name, size, data, each) {
    const gl = this.gl, buffer = gl.createBuffer(), place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    if (data) gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data.flat()), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    gl.vertexAttribDivisor(place, each);
    return buffer;
  }

  prepare() {
    const gl = this.gl;
    this.darts = this.program(VERTEX, FRAGMENT);
    this.dartArray = gl.createVertexArray();
    gl.bindVertexArray(this.dartArray);
    this.buffer(this.darts, "corner", 3, DART, 0);
    this.places = this.buffer(this.darts, "place", 3, null, 1);
    this.headings = this.buffer(this.darts, "heading", 3, null, 1);
    this.plain = this.program(PLAIN_VERTEX, PLAIN_FRAGMENT);
    this.shapes = [["triangles", this.manifest.triangles], ["lines", [...this.edges(), ...this.manifest.lines]]].map(([kind, data]) => {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      this.buffer(this.plain, "corner", 3, data, 0);
      return { kind, array, count: data.length };
    });
  }

  // The edges of the box, two ends each.
  edges() {
    const { low, size, dim } = this.manifest, ends = [];
    const corner = (bits) => [0, 1, 2].map((axis) => axis < dim ? low[axis] + (bits >> axis & 1) * size[axis] : 0);
    for (let bits = 0; bits < 1 << dim; bits++)
      for (let axis = 0; axis < dim; axis++)
        if (!(bits >> axis & 1)) ends.push(corner(bits), corner(bits | 1 << axis));
    return ends;
  }

  camera() {
    const { width, height } = this.canvas, { size, dim } = this.manifest, [x, y, z] = this.centre;
    const towards = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1]);
    if (dim === 2) {
      const scale = 1.96 * this.zoom / Math.max(size[0] / width, size[1] / height);
      return multiply(new Float32Array([scale / width, 0, 0, 0, 0, scale / height, 0, 0, 0, 0, -1e-6, 0, 0, 0, 0, 1]), towards);
    }
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const reach = Math.hypot(...size), away = 1.2 * reach / this.zoom, lens = 1.9;
    const turn = new Float32Array([cy, -sy * sp, sy * cp, 0, sy, cy * sp, -cy * cp, 0, 0, cp, sp, 0, 0, 0, -away, 1]);
    const near = away / 50, far = away + 2 * reach, short = Math.min(width, height);
    const lensed = new Float32Array([
      lens * short / width, 0, 0, 0, 0, lens * short / height, 0, 0,
      0, 0, -(far + near) / (far - near), -1, 0, 0, -2 * far * near / (far - near), 0,
    ]);
    return multiply(lensed, multiply(turn, towards));
  }

  listen() {
    const pointers = new Map();
    const apart = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    for (const name of ["pointerup", "pointercancel"])
      this.canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    this.canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.x, dy = event.clientY - before.y;
      const gap = pointers.size === 2 ? apart() : 0;
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (gap) this.magnify(apart() / gap);
      else if (this.manifest.dim === 3) {
        this.yaw += dx / 200;
        this.pitch = Math.min(1.5, Math.max(-1.5, this.pitch + dy / 200));
      } else {
        const { size } = this.manifest, box = this.canvas.getBoundingClientRect();
        const each = Math.max(size[0] / box.width, size[1] / box.height) / this.zoom;
        this.centre[0] -= dx * each;
        this.centre[1] += dy * each;
      }
      this.changed();
    });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.magnify(Math.exp(-event.deltaY / 500));
    }, { passive: false });
    this.canvas.addEventListener("dblclick", () => {
      this.zoom = 1;
      this.yaw = -0.9;
      this.pitch = 0.5;
      this.centre = this.centre.map((_, axis) => axis < this.manifest.dim ? this.manifest.low[axis] + this.manifest.size[axis] / 2 : 0);
      this.changed();
    });
  }

  magnify(times) {
    this.zoom = Math.min(50, Math.max(0.2, this.zoom * times));
    this.changed();
  }

  changed() {}

  fit() {
    const scale = Math.min(devicePixelRatio || 1, 2);
    const width = Math.round(this.canvas.clientWidth * scale), height = Math.round(this.canvas.clientHeight * scale);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
  }

  // Arrays (N, dim) as (N, 3) of small numbers.
  inSpace(array, count) {
    const dim = this.manifest.dim, found = new Float32Array(3 * count);
    for (let row = 0; row < count; row++)
      for (let axis = 0; axis < dim; axis++) found[3 * row + axis] = array[dim * row + axis];
    return found;
  }

  draw({ position, heading }, dark) {
    this.fit();
    const count = position.length / this.manifest.dim, { size } = this.manifest;
    // A flock of few is drawn larger: from afar its agents would be dots.
    const length = Math.max(...size) / Math.min(130, Math.max(45, 4 * Math.sqrt(count)));
    if (this.flat) return this.drawFlat(position, heading, count, length);
    const gl = this.gl, camera = this.camera();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.plain);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.plain, "camera"), false, camera);
    const ink = dark ? 0.75 : 0.35;
    for (const { kind, array, count: corners } of this.shapes) {
      const strength = kind === "lines" ? 0.35 : 0.5;
      gl.uniform4f(gl.getUniformLocation(this.plain, "ink"), ink * strength, ink * strength, ink * strength, strength);
      gl.bindVertexArray(array);
      if (corners) gl.drawArrays(kind === "lines" ? gl.LINES : gl.TRIANGLES, 0, corners);
    }
    gl.useProgram(this.darts);
    gl.bindVertexArray(this.dartArray);
    for (const [buffer, data] of [[this.places, position], [this.headings, heading]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, this.inSpace(data, count), gl.DYNAMIC_DRAW);
    }
    gl.uniformMatrix4fv(gl.getUniformLocation(this.darts, "camera"), false, camera);
    for (const [name, value] of [["size", length], ["dark", dark ? 1 : 0], ["space", this.manifest.dim === 3 ? 1 : 0]])
      gl.uniform1f(gl.getUniformLocation(this.darts, name), value);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, DART.length, count);
  }

  // Without WebGL2: points in the plane, or space seen from above.
  drawFlat(position, heading, count, length) {
    const { width, height } = this.canvas, { size, dim, low } = this.manifest, pen = this.flat;
    const scale = Math.min(width / size[0], height / size[1]) * 0.98 * this.zoom;
    pen.clearRect(0, 0, width, height);
    for (let row = 0; row < count; row++) {
      const x = width / 2 + (position[dim * row] - this.centre[0]) * scale;
      const y = height / 2 - (position[dim * row + 1] - this.centre[1]) * scale;
      const angle = Math.atan2(heading[dim * row + 1], heading[dim * row]);
      pen.fillStyle = `hsl(${angle * 57.3} 70% 50%)`;
      pen.fillRect(x - length * scale / 2, y - length * scale / 2, length * scale, length * scale);
    }
  }
}
