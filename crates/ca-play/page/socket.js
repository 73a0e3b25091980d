// Connection to `ca play` by a socket. Determines when the connection is lost, ended or late, and when to retry.

import { Messages } from "./messages.js";

const WAITS = [300, 600, 1200, 2500, 5000];
const ENDED = new Set([1000, 1001]);

export class Connection extends Messages {
  /**
   * @param {URL} address
   * @param {import("./messages.js").Handlers} handlers
   */
  constructor(address, handlers) {
    super(handlers, "`ca play`");
    this.address = address;
    this.tries = 0;
    this.timer = 0;
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
    if (typeof data === "string") this.text(data);
    else this.binary(data);
  }

  /** @param {import("./protocol.js").Request & {id?: number}} message */
  send(message) {
    if (!this.open || this.socket.readyState !== 1) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
