// Plays what the engine sends.
//
// Decides on a ring of half a second and a delay that grows where blocks come late and shrinks slowly where they do not;
// the clock of the sound card and that of the engine differ, so the rate follows the fill by at most half a per cent.

class Player extends AudioWorkletProcessor {
  constructor({ processorOptions: { channels, rate } }) {
    super();
    this.channels = channels;
    this.size = 1 << 15;
    this.ring = Array.from({ length: channels }, () => new Float32Array(this.size));
    this.written = 0;
    this.read = 0;
    this.ratio = rate / sampleRate;
    this.wanted = 0.03 * rate;
    this.least = 0.012 * rate;
    this.most = 0.25 * rate;
    this.playing = false;
    this.gaps = 0;
    this.level = 0;
    this.port.onmessage = ({ data }) => this.take(data);
  }

  take(samples) {
    const frames = samples.length / this.channels;
    for (let i = 0; i < frames; i++) {
      const at = (this.written + i) & (this.size - 1);
      for (let c = 0; c < this.channels; c++) this.ring[c][at] = samples[i * this.channels + c];
    }
    this.written += frames;
    // a page that slept wakes up in the present
    if (this.written - this.read > this.most) this.read = this.written - this.wanted;
  }

  process(_, [out]) {
    const there = this.written - this.read;
    if (!this.playing && there >= this.wanted) this.playing = true;
    const n = out[0].length;
    if (this.playing && there < n * this.ratio + 2) {
      this.playing = false;
      this.gaps++;
      this.wanted = Math.min(this.most / 2, this.wanted * 1.3);
    }
    const to = this.playing ? 1 : 0;
    const pull = Math.max(-0.005, Math.min(0.005, (there - this.wanted) / this.wanted * 0.02));
    const step = this.ratio * (1 + pull);
    for (let i = 0; i < n; i++) {
      this.level += (to - this.level) * 0.01;
      const whole = Math.floor(this.read), part = this.read - whole;
      const [a, b] = [whole & (this.size - 1), (whole + 1) & (this.size - 1)];
      for (let c = 0; c < out.length; c++) {
        const ring = this.ring[Math.min(c, this.channels - 1)];
        out[c][i] = this.level * (ring[a] + part * (ring[b] - ring[a]));
      }
      if (this.playing) this.read += step;
    }
    if (this.playing) this.wanted = Math.max(this.least, this.wanted * 0.99998);
    if ((this.turn = ((this.turn ?? 0) + 1) % 64) === 0) this.port.postMessage({ delay: there / this.ratio / sampleRate, gaps: this.gaps });
    return true;
  }
}
registerProcessor("ca-player", Player);
