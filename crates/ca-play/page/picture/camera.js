// Camera: a target point, a distance, and two angles about the upright direction. The view at load shows strings from
// the front, sheets from above their edge, and bodies in space slightly from the side, as close as everything fits. The
// camera does not roll, so that a standing instrument stays upright.

const FIELD = 26 * Math.PI / 180;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const l = Math.hypot(...a) || 1; return a.map(v => v / l); };
const sum = (...pairs) => [0, 1, 2].map(k => pairs.reduce((s, [f, v]) => s + f * v[k], 0));

export class Camera {
  constructor() {
    this.width = 1; this.height = 1;
    this.target = [0, 0, 0];
    this.distance = 1; this.yaw = 0; this.pitch = 0;
    this.basis = { right: [1, 0, 0], up: [0, 1, 0], front: [0, 0, 1] };
    this.view = new Float32Array(16);
    this.projection = new Float32Array(16);
    this.touched = false;
    this.depth = 1;
    this.homeDistance = 1;
    this.aimed = null;
  }

  // sets the upright direction and the side towards the viewer from the orientation of the drawing
  aim(scene) {
    const { rest, axis, space, n } = scene;
    let up = [0, 0, 0];
    for (let i = 0; i < n; i++) {
      if (space[i]) continue;
      const x = axis[3 * i], y = axis[3 * i + 1], z = axis[3 * i + 2], s = x * up[0] + y * up[1] + z * up[2] < 0 ? -1 : 1;
      up[0] += s * x; up[1] += s * y; up[2] += s * z;
    }
    const onLine = scene.lines > n / 2 && Math.hypot(...up) > 0;
    up = scene.up ? unit(scene.up) : onLine ? unit(up) : [0, 1, 0];
    // the two directions across it, with the wider one drawn from left to right
    const any = Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1];
    const p = unit(sum([1, any], [-dot(any, up), up])), q = cross(p, up);
    let pp = 0, qq = 0, pq = 0;
    for (let i = 0, r = 0; i < n; i++, r += 3) {
      const x = rest[r] * p[0] + rest[r + 1] * p[1] + rest[r + 2] * p[2], y = rest[r] * q[0] + rest[r + 1] * q[1] + rest[r + 2] * q[2];
      pp += x * x; qq += y * y; pq += x * y;
    }
    const round = !onLine || Math.abs(pp - qq) + Math.abs(pq) < 0.2 * (pp + qq);
    const angle = round ? 0 : 0.5 * Math.atan2(2 * pq, pp - qq);
    let right = sum([Math.cos(angle), p], [Math.sin(angle), q]);
    if (right[0] < -1e-9 || (Math.abs(right[0]) <= 1e-9 && right[1] + right[2] < 0)) right = right.map(v => -v);
    this.basis = { right, up, front: cross(right, up) };
    const across = v => {
      let low = Infinity, high = -Infinity;
      for (let r = 0; r < 3 * n; r += 3) {
        const t = rest[r] * v[0] + rest[r + 1] * v[1] + rest[r + 2] * v[2];
        if (t < low) low = t;
        if (t > high) high = t;
      }
      return n ? high - low : 0;
    };
    const wide = across(right), deep = across(this.basis.front), tall = across(up);
    if (!onLine) this.home = { yaw: -0.42, pitch: 0.22 };
    else if (deep > 0.2 * wide && deep > tall) this.home = { yaw: -0.5, pitch: 0.56 };
    else this.home = { yaw: 0, pitch: deep > 0.01 * wide ? 0.2 : 0 };
  }

  // points that must be visible, four numbers each: position and radius; masses on a line have margin for their motion
  outline(scene, pair) {
    const { rest, axis, space, fixed, n, spheres, middle } = scene, out = new Float64Array(4 * (2 * n + spheres.length + 1));
    const swing = 0.13 * scene.extent;
    let k = 0;
    for (let i = 0; i < n; i++) {
      const s = space[i] || fixed[i] ? 0 : swing;
      for (const sign of s ? [1, -1] : [1]) {
        for (let j = 0; j < 3; j++) out[k + j] = rest[3 * i + j] + sign * s * axis[3 * i + j];
        // masses in space are at their present position
        if (pair && space[i]) scene.place(i, pair, out, k);
        k += 4;
      }
    }
    for (const ball of spheres) {
      for (let j = 0; j < 3; j++) out[k + j] = ball.centre[j] - middle[j];
      out[k + 3] = 1.15 * ball.radius;
      k += 4;
    }
    if (k === 0) { out[3] = 0.1; k = 4; }
    return out.subarray(0, k);
  }

  // sets the smallest distance that shows everything, at rest or at the present positions
  fit(scene, pair = null) {
    if (this.aimed !== scene) this.aim(scene);
    if (this.aimed !== scene || pair) this.points = this.outline(scene, pair);
    this.aimed = scene;
    this.yaw = this.home.yaw; this.pitch = this.home.pitch;
    this.touched = false;
    const { right, up, toward } = this.axes(), points = this.points;
    const tall = Math.tan(FIELD / 2), wide = tall * this.width / this.height;
    this.target = [0, 0, 0];
    let distance = 0;
    // the centre of the view depends on the distance through perspective: three rounds are enough
    for (let round = 0; round < 3; round++) {
      const [tx, ty, tz] = this.target;
      let l = Infinity, r = -Infinity, b = Infinity, t = -Infinity, best = 0;
      for (let k = 0; k < points.length; k += 4) {
        const dx = points[k] - tx, dy = points[k + 1] - ty, dz = points[k + 2] - tz, radius = points[k + 3];
        const x = dx * right[0] + dy * right[1] + dz * right[2], y = dx * up[0] + dy * up[1] + dz * up[2];
        const z = dx * toward[0] + dy * toward[1] + dz * toward[2];
        best = Math.max(best, (Math.abs(x) + radius) / wide + z, (Math.abs(y) + radius) / tall + z);
        const scale = distance > 0 ? distance / Math.max(distance - z, 0.1 * distance) : 1;
        l = Math.min(l, (x - radius) * scale); r = Math.max(r, (x + radius) * scale);
        b = Math.min(b, (y - radius) * scale); t = Math.max(t, (y + radius) * scale);
      }
      if (round < 2) this.target = sum([1, this.target], [(l + r) / 2, right], [(b + t) / 2, up]);
      distance = best;
    }
    this.depth = scene.extent;
    const margin = scene.spatial ? 1.22 : 1.1;
    this.distance = Math.max(distance * margin, 0.02 * scene.extent);
    this.homeDistance = this.distance;
    this.update();
    // compressed displacements must stay within the picture
    const half = this.distance * this.height / 2 / this.scale;
    scene.reach = Math.min(0.42 * scene.extent, Math.max(0.15 * scene.extent, 0.72 * half));
  }

  axes() {
    const { right, up, front } = this.basis, cy = Math.cos(this.yaw), sy = Math.sin(this.yaw), cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
    const toward = sum([cp * sy, right], [sp, up], [cp * cy, front]);
    const side = sum([cy, right], [-sy, front]);
    return { right: side, up: cross(toward, side), toward };
  }

  update() {
    const { right, up, toward } = this.axes(), v = this.view, t = this.target, near = 0.02 * this.distance;
    const far = this.distance + 20 * this.depth;
    for (let k = 0; k < 3; k++) {
      v[4 * k] = right[k]; v[4 * k + 1] = up[k]; v[4 * k + 2] = toward[k]; v[4 * k + 3] = 0;
    }
    v[12] = -dot(right, t); v[13] = -dot(up, t); v[14] = -dot(toward, t) - this.distance; v[15] = 1;
    const f = 1 / Math.tan(FIELD / 2), p = this.projection;
    p.fill(0);
    p[0] = f * this.height / this.width; p[5] = f;
    p[10] = (far + near) / (near - far); p[11] = -1; p[14] = 2 * far * near / (near - far);
    this.scale = f * this.height / 2;   // pixels per metre at unit distance
  }

  resize(width, height) {
    this.width = Math.max(1, width); this.height = Math.max(1, height);
    this.update();
  }

  orbit(dx, dy) {
    this.yaw -= dx * 0.0075;
    this.pitch = Math.min(1.55, Math.max(-1.55, this.pitch + dy * 0.0075));
    this.touched = true;
    this.update();
  }

  pan(dx, dy) {
    const { right, up } = this.axes(), metre = this.distance / this.scale;
    this.target = sum([1, this.target], [-dx * metre, right], [dy * metre, up]);
    this.touched = true;
    this.update();
  }

  // zooms by a factor and keeps the point under (x, y) in place
  zoom(factor, x = this.width / 2, y = this.height / 2) {
    const old = this.distance;
    this.distance = Math.min(40 * this.homeDistance, Math.max(0.01 * this.homeDistance, old * factor));
    const gone = (old - this.distance) / this.scale, { right, up } = this.axes();
    this.target = sum([1, this.target], [(x - this.width / 2) * gone, right], [-(y - this.height / 2) * gone, up]);
    this.touched = true;
    this.update();
  }

  // projects a point to the screen [px] and its depth [m], into out[to..to+3]
  project(p, at, out, to) {
    const v = this.view, x = p[at], y = p[at + 1], z = p[at + 2];
    const depth = -(v[2] * x + v[6] * y + v[10] * z + v[14]), s = this.scale / depth;
    out[to] = this.width / 2 + (v[0] * x + v[4] * y + v[8] * z + v[12]) * s;
    out[to + 1] = this.height / 2 - (v[1] * x + v[5] * y + v[9] * z + v[13]) * s;
    out[to + 2] = depth;
  }

  // the point under (x, y) in the plane parallel to the screen at a depth
  unproject(x, y, depth) {
    const { right, up, toward } = this.axes(), metre = depth / this.scale;
    return sum([1, this.target], [this.distance - depth, toward], [(x - this.width / 2) * metre, right], [-(y - this.height / 2) * metre, up]);
  }
}
