// Scope and spectrum of what is heard.
//
// Decides on 4096 samples, a Hann window and a plain radix-2 transform: 80 ms at 48 kHz, ten times a second.

const N = 4096;
const hann = Float32Array.from({ length: N }, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / N));
const re = new Float64Array(N), im = new Float64Array(N);

export class Meters {
  constructor(scope, spectrum, sound) {
    Object.assign(this, { scope, spectrum, sound });
    this.smooth = new Float32Array(N / 2).fill(-140);
  }

  draw() {
    const style = getComputedStyle(document.documentElement);
    const [accent, dim] = ["--accent", "--dim"].map((v) => style.getPropertyValue(v));
    const { recent, at, on, rate } = this.sound;
    const wave = fit(this.scope), lines = fit(this.spectrum);
    if (!wave) return;
    if (!on) {
      for (const [c, text] of [[wave, "waveform: press Sound"], [lines, "spectrum"]]) {
        c.fillStyle = dim;
        c.font = "12px system-ui, sans-serif";
        c.fillText(text, 10, 18);
      }
      return;
    }
    this.still ??= 0;
    // from a rising zero, so that it stands still
    let from = (at - 2048) & (N - 1);
    for (let i = 0; i < 1024; i++) {
      const a = recent[(from + i) & (N - 1)] - this.still, b = recent[(from + i + 1) & (N - 1)] - this.still;
      if (a < 0 && b >= 0) {
        from = (from + i) & (N - 1);
        break;
      }
    }
    const [w, h] = [wave.canvas.clientWidth, wave.canvas.clientHeight];
    // what stands still is not heard
    let still = 0;
    for (let i = 0; i < N; i++) still += recent[i] / N;
    this.still = still;
    let most = 1e-6;
    for (let i = 0; i < 960; i++) most = Math.max(most, Math.abs(recent[(from + i) & (N - 1)] - still));
    const full = Math.max(most, 1e-4);
    wave.strokeStyle = accent;
    wave.lineWidth = 1.4;
    wave.beginPath();
    for (let i = 0; i < 960; i++) wave.lineTo((i / 959) * w, h / 2 - ((recent[(from + i) & (N - 1)] - still) / full) * (h / 2 - 6));
    wave.stroke();
    wave.fillStyle = dim;
    wave.font = "11px system-ui, sans-serif";
    wave.fillText(`${decibel(most)} dB, 20 ms`, 8, 14);

    for (let i = 0; i < N; i++) [re[i], im[i]] = [(recent[(at + i) & (N - 1)] - still) * hann[i], 0];
    transform(re, im);
    let loud = 2;
    lines.strokeStyle = accent;
    lines.lineWidth = 1.2;
    lines.beginPath();
    for (let i = 1; i < N / 2; i++) {
      const db = 10 * Math.log10((re[i] * re[i] + im[i] * im[i]) * (16 / N / N) + 1e-14);
      this.smooth[i] = Math.max(db, this.smooth[i] - 3);
      if (i > 1 && this.smooth[i] > this.smooth[loud]) loud = i;
      const hz = (i * rate) / N;
      if (hz < 20 || hz > 20000) continue;
      const x = (Math.log(hz / 20) / Math.log(1000)) * w;
      lines.lineTo(x, Math.min(h, ((10 - this.smooth[i]) / 120) * h));
    }
    lines.stroke();
    lines.fillStyle = dim;
    lines.font = "11px system-ui, sans-serif";
    lines.fillText(`20 Hz – 20 kHz, most at ${((loud * rate) / N).toFixed(0)} Hz`, 8, 14);
  }
}

const decibel = (x) => (20 * Math.log10(Math.max(x, 1e-6))).toFixed(0);

function fit(canvas) {
  const scale = devicePixelRatio || 1;
  const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
  if (!w || !h) return null;
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const c = canvas.getContext("2d");
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, w, h);
  return c;
}

function transform(re, im) {
  for (let i = 1, j = 0; i < N; i++) {
    let bit = N >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) [re[i], re[j], im[i], im[j]] = [re[j], re[i], im[j], im[i]];
  }
  for (let size = 2; size <= N; size <<= 1) {
    const [cr, ci] = [Math.cos((-2 * Math.PI) / size), Math.sin((-2 * Math.PI) / size)];
    for (let i = 0; i < N; i += size) {
      let [wr, wi] = [1, 0];
      for (let k = i; k < i + size / 2; k++) {
        const l = k + size / 2;
        const [tr, ti] = [re[l] * wr - im[l] * wi, re[l] * wi + im[l] * wr];
        [re[l], im[l], re[k], im[k]] = [re[k] - tr, im[k] - ti, re[k] + tr, im[k] + ti];
        [wr, wi] = [wr * cr - wi * ci, wr * ci + wi * cr];
      }
    }
  }
}
