// Axis of a plot: positions of values, ticks, and texts of numbers.
"use strict";

// formats a number with up to six digits
const plain = v => {
  if (v == null) return "–";
  const a = Math.abs(v);
  if (a !== 0 && (a < 1e-4 || a >= 1e7)) return v.toExponential(Number.isInteger(Math.log10(a)) ? 0 : 2);
  return String(+v.toPrecision(6));
};
const prefixed = v => v >= 1e6 && v < 1e9 ? plain(v / 1e6) + "M" : v >= 1e3 && v < 1e6 ? plain(v / 1e3) + "k" : plain(v);
const exponent = v => {
  const e = Math.floor(Math.log10(v) + 1e-9), m = +(v / 10 ** e).toPrecision(3);
  return (m === 1 ? "" : m + "·") + "10" + String(e).replace(/[0-9-]/g, d => d === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]);
};

class Axis {
  // about: label, unit, log and range, from the report
  constructor(about) {
    this.about = about;
    this.log = about.log;
    this.name = about.label + (about.unit ? " [" + about.unit + "]" : "");
  }

  // sets the values at both ends
  show(low, high) {
    [this.low, this.high] = [low, high];
  }

  // sets the pixels at both ends; on the vertical axis they decrease
  place(from, to) {
    [this.from, this.to] = [from, to];
  }

  #scaled(v) {
    return this.log ? Math.log10(v) : v;
  }

  // returns the pixel of a value
  at(v) {
    const low = this.#scaled(this.low), high = this.#scaled(this.high);
    return this.from + (this.#scaled(v) - low) / (high - low) * (this.to - this.from);
  }

  // returns the value of a pixel
  of(pixel) {
    const low = this.#scaled(this.low), high = this.#scaled(this.high);
    const v = low + (pixel - this.from) / (this.to - this.from) * (high - low);
    return this.log ? 10 ** v : v;
  }

  // returns values and texts of the ticks, on a linear axis at most `most`
  ticks(most) {
    return this.log ? this.#decades() : this.#steps(Math.max(2, most));
  }

  // 1, 2 and 5 of each decade for up to four decades, otherwise decades
  #decades() {
    const from = Math.floor(Math.log10(this.low)), to = Math.ceil(Math.log10(this.high)), ticks = [];
    const skip = Math.max(1, Math.ceil((to - from) / 8));
    for (let e = from; e <= to; e += skip)
      for (const m of to - from <= 4 ? [1, 2, 5] : [1]) ticks.push(+(m * 10 ** e).toPrecision(3));
    const text = this.about.unit === "Hz" ? prefixed : v => v >= 1e-3 && v < 1e5 ? plain(v) : exponent(v);
    return ticks.filter(t => t >= this.low && t <= this.high).map(t => [t, text(t)]);
  }

  // multiples of 1, 2 or 5 times a power of ten
  #steps(most) {
    const least = (this.high - this.low) / most, power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map(m => m * power).find(s => s >= least * (1 - 1e-9));
    const digits = Math.min(20, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    const ticks = [];
    for (let n = Math.ceil(this.low / step - 1e-9); n * step <= this.high + 1e-9 * step; n++) ticks.push(n * step);
    const large = Math.max(Math.abs(this.low), Math.abs(this.high));
    const text = v => v !== 0 && (large < 1e-3 || large >= 1e7) ? (+v.toPrecision(6)).toExponential() : String(+v.toFixed(digits));
    return ticks.map(t => [t, text(t)]);
  }

  // returns the full range along x
  wholeAlong(first, last) {
    if (this.about.range) return this.about.range;
    if (first < last) return [first, last];
    return this.log ? [first / 2, first * 2] : [first - 0.5, first + 0.5];
  }

  // returns the range for values from `low` to `high`: with a margin, or whole decades
  aroundUp(low, high) {
    if (this.about.range) return this.about.range;
    if (this.log) {
      if (low > high) return [1, 10];
      return low === high ? [low / 2, high * 2] : [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high))];
    }
    if (low > high) return [0, 1];
    const margin = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
    return [low - margin, high + margin];
  }
}
