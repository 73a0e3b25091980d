// Messages between the page and the engine, whatever carries them. A request that needs an answer returns a promise. It
// resolves to a refusal after four seconds without an answer, or when the connection is lost. Binary messages are passed
// on without copying, as a float view of the received bytes.

/**
 * @typedef {object} Handlers
 * @property {(message: import("./protocol.js").SceneMessage) => void} scene
 * @property {(message: import("./protocol.js").StateMessage) => void} state
 * @property {(message: import("./protocol.js").EnergyMessage) => void} energy
 * @property {(message: import("./protocol.js").SaidMessage) => void} said
 * @property {(message: import("./protocol.js").ReportMessage) => void} report
 * @property {(generation: number, tick: number, floats: Float32Array) => void} view
 * @property {(channels: number, tick: number, floats: Float32Array) => void} sound
 * @property {(name: string, detail: object) => void} status
 */

/**
 * An answer, or a refusal if none arrived.
 * @typedef {Partial<import("./protocol.js").ReplyMessage> & {ok: boolean, lost?: boolean}} Answer
 */

export class Messages {
  /**
   * @param {Handlers} handlers
   * @param {string} other name of the other side, in refusals
   */
  constructor(handlers, other) {
    this.on = handlers;
    this.other = other;
    this.waiting = new Map();
    this.next = 1;
    this.open = false;
  }

  /** @param {string} text */
  text(text) {
    /** @type {import("./protocol.js").Message} */
    let message;
    try {
      message = JSON.parse(text);
    } catch {
      return;
    }
    this.message(message);
  }

  /** @param {import("./protocol.js").Message} message */
  message(message) {
    switch (message.type) {
      case "scene": return this.on.scene(message);
      case "state": return this.on.state(message);
      case "energy": return this.on.energy(message);
      case "said": return this.on.said(message);
      case "report": return this.on.report(message);
      case "reply": return this.answer(message);
      default:
    }
  }

  /** @param {ArrayBuffer} bytes */
  binary(bytes) {
    if (bytes.byteLength < 16) return;
    const head = new DataView(bytes);
    const floats = new Float32Array(bytes, 16, (bytes.byteLength - 16) >> 2);
    const kind = head.getUint32(0, true), second = head.getUint32(4, true), tick = head.getFloat64(8, true);
    if (kind === 1) this.on.view(second, tick, floats);
    else if (kind === 2) this.on.sound(second, tick, floats);
  }

  answer(message) {
    const waiting = this.waiting.get(message.id);
    if (!waiting) return;
    this.waiting.delete(message.id);
    clearTimeout(waiting.timer);
    waiting.done(message);
  }

  refuseAll() {
    for (const { done, timer } of this.waiting.values()) {
      clearTimeout(timer);
      done({ ok: false, lost: true, text: `lost connection to ${this.other}` });
    }
    this.waiting.clear();
  }

  /**
   * @param {import("./protocol.js").Request & {id?: number}} message
   * @returns {boolean} whether it was sent
   */
  send(message) {
    throw new Error(`${message.type}: no transport`);
  }

  /**
   * @param {import("./protocol.js").Request} message
   * @returns {Promise<Answer>}
   */
  ask(message) {
    const id = this.next++;
    if (!this.send({ ...message, id })) return Promise.resolve({ ok: false, lost: true, text: `not connected to ${this.other}` });
    return new Promise(done => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        done({ ok: false, lost: true, text: `no answer from ${this.other}` });
      }, 4000);
      this.waiting.set(id, { done, timer });
    });
  }
}
