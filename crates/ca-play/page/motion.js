// Interpolates views, which arrive at irregular times, to a motion at the screen rate. Also sets the delay of the
// picture behind the newest view (one interval plus the jitter of the network) and the exaggeration of motion on a
// line. Most of the motion stays visible even if a few keys move a hundred times as far. The factor settles within a
// second once something moves and changes slowly afterwards. So a decay stays visible as a decay, and silence is not
// magnified into noise.

const KEPT = 8;
// time constants of the factor [s]: to settle, and afterwards; and the error at which it settles again
const SETTLES = 1, QUICK = 0.2, SLOW = 5, WRONG = Math.log(10);
// a mass below this fraction of the largest motion counts as still
const STILL = 1e-3;
// below this fraction of the peak, motion is not magnified further
const FADED = 0.05;

export class Motion {
  constructor(scene) {
    this.scene = scene;
    this.views = [];
    this.serial = 0;
    this.offset = null;
    this.interval = 1 / 60;
    this.uneven = 0;
    this.head = -Infinity;
    this.pair = null;
    const zero = { u: new Float32Array(scene.numbers), seconds: 0, serial: this.serial++ };
    this.still = { a: zero.u, b: zero.u, mix: 0, dt: 1, from: zero, to: zero };
    this.peak = 0;          // running peak of displacement on a line [m]
    this.most = 0;          // largest value of that peak
    this.speed = 0;         // running peak of speed [m/s]
    this.far = 0;           // running peak of displacement of all masses [m]
    this.lineLog = Math.log(scene.line);
    this.auto = true;
    this.middle = new Float32Array(scene.n);   // recent average position of each mass on a line [m]
    this.settled = 0;       // time until which the factor changes quickly [s]
    this.frozen = false;    // true while a hand holds a mass: the factor must not change
    this.last = 0;
  }

  push(u, seconds, now) {
    if (u.length !== this.scene.numbers) return false;
    let last = this.views[this.views.length - 1];
    if (last && seconds <= last.seconds) {
      if (last.seconds - seconds < 1e-9) return false;
      this.views.length = 0;
      this.offset = null;
      last = undefined;
    }
    const here = now - seconds;
    if (this.offset === null || Math.abs(here - this.offset) > 0.6) {
      this.offset = here;
      this.head = -Infinity;
    } else {
      const late = here - this.offset;
      this.uneven += (Math.abs(late) - this.uneven) * 0.05;
      this.offset += late * (late < 0 ? 0.3 : 0.03);
    }
    if (last) {
      const gap = Math.min(seconds - last.seconds, 0.5);
      this.interval += (gap - this.interval) * 0.1;
      this.measure(last.u, u, seconds - last.seconds);
    }
    this.views.push({ u, seconds, serial: this.serial++ });
    if (this.views.length > KEPT) this.views.shift();
    return true;
  }

  measure(before, u, dt) {
    const { n, offset, space, counted } = this.scene;
    let line = 0, far = 0, fast = 0;
    for (let i = 0; i < n; i++) {
      if (!counted[i]) continue;
      const o = offset[i];
      if (space[i]) {
        const x = u[o], y = u[o + 1], z = u[o + 2], p = x - before[o], q = y - before[o + 1], r = z - before[o + 2];
        const d = x * x + y * y + z * z, v = p * p + q * q + r * r;
        if (d > far) far = d;
        if (v > fast) fast = v;
      } else {
        const d = u[o] * u[o], v = u[o] - before[o];
        if (d > line) line = d;
        if (v * v > fast) fast = v * v;
      }
    }
    line = Math.sqrt(line);
    const typical = this.typical(u, dt);
    far = Math.sqrt(Math.max(far, line * line)); fast = Math.sqrt(fast) / dt;
    const hold = Math.exp(-dt / 9), rise = 1 - Math.exp(-dt / 0.1), lets = Math.exp(-dt / 0.4), takes = 1 - Math.exp(-dt / 0.3);
    const follow = (old, fresh) => (fresh > old ? (old === 0 ? fresh : old + (fresh - old) * rise) : Math.max(fresh, old * hold));
    // a short excursion, such as a key struck before its string, does not set the peak
    if (Number.isFinite(typical)) this.peak = typical > this.peak ? this.peak + (typical - this.peak) * takes : Math.max(typical, this.peak * lets);
    if (Number.isFinite(far)) this.far = follow(this.far, far);
    if (Number.isFinite(fast)) this.speed = follow(this.speed, fast);
    this.most = Math.max(this.most, this.peak);
  }

  // typical displacement of masses on a line from their recent average position, so that a held key counts as still.
  // The geometric mean gives little weight to a few masses that move far; for the shape of a string it is half the
  // displacement at the middle, so it is doubled
  typical(u, dt) {
    const { n, offset, space, counted } = this.scene, middle = this.middle, share = 1 - Math.exp(-dt / 0.5);
    let most = 0;
    for (let i = 0; i < n; i++) {
      if (!counted[i] || space[i]) continue;
      middle[i] += share * (u[offset[i]] - middle[i]);
      most = Math.max(most, Math.abs(u[offset[i]] - middle[i]));
    }
    let sum = 0, moving = 0;
    for (let i = 0; i < n; i++) {
      if (!counted[i] || space[i]) continue;
      const d = Math.abs(u[offset[i]] - middle[i]);
      if (d > STILL * most) { sum += Math.log(d); moving++; }
    }
    return moving ? 2 * Math.exp(sum / moving) : 0;
  }

  // the two views around the moment drawn at `now` [s], and the weight of the second
  at(now) {
    const views = this.views;
    if (views.length === 0) return this.still;
    if (views.length === 1) return { a: views[0].u, b: views[0].u, mix: 0, dt: 1, from: views[0], to: views[0] };
    const behind = Math.min(1.1 * this.interval + 2 * this.uneven + 0.002, 0.4);
    this.head = Math.max(this.head, now - this.offset - behind);
    let k = views.length - 1;
    while (k > 1 && views[k - 1].seconds > this.head) k--;
    const from = views[k - 1], to = views[k], dt = to.seconds - from.seconds;
    const mix = Math.min(1, Math.max(0, (this.head - from.seconds) / dt));
    return { a: from.u, b: to.u, mix, dt, from, to };
  }

  // updates the exaggeration on lines, once per frame
  exaggerate(now) {
    const dt = Math.min(0.1, Math.max(0, now - this.last)), scene = this.scene;
    this.last = now;
    if (!this.auto || this.frozen || !scene.linear) return scene.line;
    const peak = Math.max(this.peak, FADED * this.most);
    if (!(peak > 1e-9)) return scene.line;
    const want = Math.log(Math.min(1e9, Math.max(1e-3, 0.1 * scene.extent / peak)));
    if (this.settled === 0 || want < this.lineLog - WRONG) this.settled = Math.max(this.settled, now + SETTLES);
    const time = now < this.settled ? QUICK : SLOW;
    this.lineLog += (want - this.lineLog) * (1 - Math.exp(-dt / time));
    scene.line = Math.exp(this.lineLog);
    return scene.line;
  }

  // continues the motion of the scene before an edit, so that the picture does not jump
  carry(before) {
    for (const name of ["peak", "most", "speed", "far", "lineLog", "auto", "settled", "interval", "uneven"]) this[name] = before[name];
    this.scene.line = before.scene.line;
    this.scene.true = before.scene.true;
  }

  // sets the factor manually; null returns to automatic
  setLine(factor) {
    this.auto = factor === null;
    if (factor === null) return;
    this.scene.line = factor;
    this.lineLog = Math.log(factor);
  }
}
