// The engine in the audio thread. It computes the frames that the loudspeaker needs next, so that a touch is heard in the
// following block.

import { Player } from "../worklet.js";
import { give } from "./wasm.js";

// longest time for the frames of a block [ms]; a model that is too heavy leaves gaps then
const LONGEST = 100;
// after a block that took longer than this [ms], the thread rests for half of its time, so that the page still moves
const LATE = 8;

class Instrument extends Player {
  constructor() {
    super();
    /** @type {any} */
    this.wasm = null;
    this.gaps = 0;
    this.write = this.read = this.rate = 0;
    this.work = this.blocks = this.rest = 0;
    this.port.onmessage = ({ data }) => this.message(data);
  }

  message(data) {
    if (data.type === "level") {
      this.level = data.level;
      return;
    }
    try {
      if (data.type === "open") this.begin(data);
      else if (this.wasm) {
        if (data.request) give(this.wasm, data.request);
        if (data.type === "request") this.wasm.ca_request();
        else if (data.type === "compiled") this.wasm.ca_compiled();
        else if (data.type === "refused") this.wasm.ca_refused();
        else if (data.type === "changed") this.wasm.ca_changed();
      }
      this.pass();
    } catch (error) {
      this.stop(error);
    }
  }

  begin({ engine, request }) {
    const wasm = new WebAssembly.Instance(new WebAssembly.Module(engine)).exports;
    this.wasm = wasm;
    give(wasm, request);
    const length = wasm.ca_open();
    if (length > 0) {
      const text = String.fromCharCode(...new Uint8Array(wasm.memory.buffer, wasm.ca_at(), length));
      this.wasm = null;
      this.port.postMessage({ type: "failed", text });
    }
  }

  stop(error) {
    this.wasm = null;
    this.port.postMessage({ type: "failed", text: `the engine stopped (${error.message || error}); reload the page` });
  }

  // passes the messages of the engine to the page
  pass() {
    if (!this.wasm) return;
    const all = [];
    for (let length = this.wasm.ca_next(); length > 0; length = this.wasm.ca_next())
      all.push(new Uint8Array(this.wasm.memory.buffer, this.wasm.ca_at(), length).slice().buffer);
    if (all.length) this.port.postMessage(all, all);
  }

  // plays until the ring has this many frames
  fill(frames) {
    const { wasm } = this, until = Date.now() + LONGEST;
    while (this.write - this.read < frames) {
      if (wasm.ca_rate() !== this.rate || wasm.ca_channels() !== this.channels) {
        this.configure({ rate: wasm.ca_rate(), channels: wasm.ca_channels() });
        this.write = this.read = 0;
      }
      const missing = frames - (this.write - this.read);
      const length = wasm.ca_play(Math.max(1, Math.ceil(missing / wasm.ca_frame())));
      if (!this.channels) return;
      this.take(new Float32Array(wasm.memory.buffer, wasm.ca_sound_at(), length));
      if (Date.now() > until) {
        this.gaps++;
        return;
      }
    }
  }

  process(_, [output]) {
    const left = output[0], right = output[1] || left, length = left.length, began = Date.now();
    if (!this.wasm || began < this.rest) return true;
    try {
      this.fill(this.ratio && this.ratio !== 1 ? length * this.ratio + 34 : length);
      if (this.channels) {
        if (this.ratio === 1) this.copy(left, right, Math.min(length, this.write - this.read));
        else this.mix(left, right, Math.min(length, Math.floor((this.write - this.read - 17) / this.ratio)), this.ratio, 1);
      }
      this.pass();
    } catch (error) {
      this.stop(error);
    }
    this.count(began, length);
    return true;
  }

  // plays frames at the rate of the loudspeaker
  copy(left, right, frames) {
    const mask = this.room - 1, n = this.channels, { ring, pan } = this;
    for (let i = 0; i < frames; i++) {
      let l = 0, r = 0;
      for (let c = 0; c < n; c++) {
        const x = ring[(this.read & mask) * n + c];
        l += x * pan[c][0];
        r += x * pan[c][1];
      }
      this.loud += (this.level - this.loud) * 0.002;
      left[i] = l * this.loud;
      if (right !== left) right[i] = r * this.loud;
      this.read++;
    }
  }

  // the computing time, as a share of real time over half a second
  count(began, length) {
    const now = Date.now();
    this.work += now - began;
    if (now - began > LATE) this.rest = now + (now - began) / 2;
    this.blocks += length;
    if (this.blocks < sampleRate / 2) return;
    const load = this.work * 1e-3 * sampleRate / this.blocks;
    this.port.postMessage({ type: "load", load, gaps: this.gaps, ahead: (this.write - this.read) / (this.rate || sampleRate) });
    this.work = this.blocks = 0;
  }
}

registerProcessor("instrument", Instrument);
