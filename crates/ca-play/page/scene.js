// What is drawn, and from where it is looked at.
//
// Decides that places are computed here, once a frame, into arrays that stay: rest + axis · displacement · exaggeration
// on a line, rest + displacement · exaggeration in space. Between the two last pictures they move in a straight line.

export class Scene {
  constructor(drawing, generation) {
    const n = drawing.masses;
    this.n = n;
    this.generation = generation;
    this.rest = Float32Array.from(drawing.rest);
    this.axis = Float32Array.from(drawing.axis);
    this.space = Uint8Array.from(drawing.space);
    this.fixed = Uint8Array.from(drawing.fixed);
    this.kind = Uint8Array.from(drawing.kind);
    this.kinds = drawing.kinds;
    this.links = drawing.links;
    this.spheres = drawing.spheres ?? [];
    this.at = this.rest.slice();
    this.colour = new Float32Array(n);
    this.speed = new Float32Array(n);
    this.views = [];
    this.peak = 0;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < 3 * n; i++) {
      low[i % 3] = Math.min(low[i % 3], this.rest[i]);
      high[i % 3] = Math.max(high[i % 3], this.rest[i]);
    }
    for (const { centre, radius } of this.spheres) {
      for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], centre[k] - radius);
        high[k] = Math.max(high[k], centre[k] + radius);
      }
    }
    [this.low, this.high] = [low, high];
    this.middle = n ? low.map((l, k) => (l + high[k]) / 2) : [0, 0, 0];
    this.size = Math.max(1e-6, Math.hypot(...low.map((l, k) => high[k] - l)) / 2 || 0.05);
    this.up = drawing.up ?? [0, 0, 1];
    this.flat = this.space.every((s) => s === 0);
    // a sheet lies in both directions across its motion, and is seen from above
    const across = low.map((l, k) => (high[k] - l) * (1 - Math.abs(this.up[k]))).sort((a, b) => b - a);
    this.sheet = across[1] > 0.15 * across[0];
    this.radius = Math.min(0.025 * this.size, Math.max(0.005 * this.size, 0.42 * this.spacing()));
  }

  /** Median length of the links, contacts aside: where neighbours stand near, masses are small. */
  spacing() {
    const all = [];
    for (const { contact, ends } of this.links) {
      for (let i = 0; !contact && i < ends.length && all.length < 20000; i += 2) {
        const [a, b] = [3 * ends[i], 3 * ends[i + 1]];
        all.push(Math.hypot(...[0, 1, 2].map((k) => this.rest[a + k] - this.rest[b + k])));
      }
    }
    all.sort((a, b) => a - b);
    return all.length ? all[all.length >> 1] : this.size / Math.sqrt(Math.max(1, this.n));
  }

  /** A picture came: tick, and displacements. */
  view(tick, x, now) {
    const last = this.views[this.views.length - 1];
    if (last && tick <= last.tick) this.views.length = 0;
    this.views.push({ tick, x: x.slice(), now });
    if (this.views.length > 2) this.views.shift();
    if (this.views.length < 2) return;
    const [a, b] = this.views;
    const dt = b.now - a.now || 16;
    let peak = 0;
    for (let i = 0, j = 0; i < this.n; i++) {
      const many = this.space[i] ? 3 : 1;
      let moved = 0;
      for (let k = 0; k < many; k++, j++) {
        const d = b.x[j] - a.x[j];
        moved += d * d;
        if (!this.space[i] && !this.fixed[i]) peak = Math.max(peak, Math.abs(b.x[j]));
      }
      this.speed[i] = Math.sqrt(moved) / dt;
    }
    // quick up, slow down: motion is visible, and does not jump
    this.peak = peak > this.peak ? peak : Math.max(peak, this.peak * 0.985);
  }

  /** The exaggeration that shows what moves on a line. */
  automatic() {
    const wanted = this.peak > 0 ? (0.16 * this.size) / this.peak : 1;
    this.shown = this.shown ? this.shown * Math.pow(wanted / this.shown, 0.06) : wanted;
    return this.shown;
  }

  /** Places and colours for a moment. */
  update(now, gain, colour) {
    const { views, at, rest, axis, space } = this;
    if (!views.length) return;
    const b = views[views.length - 1], a = views[0];
    const t = views.length > 1 ? Math.min(1, (now - b.now) / Math.max(1, b.now - a.now)) : 1;
    let most = 1e-12;
    for (let i = 0, j = 0; i < this.n; i++) {
      const p = 3 * i;
      if (space[i]) {
        let u = 0;
        for (let k = 0; k < 3; k++, j++) {
          const x = a.x[j] + t * (b.x[j] - a.x[j]);
          at[p + k] = rest[p + k] + x;
          u += x * x;
        }
        this.colour[i] = colour === "place" ? Math.sqrt(u) : this.speed[i];
      } else {
        const x = a.x[j] + t * (b.x[j] - a.x[j]);
        j++;
        for (let k = 0; k < 3; k++) at[p + k] = rest[p + k] + axis[p + k] * x * gain;
        this.colour[i] = colour === "place" ? Math.abs(x) : this.speed[i];
      }
      if (colour === "kind") this.colour[i] = this.kinds.length > 1 ? this.kind[i] / (this.kinds.length - 1) : 0.5;
      else most = Math.max(most, this.colour[i]);
    }
    if (colour === "kind") return;
    this.most = Math.max(most, (this.most ?? most) * 0.97);
    for (let i = 0; i < this.n; i++) this.colour[i] = Math.sqrt(this.colour[i] / this.most);
  }
}

/** A camera that turns about the middle of a scene. */
export class Camera {
  constructor(scene) {
    this.scene = scene;
    this.reset();
  }

  reset() {
    this.turn = this.scene.flat ? (this.scene.sheet ? 0.45 : 0) : 0.6;
    this.tilt = this.scene.sheet ? 0.6 : this.scene.flat ? 0.06 : 0.35;
    this.zoom = 1;
    this.home = this.axes();
  }

  orbit(dx, dy) {
    this.turn -= dx * 0.007;
    this.tilt = Math.max(-1.5, Math.min(1.5, this.tilt + dy * 0.007));
  }

  scale(by) {
    this.zoom = Math.max(0.2, Math.min(20, this.zoom * by));
  }

  /** Right, up and forward of the eye. */
  axes() {
    const up = this.scene.up;
    const side = Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    const along = cross(up, side), right0 = cross(along, up);
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)];
    const right = right0.map((v, k) => c * v + s * along[k]);
    const level = cross(up, right);
    const [ct, st] = [Math.cos(this.tilt), Math.sin(this.tilt)];
    const forward = level.map((v, k) => ct * v - st * up[k]);
    return { right, up: cross(right, forward), forward };
  }

  /** World to clip space, column by column, for a picture of so many pixels. */
  matrix(width, height) {
    const { right, up, forward } = this.axes();
    const m = this.scene.middle, r = this.scene.size;
    // the box of the scene as it is seen, with room for motion, fills the picture
    const half = (axis, more) => {
      const { low, high, size } = this.scene;
      return Math.max(0.05 * size, axis.reduce((sum, v, k) => sum + Math.abs(v) * (high[k] - low[k]) * 0.5, 0)) + more * size;
    };
    const moves = this.scene.flat ? 0.2 : 0.08;
    const [w, h] = [half(this.home.right, 0.08), half(this.home.up, moves)];
    const scale = Math.min((0.9 * width) / w, (0.78 * height) / h) * this.zoom;
    const [sx, sy] = [scale / Math.max(1, width), scale / Math.max(1, height)];
    const dot = (a) => a[0] * m[0] + a[1] * m[1] + a[2] * m[2];
    const z = 0.25 / r / Math.max(1, this.zoom);
    this.pixel = 2 / scale;
    this.clip = [sx, sy, z];
    const rows = [right.map((v) => v * sx), up.map((v) => v * sy), forward.map((v) => v * z)];
    const shift = [-dot(right) * sx, -dot(up) * sy, -dot(forward) * z];
    const out = new Float32Array(16);
    for (let k = 0; k < 3; k++) {
      for (let j = 0; j < 3; j++) out[4 * j + k] = rows[k][j];
      out[12 + k] = shift[k];
    }
    out[15] = 1;
    return out;
  }
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
