// Pointer interaction: the mass under the pointer, the held masses, their target positions, and the camera. A press near
// a mass holds it, a tap plucks it, and a press elsewhere turns the picture. Each finger can hold one mass. The pull
// is relative to the point where the mass was taken, so that taking it does not move it. Drags are sent at most 120 times
// per second for each finger, but the last position always is. Every end of a press releases the mass: up, cancel, blur,
// a lost connection, or another scene.

const REACH = { mouse: 20, pen: 22, touch: 32 };
// time between two drags of a finger [ms], for at most four fingers; more fingers share these messages
const LEAST = 1000 / 120;
// as many as the engine has
const FINGERS = 10;

export class Pointer {
  // world: canvas, camera, scene(), pair(), send(message), ask(message) -> promise, held(masses), hover(mass, x, y), refuse(text, x, y)
  /**
   * @param {Record<string, any> & Pick<import("./messages.js").Messages, "send"|"ask">} world
   */
  constructor(world) {
    this.world = world;
    this.downs = new Map();
    // by the number of the pointer; -1 is the keyboard
    this.grips = new Map();
    this.hover = -1;
    this.spot = null;
    this.enabled = true;
    this.turned = false;
    const c = world.canvas;
    c.addEventListener("pointerdown", e => this.down(e));
    c.addEventListener("pointermove", e => this.move(e));
    if ("onpointerrawupdate" in window) c.addEventListener("pointerrawupdate", e => { if (this.grips.has(e.pointerId)) this.move(e); });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) c.addEventListener(name, e => this.up(e));
    c.addEventListener("pointerleave", e => { if (!this.downs.has(e.pointerId)) { this.spot = null; this.show(-1); } });
    c.addEventListener("wheel", e => this.wheel(e), { passive: false });
    c.addEventListener("contextmenu", e => e.preventDefault());
    c.addEventListener("keydown", e => this.key(e));
    addEventListener("blur", () => this.releaseAll());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.releaseAll(); });
  }

  at(e) {
    const r = this.world.canvas.getBoundingClientRect();
    return [e.clientX - r.left, e.clientY - r.top];
  }

  // the mass nearest to a point on the screen within a radius; a fixed mass only without another one
  pick(x, y, radius) {
    const { camera } = this.world, scene = this.world.scene();
    if (!scene) return -1;
    const pair = this.world.pair(), p = this.room || (this.room = new Float64Array(6));
    let best = -1, least = radius * radius, nearest = Infinity;
    for (let i = 0; i < scene.n; i++) {
      scene.place(i, pair, p, 0);
      camera.project(p, 0, p, 3);
      if (!(p[5] > 0)) continue;
      const dx = p[3] - x, dy = p[4] - y, ball = Math.min(12, scene.radius * camera.scale / p[5]);
      let d = Math.max(0, Math.hypot(dx, dy) - ball * 0.8);
      if (scene.fixed[i]) d += 0.3 * radius;
      d *= d;
      if (d > least || (d === least && p[5] >= nearest)) continue;
      least = d; best = i; nearest = p[5];
    }
    return best;
  }

  down(e) {
    const [x, y] = this.at(e), { canvas } = this.world;
    if (e.pointerType !== "touch") canvas.focus({ preventScroll: true, focusVisible: false });
    if (this.downs.size === 0) this.turned = false;
    const hold = { x, y, kind: "turn" };
    this.downs.set(e.pointerId, hold);
    try { canvas.setPointerCapture(e.pointerId); } catch { /* a pointer that is gone again */ }
    e.preventDefault();
    if (e.pointerType === "mouse" && e.button === 1 || e.shiftKey) { hold.kind = "pan"; return; }
    if (e.button === 2) return;
    // a tapped mass is still being plucked
    if (this.grips.has(e.pointerId)) { hold.kind = "idle"; return; }
    const turns = this.downs.size > 1 && !this.grips.size;
    const mass = this.enabled && !turns && this.grips.size < FINGERS ? this.pick(x, y, REACH[e.pointerType] || 20) : -1;
    if (mass >= 0 && ![...this.grips.values()].some(g => g.mass === mass)) this.take(mass, e.pointerId, x, y);
    else if (this.grips.size) {
      // two fingers pressed together turn and zoom, if the second one does not meet a mass
      const only = e.pointerType === "touch" && this.grips.size === 1 && [...this.grips.values()].find(g => performance.now() - g.began < 250 && Math.hypot(g.x - g.startX, g.y - g.startY) < 12);
      if (only) this.release(only);
      else hold.kind = "idle";
    } else if (e.pointerType === "touch") this.show(-1);
  }

  held() {
    this.world.held([...this.grips.values()].map(g => g.mass));
  }

  // the smallest number of a finger that does not hold a mass
  finger() {
    const taken = new Set([...this.grips.values()].map(g => g.finger));
    return [...Array(FINGERS).keys()].find(f => !taken.has(f));
  }

  take(mass, pointer, x, y) {
    const scene = this.world.scene(), { camera } = this.world, p = new Float64Array(6);
    const pair = this.world.pair();
    scene.place(mass, pair, p, 0);
    camera.project(p, 0, p, 3);
    const space = !!scene.space[mass], o = scene.offset[mass];
    const now = k => pair.a[o + k] + (pair.b[o + k] - pair.a[o + k]) * pair.mix;
    const grip = { mass, pointer, finger: this.finger(), x, y, startX: x, startY: y, space, depth: p[5], generation: scene.generation, began: performance.now(), sent: null, last: -Infinity, timer: 0 };
    if (space) {
      grip.from = [now(0), now(1), now(2)];
      grip.anchor = camera.unproject(x, y, p[5]);
    } else {
      // a mass drawn at the edge of the picture is taken at its drawn position
      const drawn = scene.near(now(0) * scene.line);
      grip.from = [drawn / scene.line];
    }
    this.grips.set(pointer, grip);
    this.held();
    this.show(-1);
    this.world.ask({ type: "grab", mass, finger: grip.finger }).then(reply => {
      if (this.grips.get(pointer) !== grip) return;
      if (reply.ok === false) {
        // without an answer, the server may still hold the mass
        this.release(grip, !!reply.lost);
        const hold = this.downs.get(pointer);
        if (hold) hold.kind = "idle";
        if (!reply.lost) this.world.refuse(reply.text || "This mass cannot be held.", grip.x, grip.y);
      }
    });
    this.pull(grip, true);
  }

  // displacement from rest requested by the pointer [m]
  wanted(g) {
    const scene = this.world.scene(), { camera } = this.world;
    if (g.space) {
      const here = camera.unproject(g.x, g.y, g.depth), f = scene.true || 1;
      return [0, 1, 2].map(k => g.from[k] + (here[k] - g.anchor[k]) / f);
    }
    const p = new Float64Array(6), q = new Float64Array(6), i = 3 * g.mass, step = 0.01 * scene.extent;
    for (let k = 0; k < 3; k++) { p[k] = scene.rest[i + k]; q[k] = p[k] + step * scene.axis[i + k]; }
    camera.project(p, 0, p, 3); camera.project(q, 0, q, 3);
    let gx = (q[3] - p[3]) / step, gy = (q[4] - p[4]) / step;
    const full = camera.scale / p[5];
    // an axis towards the viewer is pulled by vertical movement
    if (Math.hypot(gx, gy) < 0.15 * full) { gx = 0; gy = -full; }
    const drawn = ((g.x - g.startX) * gx + (g.y - g.startY) * gy) / (gx * gx + gy * gy);
    return [g.from[0] + drawn / scene.line];
  }

  pull(g, force = false) {
    const now = performance.now(), least = LEAST * Math.max(1, this.grips.size / 4);
    if (!force && now - g.last < least) {
      if (!g.timer) g.timer = setTimeout(() => { g.timer = 0; if (this.grips.get(g.pointer) === g) this.pull(g); }, least - (now - g.last));
      return;
    }
    const by = this.wanted(g);
    if (!by.every(Number.isFinite)) return;
    if (g.sent && by.every((v, k) => v === g.sent[k])) return;
    g.last = now;
    g.sent = by;
    this.world.send({ type: "drag", finger: g.finger, by });
  }

  move(e) {
    const [x, y] = this.at(e), hold = this.downs.get(e.pointerId), { camera } = this.world;
    if (!hold) {
      if (e.pointerType !== "touch") this.spot = [x, y, e.pointerType];
      return;
    }
    const dx = x - hold.x, dy = y - hold.y;
    const grip = this.grips.get(e.pointerId);
    if (grip) {
      hold.x = grip.x = x; hold.y = grip.y = y;
      this.pull(grip);
      return;
    }
    const turning = [...this.downs.values()].filter(h => h.kind !== "idle");
    if (hold.kind === "idle" || (dx === 0 && dy === 0)) return;
    if (turning.length >= 2 && !this.grips.size) {
      const other = turning.find(h => h !== hold);
      const before = Math.hypot(hold.x - other.x, hold.y - other.y), after = Math.hypot(x - other.x, y - other.y);
      if (before > 10 && after > 10) camera.zoom(before / after, (x + other.x) / 2, (y + other.y) / 2);
      camera.orbit(dx / 2, dy / 2);
    } else if (hold.kind === "pan") camera.pan(dx, dy);
    else camera.orbit(dx, dy);
    this.turned = true;
    hold.x = x; hold.y = y;
    if (this.world.turned) this.world.turned();
  }

  up(e) {
    const known = this.downs.delete(e.pointerId);
    const g = this.grips.get(e.pointerId);
    if (g) {
      const tap = e.type === "pointerup" && performance.now() - g.began < 250 && Math.hypot(g.x - g.startX, g.y - g.startY) < 5;
      if (tap) this.pluck(g, 26, 70, e.pointerType === "touch");
      else if (!g.tapped) this.release(g);
    }
    else if (known && e.type === "pointerup" && !this.turned && e.pointerType === "touch") {
      const [x, y] = this.at(e);
      this.show(this.pick(x, y, REACH.touch), x, y);
    }
  }

  // releases the mass of one grip
  release(g, say = true) {
    clearTimeout(g.timer);
    this.grips.delete(g.pointer);
    if (say) this.world.send({ type: "release", finger: g.finger });
    this.held();
  }

  releaseAll(say = true) {
    for (const g of [...this.grips.values()]) this.release(g, say);
  }

  wheel(e) {
    e.preventDefault();
    const [x, y] = this.at(e), step = e.deltaY * (e.deltaMode === 1 ? 20 : e.deltaMode === 2 ? 400 : 1);
    this.world.camera.zoom(Math.exp(Math.min(240, Math.max(-240, step)) * (e.ctrlKey ? 0.008 : 0.0016)), x, y);
  }

  // keys: turn, zoom, go from mass to mass, pluck the marked mass
  key(e) {
    const { camera } = this.world, scene = this.world.scene();
    if (!scene || e.ctrlKey || e.metaKey || e.altKey) return;
    const turns = { ArrowLeft: [-24, 0], ArrowRight: [24, 0], ArrowUp: [0, -24], ArrowDown: [0, 24] };
    if (turns[e.key]) camera.orbit(...turns[e.key]);
    else if (e.key === "+" || e.key === "=") camera.zoom(0.85);
    else if (e.key === "-") camera.zoom(1 / 0.85);
    else if (e.key === "," || e.key === ".") {
      const step = (e.key === "." ? 1 : -1) * (e.shiftKey ? 10 : 1), p = new Float64Array(6);
      const after = k => (((k < 0 ? (step > 0 ? -1 : 0) : k) + step) % scene.n + scene.n) % scene.n;
      let next = scene.n ? after(this.hover) : -1;
      // fixed masses cannot be plucked
      for (let tries = 0; next >= 0 && scene.fixed[next] && tries < scene.n; tries++) next = after(next);
      this.spot = null;
      if (next < 0) return;
      scene.place(next, this.world.pair(), p, 0);
      camera.project(p, 0, p, 3);
      this.show(next, p[3], p[4]);
    } else if (e.key === "Enter" && this.hover >= 0) this.pluckMass(this.hover);
    else return;
    e.preventDefault();
  }

  pluckMass(mass) {
    if (this.grips.size) return;
    const scene = this.world.scene(), p = new Float64Array(6);
    scene.place(mass, this.world.pair(), p, 0);
    this.world.camera.project(p, 0, p, 3);
    this.take(mass, -1, p[3], p[4]);
    this.pluck(this.grips.get(-1), 50, 140);
  }

  // pulls a held mass up by `pixels` and releases it after `time` [ms]
  pluck(grip, pixels, time, tell = false) {
    grip.tapped = true;
    grip.y -= pixels;
    this.pull(grip, true);
    setTimeout(() => {
      if (this.grips.get(grip.pointer) !== grip) return;
      this.release(grip);
      // a finger cannot hover, so a tap shows the name of the mass
      if (tell) this.show(grip.mass, grip.x, grip.y);
    }, time);
  }

  show(mass, x = 0, y = 0) {
    this.hover = mass;
    this.world.hover(mass, x, y);
  }

  // once per frame: finds the mass under the pointer, and updates a pull after camera motion
  frame() {
    for (const g of [...this.grips.values()]) {
      const scene = this.world.scene();
      if (!scene || g.generation !== scene.generation) this.release(g, false);
      else this.pull(g);
    }
    if (this.grips.size) return;
    if (this.spot && this.downs.size === 0) {
      const [x, y, kind] = this.spot;
      const mass = this.enabled ? this.pick(x, y, REACH[kind] || 20) : -1;
      if (mass !== this.hover) this.show(mass, x, y);
    }
  }
}
