// The line to the engine.
//
// Decides that a lost line is tried again by itself, less and less often, and that who waits for an answer gets one: "no"
// where the line is gone.

export class Socket {
  constructor(on) {
    this.on = on;
    this.asked = new Map();
    this.number = 0;
    this.wait = 250;
    this.open();
  }

  open() {
    const at = new URL("ws", location.href);
    at.protocol = "ws:";
    const line = new WebSocket(at);
    line.binaryType = "arraybuffer";
    this.line = line;
    line.onopen = () => {
      this.wait = 250;
      this.on.line("open");
    };
    line.onmessage = ({ data }) => (typeof data === "string" ? this.text(JSON.parse(data)) : this.bytes(data));
    line.onclose = ({ code }) => {
      for (const answer of this.asked.values()) answer({ ok: false, text: "the line to the engine is gone" });
      this.asked.clear();
      this.on.line(code === 1001 ? "ended" : "lost");
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, 5000);
    };
  }

  text(message) {
    if (message.type === "reply") {
      const answer = this.asked.get(message.id);
      this.asked.delete(message.id);
      if (answer) answer(message);
      else if (!message.ok) this.on.said({ bad: true, text: message.text });
      return;
    }
    this.on[message.type]?.(message);
  }

  bytes(data) {
    const head = new DataView(data);
    const [kind, second, tick] = [head.getUint32(0, true), head.getUint32(4, true), head.getFloat64(8, true)];
    const numbers = new Float32Array(data, 16);
    if (kind === 1) this.on.view(second, tick, numbers);
    if (kind === 2) this.on.heard(second, tick, numbers);
  }

  /** Says something that needs no answer; false where nobody hears it. */
  say(message) {
    if (this.line.readyState !== WebSocket.OPEN) return false;
    this.line.send(JSON.stringify(message));
    return true;
  }

  /** Asks, and promises the answer. */
  ask(message) {
    return new Promise((answer) => {
      const id = ++this.number;
      if (this.say({ ...message, id })) this.asked.set(id, answer);
      else answer({ ok: false, text: "the line to the engine is gone" });
    });
  }
}
