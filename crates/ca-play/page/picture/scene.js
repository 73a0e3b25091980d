// Drawing of a scene as flat arrays, and the drawn position of each mass. The position is rest + displacement × factor;
// masses on a line move along their axis. Displacements beyond `reach` are compressed smoothly, so that a hammer that
// flew off stays visible. Masses in space are drawn at their true position. The vertex shaders of gl.js compute the
// same from the same numbers.

export class Scene {
  /** @param {Pick<import("../protocol.js").SceneMessage, "drawing"|"generation"|"ports">} message */
  constructor(message) {
    const d = message.drawing, n = d.masses | 0;
    this.message = message;
    this.generation = message.generation;
    this.n = n;
    this.space = Uint8Array.from(d.space || [], Number);
    this.fixed = Uint8Array.from(d.fixed || [], Number);
    this.kind = Uint16Array.from(d.kind || [], Number);
    if (this.space.length < n) this.space = new Uint8Array(n);
    if (this.fixed.length < n) this.fixed = new Uint8Array(n);
    if (this.kind.length < n) this.kind = new Uint16Array(n);
    this.kinds = d.kinds || [];
    this.axis = Float32Array.from(d.axis || []);
    if (this.axis.length < 3 * n) this.axis = new Float32Array(3 * n);
    this.links = (d.links || []).map(l => ({ kind: l.kind, contact: !!l.contact, ends: Uint32Array.from(l.ends) }));
    this.spheres = d.spheres || [];
    this.decimated = d.decimated || null;
    this.up = Array.isArray(d.up) && d.up.length === 3 && Math.hypot(...d.up) > 0.5 ? d.up : null;

    this.measure(d.rest || []);
    this.offset = new Uint32Array(n + 1);
    this.lines = 0;
    for (let i = 0; i < n; i++) {
      this.offset[i + 1] = this.offset[i] + (this.space[i] ? 3 : 1);
      if (!this.space[i]) this.lines++;
    }
    this.numbers = this.offset[n];
    this.linear = this.lines > 0;
    this.spatial = this.lines < n;
    this.count();
    this.radius = this.size();
    this.reach = 0.42 * this.extent;
    // before any motion, assumes a largest motion of 5 mm, so that a first pull is not violent
    this.line = Math.max(1, 0.1 * this.extent / 5e-3);
    this.true = 1;
    this.port = new Uint8Array(n);
    for (const p of message.ports || []) if (p.mass != null && p.mass >= 0 && p.mass < n) this.port[p.mass] = 1;
  }

  // rest positions relative to the centre of the drawing, and its size [m]
  measure(rest) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const take = (k, v) => {
      if (!Number.isFinite(v)) return;
      if (v < low[k]) low[k] = v;
      if (v > high[k]) high[k] = v;
    };
    for (let i = 0; i < 3 * this.n; i++) take(i % 3, rest[i]);
    for (const s of this.spheres) for (let k = 0; k < 3; k++) { take(k, s.centre[k] - s.radius); take(k, s.centre[k] + s.radius); }
    this.middle = low.map((l, k) => (l <= high[k] ? (l + high[k]) / 2 : 0));
    const span = low.map((l, k) => (l <= high[k] ? high[k] - l : 0));
    this.span = span;
    this.extent = Math.hypot(...span) || 0.1;
    this.rest = new Float32Array(3 * this.n);
    for (let i = 0; i < 3 * this.n; i++) this.rest[i] = (Number.isFinite(rest[i]) ? rest[i] : 0) - this.middle[i % 3];
  }

  // masses that count for the size of the motion: those with a link other than a contact, or all if few have one
  count() {
    this.counted = new Uint8Array(this.n);
    let held = 0;
    for (const l of this.links) {
      if (l.contact) continue;
      for (const e of l.ends) if (e < this.n && !this.counted[e]) { this.counted[e] = 1; held++; }
    }
    if (held < this.n / 4) this.counted.fill(1);
  }

  // radius of a mass in the drawing [m], from the distance between neighbours
  size() {
    const lengths = [];
    for (const l of this.links) {
      if (l.contact) continue;
      const step = 2 * Math.max(1, Math.floor(l.ends.length / 2 / 500));
      for (let i = 0; i + 1 < l.ends.length; i += step) {
        const a = 3 * l.ends[i], b = 3 * l.ends[i + 1], r = this.rest;
        const length = Math.hypot(r[a] - r[b], r[a + 1] - r[b + 1], r[a + 2] - r[b + 2]);
        if (length > 1e-9) lengths.push(length);
      }
    }
    const dimensions = this.span.filter(s => s > 0.02 * this.extent).length || 1;
    const spread = 0.2 * this.extent / Math.max(1, this.n) ** (1 / dimensions);
    if (lengths.length < 3) return Math.min(Math.max(spread, 0.004 * this.extent), 0.03 * this.extent);
    lengths.sort((a, b) => a - b);
    return Math.min(0.3 * lengths[lengths.length >> 1], 0.022 * this.extent);
  }

  // expands a view to four numbers per mass: displacement in the drawing [m], and its amount, signed on a line
  expand(u, out) {
    const { n, space, axis } = this;
    let at = 0;
    for (let i = 0, a = 0, o = 0; i < n; i++, a += 3, o += 4) {
      if (space[i]) {
        const x = u[at], y = u[at + 1], z = u[at + 2];
        at += 3;
        out[o] = x; out[o + 1] = y; out[o + 2] = z;
        out[o + 3] = Math.sqrt(x * x + y * y + z * z);
      } else {
        const v = u[at++];
        out[o] = v * axis[a]; out[o + 1] = v * axis[a + 1]; out[o + 2] = v * axis[a + 2];
        out[o + 3] = v;
      }
    }
  }

  // drawn position of mass i from two views and the weight of the second, into out[at..at+3]
  place(i, pair, out, at = 0) {
    const { a, b, mix } = pair, r = 3 * i, o = this.offset[i];
    if (this.space[i]) {
      for (let k = 0; k < 3; k++) out[at + k] = this.rest[r + k] + (a[o + k] + (b[o + k] - a[o + k]) * mix) * this.true;
    } else {
      const drawn = this.near((a[o] + (b[o] - a[o]) * mix) * this.line);
      for (let k = 0; k < 3; k++) out[at + k] = this.rest[r + k] + drawn * this.axis[r + k];
    }
  }

  // compresses a drawn displacement to stay within reach
  near(drawn) {
    const size = Math.abs(drawn), knee = 0.7 * this.reach;
    if (size <= knee) return drawn;
    return Math.sign(drawn) * (knee + 0.3 * this.reach * (1 - Math.exp((knee - size) / (0.3 * this.reach))));
  }
}
