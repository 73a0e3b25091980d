// Sound output in the audio thread: a ring of frames at the scene rate, resampled to the context rate by a windowed
// sinc of 32 taps. The buffered time adapts: 40 ms at the beginning, 12 ms more after each gap, and slowly less while
// nothing is missing. The reading speed follows it by at most 0.3 %, so that two different clocks neither empty nor
// fill the ring. Jumps and gaps are faded to avoid clicks.

const TAPS = 32, PHASES = 256, HALF = TAPS / 2;

function bessel(x) {
  let sum = 1, term = 1;
  for (let k = 1; k < 40; k++) { term *= (x / (2 * k)) ** 2; sum += term; }
  return sum;
}

function table(cutoff) {
  const out = new Float32Array((PHASES + 1) * TAPS), beta = 7.5, norm = bessel(beta);
  for (let p = 0; p <= PHASES; p++) {
    let sum = 0;
    for (let t = 0; t < TAPS; t++) {
      const x = t - HALF + 1 - p / PHASES, w = Math.abs(x) / HALF;
      const s = x === 0 ? cutoff : Math.sin(Math.PI * cutoff * x) / (Math.PI * x);
      out[p * TAPS + t] = w >= 1 ? 0 : s * bessel(beta * Math.sqrt(1 - w * w)) / norm;
      sum += out[p * TAPS + t];
    }
    for (let t = 0; t < TAPS; t++) out[p * TAPS + t] /= sum;
  }
  return out;
}

export class Player extends AudioWorkletProcessor {
  constructor() {
    super();
    this.channels = 0;
    this.gaps = 0;
    this.port.onmessage = ({ data }) => {
      if (data instanceof Float32Array) this.take(data);
      else if (data.type === "config") this.configure(data);
      else if (data.type === "level") this.level = data.level;
    };
    this.level = 1;
    this.loud = 0;
  }

  configure({ rate, channels }) {
    this.rate = rate;
    this.channels = channels;
    this.room = 1 << Math.ceil(Math.log2(rate));
    this.ring = new Float32Array(this.room * channels);
    this.write = 0;
    this.read = 0;
    this.ratio = rate / sampleRate;
    this.taps = table(Math.min(1, 1 / this.ratio) * 0.97);
    this.ahead = Math.max(0.04 * rate, HALF + 3 * 128 * this.ratio);
    this.smooth = this.ahead;
    this.waiting = true;
    this.gain = 0;
    this.last = [0, 0];
    this.since = 0;
    this.least = Infinity;
    // distributes the channels over two loudspeakers, from left to right
    this.pan = Array.from({ length: channels }, (_, c) => {
      const x = channels === 1 ? 0.5 : c / (channels - 1), g = channels > 2 ? Math.sqrt(2 / channels) : 1;
      return channels === 1 ? [1, 1] : [Math.cos(x * Math.PI / 2) * g, Math.sin(x * Math.PI / 2) * g];
    });
  }

  take(samples) {
    if (!this.channels) return;
    const frames = Math.floor(samples.length / this.channels), mask = this.room - 1;
    for (let f = 0; f < frames; f++)
      for (let c = 0; c < this.channels; c++) this.ring[((this.write + f) & mask) * this.channels + c] = samples[f * this.channels + c];
    this.write += frames;
    if (this.write - this.read > this.room - HALF) this.read = this.write - this.ahead;
  }

  process(_, [output]) {
    const left = output[0], right = output[1] || left, length = left.length;
    if (!this.channels) return true;
    const fill = this.write - this.read - HALF;
    if (this.waiting && fill >= this.ahead) {
      this.waiting = false;
      this.read += fill - this.ahead;
      this.smooth = this.ahead;
    } else if (!this.waiting) this.smooth += (fill - this.smooth) * 0.01;
    const off = (this.smooth - this.ahead) / this.rate;
    const step = this.ratio * (1 + Math.min(0.003, Math.max(-0.003, off * 0.06)));
    let play = this.waiting ? 0 : length, fade = 1 / (0.004 * sampleRate);
    const late = !this.waiting && fill < length * step + 1, jump = !late && !this.waiting && fill > this.ahead + 0.15 * this.rate;
    if (late) {
      // plays the remaining samples with a fade
      this.waiting = true;
      this.gaps++;
      this.ahead = Math.min(this.ahead + 0.012 * this.rate, 0.3 * this.rate);
      play = Math.max(0, Math.floor((fill - 1) / step));
      fade = -1 / Math.max(1, play);
    } else if (jump) fade = -1 / length;
    if (!this.waiting) this.least = Math.min(this.least, fill);
    this.mix(left, right, play, step, fade);
    for (let i = play; i < length; i++) {
      left[i] = this.last[0] *= 0.985;
      if (right !== left) right[i] = this.last[1] *= 0.985;
    }
    if (play < length) this.gain = 0;
    if (jump) this.read = this.write - this.ahead - HALF;
    if (jump) this.smooth = this.ahead;
    this.tell(length);
    return true;
  }

  // mixes `play` samples with a rising or falling gain
  mix(left, right, play, step, fade) {
    const mask = this.room - 1, n = this.channels, { ring, taps, pan } = this;
    for (let i = 0; i < play; i++) {
      const whole = Math.floor(this.read), place = (this.read - whole) * PHASES, phase = place | 0, part = place - phase;
      const t0 = phase * TAPS, t1 = t0 + TAPS;
      let l = 0, r = 0;
      for (let c = 0; c < n; c++) {
        let sum = 0;
        for (let t = 0; t < TAPS; t++) sum += (taps[t0 + t] + (taps[t1 + t] - taps[t0 + t]) * part) * ring[((whole + t - HALF + 1) & mask) * n + c];
        l += sum * pan[c][0];
        r += sum * pan[c][1];
      }
      this.gain = Math.min(1, Math.max(0, this.gain + fade));
      this.loud += (this.level - this.loud) * 0.002;
      left[i] = l * this.gain * this.loud;
      if (right !== left) right[i] = r * this.gain * this.loud;
      this.read += step;
    }
    if (play > 0) this.last = [left[play - 1], right[play - 1]];
  }

  tell(length) {
    this.since += length;
    if (this.since < sampleRate) return;
    this.since = 0;
    // buffered time that was unused for a second is reduced in small steps
    if (this.least > 0.6 * this.ahead && this.least < Infinity) this.ahead = Math.max(this.ahead - 0.0005 * this.rate, 0.03 * this.rate);
    this.least = Infinity;
    this.port.postMessage({ ahead: this.ahead / this.rate, gaps: this.gaps, playing: !this.waiting });
  }
}

registerProcessor("player", Player);
