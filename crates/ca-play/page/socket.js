// Connection to `ca play`. Determines when the connection is lost, ended or late, and when to retry. A request that
// needs an answer returns a promise. It resolves to a refusal after four seconds without an answer, or when the
// connection is lost. Binary messages are passed on without copying, as a float view of the received bytes.

const WAITS = [300, 600, 1200, 2500, 5000];
const ENDED = new Set([1000, 1001]);

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

export class Connection {
  /**
   * @param {URL} address
   * @param {Handlers} handlers
   */
  constructor(address, handlers) {
    this.address = address;
    this.on = handlers;
    this.waiting = new Map();
    this.next = 1;
    this.tries = 0;
    this.timer = 0;
    this.open = false;
  }

  connect() {
    clearTimeout(this.timer);
    this.on.status("connecting", { tries: this.tries });
    let socket;
    try {
      socket = new WebSocket(this.address);
    } catch (error) {
      this.retry();
      return;
    }
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.open = true;
      this.tries = 0;
      this.on.status("open", {});
    };
    socket.onmessage = event => { if (socket === this.socket) this.receive(event.data); };
    socket.onclose = event => {
      if (socket !== this.socket) return;
      const was = this.open;
      this.open = false;
      this.refuseAll();
      if (was && ENDED.has(event.code)) this.on.status("ended", { reason: event.reason });
      else this.retry();
    };
  }

  retry() {
    const wait = WAITS[Math.min(this.tries, WAITS.length - 1)];
    this.tries++;
    this.on.status("lost", { tries: this.tries, wait });
    this.timer = setTimeout(() => this.connect(), wait);
  }

  again() {
    this.tries = 0;
    this.connect();
  }

  receive(data) {
    if (typeof data !== "string") return this.binary(data);
    /** @type {import("./protocol.js").Message} */
    let message;
    try {
      message = JSON.parse(data);
    } catch {
      return;
    }
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
      done({ ok: false, lost: true, text: "lost connection to `ca play`" });
    }
    this.waiting.clear();
  }

  /** @param {import("./protocol.js").Request & {id?: number}} message */
  send(message) {
    if (!this.open || this.socket.readyState !== 1) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /**
   * @param {import("./protocol.js").Request} message
   * @returns {Promise<Answer>}
   */
  ask(message) {
    const id = this.next++;
    if (!this.send({ ...message, id })) return Promise.resolve({ ok: false, lost: true, text: "not connected to `ca play`" });
    return new Promise(done => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        done({ ok: false, lost: true, text: "no answer from `ca play`" });
      }, 4000);
      this.waiting.set(id, { done, timer });
    });
  }
}
