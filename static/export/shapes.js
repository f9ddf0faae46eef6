// Draws agents by the meshes that the manifest has: birds, which beat their wings and bank into their turns, fish, which
// beat their tails, or cars.
const SHAPE_VERTEX = `#version 300 es
in vec3 corner, hinge, paint; in vec2 trait; // trait: the share of the agent's colour, and how it beats
in vec3 place; in vec3 heading; in vec4 ink; in vec2 pose; // pose: tangent of the bank, angle of the wings or the tail
uniform mat4 camera; uniform vec3 size;
out vec3 colour, at;
void main() {
  vec3 ahead = normalize(heading); float level = length(ahead.xy);
  vec3 side = level > 1e-6 ? vec3(-ahead.y, ahead.x, 0) / level : vec3(0, 1, 0), above = cross(ahead, side);
  vec3 left = side - pose.x * above, over = above + pose.x * side;
  vec2 swing = vec2(cos(pose.y), sin(pose.y));
  vec3 part = trait.y == 1. ? corner * vec3(1, swing) // wings
    : trait.y == 2. ? vec3(swing.x * corner.x - swing.y * corner.y, swing.y * corner.x + swing.x * corner.y, corner.z)
    : corner;
  vec3 point = size * (part + hinge);
  at = (1. + ink.a) * (point.x * ahead + inversesqrt(1. + pose.x * pose.x) * (point.y * left + point.z * over));
  gl_Position = camera * vec4(place + at, 1);
  colour = trait.x * ink.rgb + paint;
}`;
// Each triangle has one shade, by how far it looks upwards.
const SHAPE_FRAGMENT = `#version 300 es
precision highp float; in vec3 colour, at; out vec4 pixel;
void main() { pixel = vec4(colour * (.76 + .24 * normalize(cross(dFdx(at), dFdy(at))).z), 1); }`;
const GOLDEN = 0.6180339887498949;

class AgentShape {
  constructor(view) {
    this.view = view;
    this.words = view.manifest.shape;
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.forget();
  }

  // Whether so many agents are drawn by it; more are darts.
  fits(count) {
    return count <= (this.words.most ?? Infinity);
  }

  // The flock begins anew.
  forget() {
    this.animals = [];
    this.fastest = 0;
    this.beats = 0; // seconds for which they have been beating
    this.tick = Infinity;
  }

  prepare() {
    const { view } = this, { gl } = view, data = { corner: [], hinge: [], trait: [], paint: [] }, faces = [];
    for (const part of this.words.parts) {
      const first = data.corner.length / 3, ink = part.paint ? unhex(part.paint)[0] : [0, 0, 0];
      data.corner.push(...part.corners.map((one) => one / 1000));
      for (let k = 0; k < part.corners.length; k += 3) {
        data.trait.push(part.paint ? 0 : part.shade, part.beats);
        data.hinge.push(...part.hinge);
        data.paint.push(...ink.map((one) => one / 255));
      }
      faces.push(...part.faces.map((one) => first + one));
    }
    this.program = view.program(SHAPE_VERTEX, SHAPE_FRAGMENT);
    this.array = view.array();
    for (const name in data) view.buffer(this.program, name, name === "trait" ? 2 : 3, new Float32Array(data[name]));
    this.instances = [...view.instances(this.program), view.buffer(this.program, "pose", 2, null, 1)];
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(faces), gl.STATIC_DRAW);
    this.corners = faces.length;
  }

  draw(frame, headings, inks) {
    const { view } = this, { gl } = view, poses = this.follow(frame, headings);
    view.use(this.program, this.array);
    view.fill(this.instances, [view.places, headings, inks, poses]);
    gl.uniform3f(gl.getUniformLocation(this.program, "size"), ...this.size(frame));
    gl.drawElementsInstanced(gl.TRIANGLES, this.corners, gl.UNSIGNED_SHORT, 0, frame.ids.length);
  }

  // Length, width and height that the meshes' unit has.
  size(frame) {
    const { length, slim } = this.view, { scale, height } = this.words;
    return frame.car ? [length, slim * length, height * slim * length] : Array(3).fill(DART_LENGTH * scale * length);
  }

  // How all agents hold themselves, two numbers each, as FlockMotion of app/viewer/scene/marks/agents.py has it.
  // Who has crashed has another heading.
  follow(frame, headings) {
    const { ids, tick, time, speed, crashed } = frame, poses = new Float32Array(2 * ids.length);
    const { motion } = this.words;
    if (!motion) return poses;
    const now = performance.now() / 1000, passed = Math.min(now - this.seen, motion.longest);
    speed.forEach((one, row) => { if (!crashed[row]) this.fastest = Math.max(this.fastest, one); });
    const step = tick > this.tick ? this.step(frame, passed) : null;
    if (step) this.beats += Math.min(passed, motion.longest_beat);
    ids.forEach((id, row) => {
      const who = Number(id), heading = headings.subarray(3 * row, 3 * row + 3);
      const animal = this.move(who, heading, speed[row], step);
      poses[2 * row] = animal.lean;
      poses[2 * row + 1] = this.beat(who, animal.effort);
      if (crashed[row]) poses.set(this.layDown(who, heading, speed[row] > 0), 2 * row);
    });
    Object.assign(this, { seen: now, tick, time });
    return poses;
  }

  // What a frame means for all: how steep a turn is, and how far they ease into it.
  step(frame, passed) {
    const { motion } = this.words;
    const reach = Number.isFinite(frame.reach) ? frame.reach : Math.max(...this.view.manifest.size);
    const pull = this.fastest ** 2 / (motion.nimble * Math.max(reach, 1e-9));
    const [leans, eases] = [motion.lean, motion.ease].map((by) => 1 - Math.exp(-passed / by));
    return { steep: 1 / (Math.max(pull, 1e-12) * (frame.time - this.time)), leans, eases };
  }

  // An animal as it holds itself now; without a step as it did.
  move(who, [x, y, z], speed, step) {
    const { glide, gliding, steepest } = this.words.motion, effort = z < glide ? gliding : 1;
    const animal = this.animals[who] ??= { x, y, lean: 0, effort };
    if (step) {
      const lean = speed * leftTurn(animal, x, y) * step.steep;
      animal.lean += step.leans * (Math.max(-steepest, Math.min(steepest, lean)) - animal.lean);
      animal.effort += step.eases * (effort - animal.effort);
    }
    Object.assign(animal, { x, y });
    return animal;
  }

  // The angle of its wings or its tail; no two beat together.
  beat(who, effort) {
    const { beat, variety, dihedral, amplitude } = this.words.motion;
    const rate = beat * (1 + variety * (who * GOLDEN * GOLDEN % 1 - 0.5));
    const swing = this.calm.matches ? 0 : amplitude * effort;
    return dihedral + swing * Math.sin(2 * Math.PI * (this.beats * rate + who * GOLDEN));
  }

  // Who falls turns with its nose down; who lies is level.
  layDown(who, heading, falls) {
    const { dive, spin, folded, flat } = this.words.motion, nose = falls ? dive : 0;
    const turn = Math.atan2(heading[1], heading[0]) + (falls ? spin * this.beats : 0) + who * GOLDEN;
    heading.set([Math.cos(turn) * Math.cos(nose), Math.sin(turn) * Math.cos(nose), Math.sin(nose)]);
    return [0, falls ? folded : flat];
  }
}

// How far somebody has turned to the left, at most a right angle.
function leftTurn(before, x, y) {
  const level = Math.hypot(before.x, before.y), left = before.x * y - before.y * x;
  return level > 1e-9 ? Math.asin(Math.max(-1, Math.min(1, left / level))) : 0;
}
