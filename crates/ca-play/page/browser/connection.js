// Connection to an engine in this browser: the compiler runs in a worker, the engine in an audio worklet. The page uses
// it as the connection to `ca play`.

import { Messages } from "../messages.js";
import { Compiler } from "./compiler.js";
import { framed } from "./wasm.js";

/**
 * A model as text.
 * @typedef {object} Model
 * @property {string} file name of its file
 * @property {string} text
 * @property {number} [limit] largest number of modules, for models from a link
 */

/**
 * The places of the parts of the engine.
 * @typedef {object} Parts
 * @property {() => Worker} worker starts the worker of the compiler
 * @property {() => Promise<ArrayBuffer>} compiler module of the compiler
 * @property {() => Promise<ArrayBuffer>} [accuracy] module that measures, where there is one
 * @property {() => Promise<ArrayBuffer>} engine module of the engine
 * @property {string} worklet address of the worklet
 */

const OPEN = 0x7b;
// share of real time above which the sound has gaps
const HEAVY = 0.97;

export class EngineConnection extends Messages {
  /**
   * @param {Promise<Model>} model
   * @param {Parts} parts
   * @param {import("../messages.js").Handlers} handlers
   */
  constructor(model, parts, handlers) {
    super(handlers, "the engine");
    this.first = model;
    /** @type {Model|null} */
    this.model = null;
    /** @type {[string, string][]} values that every version of the model has */
    this.changes = [];
    this.parts = parts;
    this.compiler = new Compiler(parts);
    this.decoder = new TextDecoder();
    this.encoder = new TextEncoder();
    this.load = null;
    this.gaps = 0;
    this.ahead = 0;
    this.level = 0;
    this.rate = 0;
    this.late = 0;
    this.channels = 0;
    /** @type {Float32Array[]|null} */
    this.recording = null;
    /** @type {AudioContext|null} */
    this.context = null;
    /** @type {AudioWorkletNode|null} */
    this.node = null;
  }

  connect() {
    this.on.status("connecting", { tries: 0 });
    this.begin().catch(error => this.fail(String(error.message || error)));
  }

  again() {
    if (this.open) this.lighten();
    else this.connect();
  }

  async begin() {
    this.model = this.model || await this.first;
    const made = await this.compiler.ask({ type: "compile", ...this.model, changes: this.changes });
    if (!made.ok) {
      // the text can be mended in the page
      this.on.status("open", {});
      this.on.report({ type: "report", ok: false, text: made.text });
      return;
    }
    const engine = await this.parts.engine();
    await this.sound(made.rate);
    this.node.port.postMessage({ type: "open", engine, request: framed(made.facts, made.bytes) });
    this.open = true;
    this.on.status("open", {});
  }

  // the audio thread; it stands until a press of the user, as browsers require
  async sound(rate) {
    if (this.context) return;
    try {
      this.context = new AudioContext({ sampleRate: rate, latencyHint: "interactive" });
    } catch {
      this.context = new AudioContext({ latencyHint: "interactive" });
    }
    if (!this.context.audioWorklet) throw new Error("the browser plays sound only at a local or HTTPS address");
    await this.context.audioWorklet.addModule(this.parts.worklet);
    this.node = new AudioWorkletNode(this.context, "instrument", { numberOfInputs: 0, outputChannelCount: [2] });
    this.node.port.onmessage = ({ data }) => this.receive(data);
    this.node.onprocessorerror = () => this.fail("the engine stopped; reload the page");
    this.node.connect(this.context.destination);
    // a page around this one suspends an instrument that is out of sight
    addEventListener("message", event => {
      if (event.source !== window.parent || event.source === window) return;
      if (event.data?.ca === "suspend") this.context.suspend();
      else if (event.data?.ca === "resume" && this.level > 0) this.context.resume();
    });
    this.setLevel(this.level);
  }

  /** @param {string} text */
  fail(text) {
    this.open = false;
    this.refuseAll();
    this.on.status("failed", { text });
  }

  receive(data) {
    if (data.type === "load") {
      ({ load: this.load, gaps: this.gaps, ahead: this.ahead } = data);
      return this.watch();
    }
    if (data.type === "failed") return this.fail(data.text);
    for (const bytes of data) {
      const view = new Uint8Array(bytes);
      if (view[0] === OPEN) this.text(this.decoder.decode(view));
      else this.binary(bytes);
    }
  }

  /** @param {any} message */
  message(message) {
    if (message.type === "compile") return void this.compile(message.changes);
    if (message.type === "scene") [this.rate, this.channels] = [message.rate, message.channels.length];
    if (message.type === "state") {
      message.load = this.load;
      message.recording = this.recording ? "sound" : null;
    }
    super.message(message);
  }

  /** @param {ArrayBuffer} bytes */
  binary(bytes) {
    if (this.recording && new DataView(bytes).getUint32(0, true) === 2) this.recording.push(new Float32Array(bytes.slice(16)));
    super.binary(bytes);
  }

  // a model that is too heavy for this computer can be played at half the rate
  watch() {
    this.late = this.load > HEAVY ? this.late + 1 : 0;
    if (this.late !== 4) return;
    const text = `This computer needs ${Math.round(100 * this.load)} % of real time for this instrument, so its sound has gaps.`;
    this.on.status("heavy", { text });
  }

  // plays the model from its beginning at half the rate, as the rate of an engine is fixed
  lighten() {
    this.changes = [["rate.sound", `${this.rate / 2} Hz`]];
    this.connect();
  }

  // compiles another version for the engine, with the numbers changed in the page
  async compile(changes) {
    const made = await this.compiler.ask({ type: "compile", ...this.model, changes: [...this.changes, ...changes] });
    if (made.ok) this.node.port.postMessage({ type: "compiled", request: framed(made.facts, made.bytes) });
    else this.node.port.postMessage({ type: "refused", request: this.encoder.encode(made.text) });
  }

  // plays another text
  /** @param {string} text */
  edit(text) {
    this.model = { ...this.model, text };
    if (this.open) this.node.port.postMessage({ type: "changed" });
    else this.connect();
  }

  /** @param {import("../protocol.js").Request & {id?: number}} message */
  send(message) {
    if (!this.open) return false;
    if (message.type === "record") {
      const answer = this.record(message.on);
      if (message.id !== undefined) queueMicrotask(() => this.answer({ id: message.id, ...answer }));
      return true;
    }
    this.node.port.postMessage({ type: "request", request: this.encoder.encode(JSON.stringify(message)) });
    return true;
  }

  // keeps the sound from now on, or gives it as a file
  record(on) {
    if (on === !!this.recording) return { ok: false, text: on ? "the sound is already being recorded" : "the sound is not being recorded" };
    if (on) {
      this.recording = [];
      return { ok: true, text: "recording" };
    }
    const blocks = this.recording, { channels } = this;
    this.recording = null;
    const length = blocks.reduce((n, b) => n + b.length, 0), all = new Float32Array(length);
    let at = 0;
    for (const block of blocks) { all.set(block, at); at += block.length; }
    this.compiler.ask({ type: "wav", rate: this.rate, channels, file: `${this.model.file.split(".")[0]}.wav` }, new Uint8Array(all.buffer))
      .then(made => { if (made.ok) save(made.file, made.bytes, "audio/wav"); else this.on.said({ type: "said", bad: true, text: made.text }); });
    return { ok: true, text: "saving the sound" };
  }

  async resume() {
    if (!this.context) throw new Error("the instrument is not ready");
    await this.context.resume();
  }

  // a factor of the amplitude; the instrument plays on at 0
  setLevel(level) {
    this.level = level;
    if (this.node) this.node.port.postMessage({ type: "level", level });
  }

  // from the engine to the loudspeaker, as far as the page knows [s]
  get latency() {
    const c = this.context;
    return this.ahead + (c ? (c.baseLatency || 0) + (c.outputLatency || 0) : 0);
  }
}

// lets the browser save a file
export function save(name, bytes, type) {
  const link = document.createElement("a"), address = URL.createObjectURL(new Blob([bytes], { type }));
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}
