// Keeps a flock in the picture that flies out of its open world, as app/viewer/scene/cameras/viewpoints.py does, until
// somebody shifts the picture. Only pages of open worlds have this.
{
  const BEYOND = 0.02, AHEAD = 0.25, ROOM = 0.3; // of the longest side that is shown
  const MOST = 4, FAR = 8; // of the world's longest side: from where on the world is not shown, nor who is farther apart
  const { home, draw, shift, magnify } = View.prototype;
  const longest = ([low, high]) => Math.max(...low.map((from, axis) => high[axis] - from));
  Object.assign(View.prototype, {
    home() {
      home.call(this);
      this.follows = this.manifest.edges.includes("open");
      this.shows = null;
      this.closer = 1;
    },
    shift(dx, dy) {
      if (this.manifest.dim === 2) this.follows = false;
      shift.call(this, dx, dy);
    },
    magnify(times) {
      if (!this.follows) return magnify.call(this, times);
      this.closer = Math.min(50, Math.max(0.2, this.closer * times));
      this.changed();
    },
    draw(frame, dark) {
      if (this.begins || frame.tick < this.tick) this.shows = null;
      if (this.follows) this.follow(frame);
      draw.call(this, frame, dark);
    },
    follow(frame) {
      const { low, size, dim } = this.manifest, world = [[...low], low.map((from, axis) => from + size[axis])];
      const [box, more] = this.extent(frame, world), side = this.shows && longest(this.shows);
      const isOut = this.shows && box[0].some((from, axis) =>
        Math.max(this.shows[0][axis] - from, box[1][axis] - this.shows[1][axis]) > BEYOND * side);
      if (!this.shows || isOut) {
        const room = this.shows ? more * longest(box) : 0;
        this.shows = [box[0].map((from) => from - room), box[1].map((to) => to + room)];
      }
      const sides = this.shows[0].map((from, axis) => this.shows[1][axis] - from);
      this.centre = [0, 1, 2].map((axis) => axis < dim ? this.shows[0][axis] + sides[axis] / 2 : 0);
      const fits = dim === 2 ? Math.min(size[0] / sides[0], size[1] / sides[1]) : Math.hypot(...size) / Math.hypot(...sides);
      this.zoom = this.closer * fits;
    },
    // The box of the world and of the flock, or of the flock alone where that would be too large; and how much more is shown.
    extent({ position, crashed, kind }, world) {
      const { dim } = this.manifest, rows = [...crashed.keys()].filter((row) => !crashed[row] && !(kind?.[row] < 0));
      if (!rows.length) return [world, AHEAD];
      const few = Math.floor(0.02 * rows.length), flock = [[], []], both = [[], []];
      for (let axis = 0; axis < dim; axis++) {
        const along = Float64Array.from(rows, (row) => position[dim * row + axis]).sort();
        const middle = along[along.length >> 1], half = FAR * longest(world) / 2;
        const ends = [Math.max(along[few], middle - half), Math.min(along[along.length - 1 - few], middle + half)];
        const lacks = world[1][axis] - world[0][axis] - ends[1] + ends[0];
        both[0].push(Math.min(world[0][axis], ends[0]));
        both[1].push(Math.max(world[1][axis], ends[1]));
        flock[0].push(ends[0] - Math.max(0, lacks / 2));
        flock[1].push(ends[1] + Math.max(0, lacks / 2));
      }
      return longest(both) > MOST * longest(world) ? [flock, ROOM] : [both, AHEAD];
    },
  });
}
