// Scope, spectrum and level of the samples from the server. The scope is triggered at a rising zero crossing, so that a
// periodic sound stands still. The spectrum uses 4096 samples, starts at 20 Hz with an octave scale, and has a slow
// peak line. The level holds each peak for a second. Drawing is limited to 30 times per second.

const SIZE = 4096, ROOM = 16384, FLOOR = -100;

// canvas context and size; null if the canvas is not visible
export function board(canvas) {
  const w = canvas.clientWidth, h = canvas.clientHeight, ratio = Math.min(2, devicePixelRatio || 1);
  if (!w || !h) return null;
  if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
    canvas.width = Math.round(w * ratio);
    canvas.height = Math.round(h * ratio);
  }
  const c = canvas.getContext("2d");
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, w, h);
  c.font = "11px system-ui, sans-serif";
  return { c, w, h };
}

export class Meters {
  constructor(scope, spectrum, level, readout, scale) {
    this.scale = scale;
    this.scope = scope; this.spectrum = spectrum; this.level = level; this.readout = readout;
    this.channels = 0;
    this.rate = 48000;
    this.last = 0;
    this.fresh = false;
    this.window = Float32Array.from({ length: SIZE }, (_, i) => 0.5 - 0.5 * Math.cos(2 * Math.PI * i / SIZE));
    this.re = new Float32Array(SIZE); this.im = new Float32Array(SIZE);
    this.cos = Float32Array.from({ length: SIZE / 2 }, (_, i) => Math.cos(2 * Math.PI * i / SIZE));
    this.sin = Float32Array.from({ length: SIZE / 2 }, (_, i) => -Math.sin(2 * Math.PI * i / SIZE));
    this.size = 1e-3;
    this.setTheme();
  }

  setScene(rate, names) {
    this.rate = rate;
    this.names = names;
    this.channels = Math.max(1, names.length);
    this.rings = Array.from({ length: this.channels }, () => new Float32Array(ROOM));
    this.write = 0;
    this.peaks = new Float32Array(this.channels);
    this.holds = new Float32Array(this.channels);
    this.held = new Float64Array(this.channels);
    this.slow = null;
    this.over = 0;
  }

  setTheme() {
    const css = getComputedStyle(document.documentElement), get = n => css.getPropertyValue(n).trim();
    this.colours = [get("--trace-0"), get("--trace-1"), get("--trace-2"), get("--trace-3")];
    this.soft = get("--soft"); this.rule = get("--rule"); this.warn = get("--bad"); this.good = get("--trace-0"); this.quiet = get("--meter");
    this.fresh = true;
  }

  push(channels, floats) {
    if (!this.rings || channels !== this.channels) return;
    const frames = floats.length / channels | 0;
    for (let c = 0; c < channels; c++) {
      const ring = this.rings[c];
      let peak = this.peaks[c], w = this.write;
      for (let f = 0, i = c; f < frames; f++, i += channels) {
        const v = floats[i];
        ring[w] = v;
        w = (w + 1) & (ROOM - 1);
        const a = v < 0 ? -v : v;
        if (a > peak) peak = a;
      }
      this.peaks[c] = peak;
    }
    this.write = (this.write + frames) & (ROOM - 1);
    this.fresh = true;
  }

  draw(now) {
    if (!this.rings || now - this.last < 33 || !this.fresh) return;
    const dt = Math.min(0.2, (now - this.last) / 1000);
    this.last = now;
    this.fresh = false;
    this.drawScope();
    this.drawSpectrum(dt);
    this.drawLevel(now, dt);
  }

  drawScope() {
    const b = board(this.scope);
    if (!b) return;
    const { c, w, h } = b, n = Math.round(Math.min(0.03 * this.rate, ROOM / 3)), mask = ROOM - 1, first = this.rings[0];
    let start = this.write - n, largest = 0;
    for (let k = 0; k < n; k++) {
      const at = (this.write - n - k) & mask;
      if (first[(at - 1) & mask] <= 0 && first[at] > 0) { start = at; break; }
    }
    for (const ring of this.rings) for (let i = 0; i < n; i++) largest = Math.max(largest, Math.abs(ring[(start + i) & mask]));
    // steps of two, so that the scale stays still
    const want = 2 ** Math.ceil(Math.log2(Math.max(largest * 1.02, 1 / 1024)));
    this.size = want > this.size ? want : largest < 0.3 * this.size ? Math.max(want, this.size / 2) : this.size;
    c.strokeStyle = this.rule;
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(0, Math.round(h / 2) + 0.5); c.lineTo(w, Math.round(h / 2) + 0.5);
    for (let k = 1; k < 3; k++) { const x = Math.round(w * k / 3) + 0.5; c.moveTo(x, 0); c.lineTo(x, h); }
    c.stroke();
    this.rings.slice(0, 4).forEach((ring, k) => {
      c.strokeStyle = this.colours[k];
      c.lineWidth = 1.4;
      c.lineJoin = "round";
      c.beginPath();
      for (let i = 0; i < n; i++) {
        const y = h / 2 - ring[(start + i) & mask] / this.size * (h / 2 - 4);
        if (i) c.lineTo(i / (n - 1) * w, y);
        else c.moveTo(0, y);
      }
      c.stroke();
    });
    const text = `± ${+this.size.toPrecision(2)}, 10 ms per line`;
    if (this.scale.textContent !== text) this.scale.textContent = text;
  }

  transform() {
    const { re, im, cos, sin } = this, mask = ROOM - 1, g = 1 / this.channels;
    for (let i = 0; i < SIZE; i++) {
      let v = 0;
      const at = (this.write - SIZE + i) & mask;
      for (const ring of this.rings) v += ring[at];
      re[i] = v * g * this.window[i];
    }
    im.fill(0);
    for (let i = 1, j = 0; i < SIZE; i++) {
      let bit = SIZE >> 1;
      for (; j & bit; bit >>= 1) j ^= bit;
      j ^= bit;
      if (i < j) { const t = re[i]; re[i] = re[j]; re[j] = t; }
    }
    for (let len = 2; len <= SIZE; len <<= 1) {
      const half = len >> 1, stride = SIZE / len;
      for (let i = 0; i < SIZE; i += len)
        for (let k = 0, t = 0; k < half; k++, t += stride) {
          const p = i + k, q = p + half, x = re[q] * cos[t] - im[q] * sin[t], y = re[q] * sin[t] + im[q] * cos[t];
          re[q] = re[p] - x; im[q] = im[p] - y;
          re[p] += x; im[p] += y;
        }
    }
  }

  drawSpectrum(dt) {
    const b = board(this.spectrum);
    if (!b) return;
    const { c, w } = b, h = b.h - 15, low = 20, top = Math.min(20000, this.rate / 2), span = Math.log(top / low);
    this.transform();
    const x = f => Math.log(f / low) / span * w, y = d => h - (d - FLOOR) / -FLOOR * h;
    c.strokeStyle = this.rule; c.fillStyle = this.soft; c.lineWidth = 1;
    c.textAlign = "center"; c.textBaseline = "bottom";
    c.beginPath();
    for (const f of [100, 1000, 10000]) { const at = Math.round(x(f)) + 0.5; c.moveTo(at, 0); c.lineTo(at, h); }
    for (const d of [-30, -60]) { const at = Math.round(y(d)) + 0.5; c.moveTo(0, at); c.lineTo(w, at); }
    c.moveTo(0, h + 0.5); c.lineTo(w, h + 0.5);
    c.stroke();
    for (const [f, text] of [[100, "100 Hz"], [1000, "1 kHz"], [10000, "10 kHz"]]) if (x(f) < w - 22) c.fillText(text, x(f), b.h + 1);
    const columns = Math.max(2, w | 0), bin = this.rate / SIZE;
    if (!this.slow || this.slow.length !== columns) { this.slow = new Float32Array(columns).fill(FLOOR); this.now = new Float32Array(columns).fill(FLOOR); }
    const amount = k => Math.hypot(this.re[k], this.im[k]) * 4 / SIZE;
    for (let i = 0; i < columns; i++) {
      const from = low * Math.exp(i / columns * span) / bin, to = low * Math.exp((i + 1) / columns * span) / bin;
      let m = 0;
      if (to - from < 1) { const k = Math.floor(from), f = from - k; m = amount(k) * (1 - f) + amount(k + 1) * f; }
      else for (let k = Math.ceil(from); k <= to && k < SIZE / 2; k++) m = Math.max(m, amount(k));
      const d = Math.max(FLOOR, 20 * Math.log10(m + 1e-9));
      this.now[i] = d > this.now[i] ? d : Math.max(d, this.now[i] - 90 * dt);
      this.slow[i] = d > this.slow[i] ? d : Math.max(d, this.slow[i] - 12 * dt);
    }
    const path = line => { c.beginPath(); for (let i = 0; i < columns; i++) { if (i) c.lineTo(i + 0.5, y(line[i])); else c.moveTo(0, y(line[0])); } };
    path(this.now);
    c.lineTo(w, h); c.lineTo(0, h); c.closePath();
    c.globalAlpha = 0.28; c.fillStyle = this.colours[0]; c.fill(); c.globalAlpha = 1;
    path(this.now);
    c.strokeStyle = this.colours[0]; c.lineWidth = 1.3; c.stroke();
    path(this.slow);
    c.globalAlpha = 0.45; c.lineWidth = 1; c.stroke(); c.globalAlpha = 1;
  }

  drawLevel(now, dt) {
    const b = board(this.level);
    const decibels = v => 20 * Math.log10(Math.max(v, 1e-6));
    let loudest = -120;
    for (let k = 0; k < this.channels; k++) {
      const peak = decibels(this.peaks[k]);
      this.peaks[k] = 0;
      this.shown = this.shown && this.shown.length === this.channels ? this.shown : new Float32Array(this.channels).fill(-120);
      this.shown[k] = peak > this.shown[k] ? peak : Math.max(peak, this.shown[k] - 26 * dt);
      if (peak >= this.holds[k] || now - this.held[k] > 1000) { this.holds[k] = this.shown[k]; this.held[k] = now; }
      loudest = Math.max(loudest, this.holds[k]);
    }
    this.readout.textContent = loudest <= -96 ? "silent" : `${loudest.toFixed(1).replace("-", "−")} dBFS`;
    this.readout.classList.toggle("bad", loudest > -0.1);
    if (!b) return;
    const { c, w, h } = b, count = Math.min(this.channels, 8), each = Math.min(12, (h - (count - 1) * 2) / count), top = (h - count * (each + 2) + 2) / 2;
    const x = d => Math.max(0, Math.min(1, (d + 60) / 60)) * w;
    for (let k = 0; k < count; k++) {
      const y = top + k * (each + 2);
      c.fillStyle = this.quiet; c.fillRect(0, y, w, each);
      c.fillStyle = this.good; c.fillRect(0, y, x(this.shown[k]), each);
      if (this.shown[k] > -3) { c.fillStyle = this.warn; c.fillRect(x(-3), y, x(this.shown[k]) - x(-3), each); }
      c.fillStyle = this.soft; c.fillRect(Math.max(0, x(this.holds[k]) - 2), y, 2, each);
    }
  }
}
