// Sound in the page: requests samples from the server and passes them to the worklet. The audio context is created at
// the first user gesture, as browsers require. It uses the scene rate if possible, otherwise the rate of the browser
// with resampling. Samples are also requested without sound for the meters, but not while the page is hidden and
// silent.

export class Sound {
  // world: send(message), changed(state)
  /**
   * @param {{changed: (sound: Sound) => void} & Pick<import("./messages.js").Messages, "send">} world
   */
  constructor(world) {
    this.world = world;
    this.state = "off";       // off, starting, on, failed
    this.muted = false;
    this.volume = 0.8;
    this.rate = 0;
    this.channels = 0;
    this.ahead = 0;
    this.gaps = 0;
    this.context = null;
    this.node = null;
    this.asked = false;
    document.addEventListener("visibilitychange", () => this.ask());
  }

  scene(rate, channels) {
    const other = rate !== this.rate || channels !== this.channels;
    this.rate = rate;
    this.channels = channels;
    this.asked = false;
    this.ask();
    if (other && this.state === "on") this.configure();
  }

  ask() {
    const want = this.state === "on" || !document.hidden;
    if (want !== this.asked && this.world.send({ type: "sound", on: want })) this.asked = want;
  }

  async start() {
    if (this.state === "on" || this.state === "starting" || !this.rate) return;
    this.set("starting");
    try {
      if (!this.context) {
        try {
          this.context = new AudioContext({ sampleRate: this.rate, latencyHint: "interactive" });
        } catch {
          this.context = new AudioContext({ latencyHint: "interactive" });
        }
        if (!this.context.audioWorklet) throw new Error("the browser plays sound only at a local or HTTPS address");
        await this.context.audioWorklet.addModule("worklet.js");
        this.node = new AudioWorkletNode(this.context, "player", { numberOfInputs: 0, outputChannelCount: [2] });
        this.node.port.onmessage = ({ data }) => {
          this.ahead = data.ahead;
          this.gaps = data.gaps;
          this.world.changed(this);
        };
        this.node.connect(this.context.destination);
        this.context.onstatechange = () => {
          if (this.state === "on" && this.context.state === "suspended") this.set("off");
        };
      }
      await this.context.resume();
      this.configure();
      this.set("on");
      this.ask();
    } catch (error) {
      this.reason = String(error.message || error);
      this.set("failed");
    }
  }

  configure() {
    this.node.port.postMessage({ type: "config", rate: this.rate, channels: this.channels });
    this.loud();
  }

  stop() {
    if (this.state !== "on") return;
    this.set("off");
    this.context.suspend();
    this.ask();
  }

  toggle() {
    if (this.state === "on") this.stop();
    else this.start();
  }

  mute(muted = !this.muted) {
    this.muted = muted;
    this.loud();
    this.world.changed(this);
  }

  setVolume(volume) {
    this.volume = volume;
    this.muted = false;
    this.loud();
    this.world.changed(this);
  }

  loud() {
    if (this.node) this.node.port.postMessage({ type: "level", level: this.muted ? 0 : this.volume ** 2 });
  }

  push(channels, floats) {
    if (this.state !== "on" || !this.node) return;
    if (channels !== this.channels) {
      this.channels = channels;
      this.configure();
    }
    const copy = floats.slice();
    this.node.port.postMessage(copy, [copy.buffer]);
  }

  // latency from the server to the loudspeaker, as far as the page knows [s]
  get latency() {
    return this.ahead + (this.context ? (this.context.baseLatency || 0) + (this.context.outputLatency || 0) : 0);
  }

  set(state) {
    this.state = state;
    this.world.changed(this);
  }
}
