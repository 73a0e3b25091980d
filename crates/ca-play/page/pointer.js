// The hand: what is near, what is held, and how the eye turns.
//
// Decides that a press near a mass holds it, and that a press beside all of them turns the view; with a finger "near" is
// as wide as a finger. On a line a mass is pulled along its axis as it is drawn, in space in the plane of the picture.

const NEAR = { mouse: 16, pen: 20, touch: 30 };

export class Hand {
  constructor(canvas, socket, host) {
    Object.assign(this, { canvas, socket, host });
    this.marked = -1;
    this.held = null;
    this.fingers = new Map();
    this.sent = 0;
    const on = (name, f) => canvas.addEventListener(name, f.bind(this));
    on("pointerdown", this.down);
    on("pointermove", this.move);
    on("pointerup", this.up);
    on("pointercancel", this.up);
    on("lostpointercapture", this.up);
    on("pointerleave", () => this.held || this.mark(-1));
    on("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      host.camera?.scale(Math.exp(-e.deltaY * 0.0015));
    }, { passive: false });
    window.addEventListener("blur", () => this.release());
  }

  /** The mass nearest to a point of the picture, or −1. */
  near(x, y, within) {
    const { scene, camera } = this.host;
    if (!scene) return -1;
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const m = camera.matrix(w, h);
    let best = within * within, found = -1;
    for (let i = 0, p = 0; i < scene.n; i++, p += 3) {
      const [a, b, c] = [scene.at[p], scene.at[p + 1], scene.at[p + 2]];
      const dx = ((m[0] * a + m[4] * b + m[8] * c + m[12] + 1) / 2) * w - x;
      const dy = ((1 - (m[1] * a + m[5] * b + m[9] * c + m[13])) / 2) * h - y;
      const d = dx * dx + dy * dy + (scene.fixed[i] ? 60 : 0);
      if (d < best) [best, found] = [d, i];
    }
    return found;
  }

  mark(mass) {
    if (mass === this.marked) return;
    this.marked = mass;
    this.canvas.classList.toggle("near", mass >= 0);
    this.host.pointed(mass);
  }

  async down(e) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(e.pointerId);
    this.fingers.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (this.fingers.size > 1) return this.release();
    this.host.touched();
    const mass = e.button === 0 ? this.near(e.offsetX, e.offsetY, NEAR[e.pointerType] ?? 16) : -1;
    if (mass < 0) return;
    this.mark(mass);
    const { scene } = this.host;
    const p = 3 * mass;
    const gain = this.host.gain();
    const from = [0, 1, 2].map((k) => scene.at[p + k] - scene.rest[p + k]);
    const u = scene.space[mass] ? from : [from.reduce((s, v, k) => s + v * scene.axis[p + k], 0) / gain];
    const held = { mass, id: e.pointerId, start: [e.offsetX, e.offsetY], from: u, by: u, to: [...scene.at.subarray(p, p + 3)] };
    this.held = held;
    this.canvas.classList.add("held");
    const answer = await this.socket.ask({ type: "grab", mass });
    if (!answer.ok && this.held === held) {
      this.held = null;
      this.canvas.classList.remove("held");
      this.host.refused(answer.text);
    }
  }

  move(e) {
    const last = this.fingers.get(e.pointerId);
    if (!last) return this.mark(this.near(e.offsetX, e.offsetY, NEAR[e.pointerType] ?? 16));
    const [dx, dy] = [e.offsetX - last[0], e.offsetY - last[1]];
    const others = [...this.fingers].filter(([id]) => id !== e.pointerId);
    this.fingers.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (others.length) {
      const far = (p) => Math.hypot(p[0] - others[0][1][0], p[1] - others[0][1][1]);
      this.host.camera?.scale(far([e.offsetX, e.offsetY]) / Math.max(1, far(last)));
      this.host.camera?.orbit(dx / 2, dy / 2);
      return;
    }
    if (this.held?.id === e.pointerId) this.pull(e.offsetX, e.offsetY);
    else this.host.camera?.orbit(dx, dy);
  }

  pull(x, y) {
    const { scene, camera } = this.host;
    const { mass, start, from } = this.held;
    const p = 3 * mass;
    const { right, up } = camera.axes();
    const pixel = [x - start[0], y - start[1]];
    const world = [0, 1, 2].map((k) =>
      (2 * pixel[0] * right[k]) / (camera.clip[0] * this.canvas.clientWidth) -
      (2 * pixel[1] * up[k]) / (camera.clip[1] * this.canvas.clientHeight));
    if (scene.space[mass]) {
      this.held.by = from.map((v, k) => v + world[k]);
      this.held.to = [0, 1, 2].map((k) => scene.rest[p + k] + this.held.by[k]);
    } else {
      const axis = [...scene.axis.subarray(p, p + 3)];
      const across = axis.reduce((s, v, k) => s + v * world[k], 0);
      // an axis that is seen from its end would make a step of every pixel
      const seen = Math.hypot(axis.reduce((s, v, k) => s + v * right[k], 0), axis.reduce((s, v, k) => s + v * up[k], 0));
      const along = across / Math.max(0.3, seen * seen);
      this.held.by = [from[0] + along / this.host.gain()];
      this.held.to = [0, 1, 2].map((k) => scene.rest[p + k] + axis[k] * this.held.by[0] * this.host.gain());
    }
    const now = performance.now();
    if (now - this.sent > 8) this.send(now);
    else this.late ??= setTimeout(() => this.held && this.send(performance.now()), 9);
  }

  send(now) {
    this.sent = now;
    this.late = undefined;
    this.socket.say({ type: "drag", by: this.held.by });
  }

  up(e) {
    this.fingers.delete(e.pointerId);
    if (this.held?.id === e.pointerId) this.release();
  }

  release() {
    if (!this.held) return;
    clearTimeout(this.late);
    this.late = undefined;
    this.held = null;
    this.canvas.classList.remove("held");
    this.socket.say({ type: "release" });
  }
}
