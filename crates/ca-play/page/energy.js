// Plots the kinetic energy of each part of the instrument over the last 20 seconds, from the largest value six decades
// down. The values come with the pictures, about twenty times per second. They do not come from the energy ledger,
// which runs only on request.

import { board } from "./meters.js";

const SPAN = 20, DECADES = 6;
// space above the curves for their names [px]
const HEAD = 14;
// below this energy, the instrument is at rest [J]
const STILL = 1e-24;

export class Energy {
  constructor(canvas, readout) {
    this.canvas = canvas;
    this.readout = readout;
    this.scene([]);
    this.setTheme();
  }

  scene(names) {
    this.names = names;
    this.points = [];
    this.top = null;
    this.fresh = true;
  }

  setTheme() {
    const css = getComputedStyle(document.documentElement), get = n => css.getPropertyValue(n).trim();
    this.colours = [0, 1, 2, 3, 4, 5].map(k => get("--trace-" + k));
    this.soft = get("--soft"); this.rule = get("--rule");
    this.fresh = true;
  }

  /** @param {import("./protocol.js").EnergyMessage} message */
  push({ seconds, motion }) {
    const last = this.points[this.points.length - 1];
    if (motion.length !== this.names.length) return;
    if (last && seconds < last.seconds) this.points = [];
    this.points.push({ seconds, motion });
    while (this.points[0].seconds < seconds - SPAN) this.points.shift();
    this.fresh = true;
  }

  draw(now) {
    if (!this.fresh || now - (this.last || 0) < 100) return;
    const b = board(this.canvas);
    if (!b) return;
    this.last = now;
    this.fresh = false;
    const { c, w, h } = b, end = this.points.length ? this.points[this.points.length - 1].seconds : SPAN;
    let largest = 0;
    for (const p of this.points) for (const e of p.motion) if (e > largest) largest = e;
    document.documentElement.dataset.energy = String(largest);
    // whole decades, so that the scale stays still
    const moves = largest > STILL, top = moves ? Math.ceil(Math.log10(largest)) : -3;
    this.readout.textContent = moves ? `top 1e${top} J`.replace("-", "−") : "at rest";
    const x = s => w - (end - s) / SPAN * w, y = e => Math.min(1, (top - Math.log10(Math.max(e, 1e-300))) / DECADES) * (h - HEAD - 2) + HEAD;
    c.strokeStyle = this.rule; c.lineWidth = 1;
    c.beginPath();
    for (let k = 0; k < DECADES; k++) { const at = Math.round(HEAD + k / DECADES * (h - HEAD)) + 0.5; c.moveTo(0, at); c.lineTo(w, at); }
    c.stroke();
    this.names.forEach((name, k) => {
      c.strokeStyle = this.colours[k]; c.lineWidth = 1.4; c.lineJoin = "round";
      c.beginPath();
      this.points.forEach((p, i) => { if (i) c.lineTo(x(p.seconds), y(p.motion[k])); else c.moveTo(x(p.seconds), y(p.motion[k])); });
      c.stroke();
    });
    c.textBaseline = "top";
    let left = 2;
    this.names.forEach((name, k) => {
      const wide = c.measureText(name).width;
      if (left + wide > w) return;
      c.fillStyle = this.colours[k];
      c.fillText(name, left, 1);
      left += wide + 10;
    });
  }
}
