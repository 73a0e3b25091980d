// Sound: from the engine to the ears of who has asked for it.
//
// Decides that the page is silent until somebody presses something, as browsers demand, and that what is heard is also
// what the meters show.

export class Sound {
  constructor(socket) {
    this.socket = socket;
    this.on = false;
    this.delay = 0;
    this.recent = new Float32Array(4096);
    this.at = 0;
    this.peak = 0;
  }

  scene(channels, rate) {
    this.channels = channels;
    this.rate = rate;
    if (this.on) this.again();
  }

  async toggle() {
    if (!this.channels) return false;
    this.on = !this.on;
    if (this.on) await this.again();
    else await this.context?.suspend();
    this.socket.say({ type: "sound", on: this.on });
    return this.on;
  }

  /** A new scene, or a line that was lost: the same again. */
  async again() {
    if (!this.context) {
      this.context = new AudioContext({ latencyHint: "interactive" });
      await this.context.audioWorklet.addModule("worklet.js");
    }
    await this.context.resume();
    this.node?.disconnect();
    this.node = new AudioWorkletNode(this.context, "ca-player", {
      numberOfInputs: 0,
      outputChannelCount: [2],
      processorOptions: { channels: this.channels, rate: this.rate },
    });
    this.node.port.onmessage = ({ data }) => ({ delay: this.delay, gaps: this.gaps } = data);
    this.node.connect(this.context.destination);
    this.socket.say({ type: "sound", on: true });
  }

  /** A block came. */
  heard(channels, samples) {
    if (!this.on || channels !== this.channels) return;
    for (let i = 0; i < samples.length; i += channels) {
      let x = 0;
      for (let c = 0; c < channels; c++) x += samples[i + c];
      this.recent[this.at] = x / channels;
      this.at = (this.at + 1) & 4095;
      this.peak = Math.max(this.peak * 0.9999, Math.abs(x / channels));
    }
    this.node?.port.postMessage(samples);
  }

  /** From the engine to the ear [s]. */
  latency() {
    return this.delay + (this.context?.outputLatency ?? 0) + (this.context?.baseLatency ?? 0);
  }
}
