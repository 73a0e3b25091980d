// Sound of an engine in this browser. The engine itself plays it, so switching it off only makes it silent.

import { Sound } from "../sound.js";

export class EngineSound extends Sound {
  /**
   * @param {import("./connection.js").EngineConnection} connection
   * @param {(sound: Sound) => void} changed
   */
  constructor(connection, changed) {
    super({ send: m => connection.send(m), changed });
    this.connection = connection;
    // a press of the user may start the sound, and moves the instrument at once
    for (const name of ["pointerdown", "pointerup", "keydown"])
      addEventListener(name, () => connection.resume().catch(() => undefined), { capture: true });
    // a screen that was off may have stopped it
    document.addEventListener("visibilitychange", () => { if (!document.hidden && this.state === "on") connection.resume().catch(() => undefined); });
  }

  configure() { this.loud(); }

  async start() {
    if (this.state === "on" || this.state === "starting" || !this.rate) return;
    this.set("starting");
    try {
      await this.connection.resume();
      this.set("on");
      this.loud();
      this.ask();
    } catch (error) {
      this.reason = String(error.message || error);
      this.set("failed");
    }
  }

  stop() {
    if (this.state !== "on") return;
    this.set("off");
    this.loud();
    this.ask();
  }

  loud() { this.connection.setLevel(this.state === "on" && !this.muted ? this.volume ** 2 : 0); }

  push() {
    this.gaps = this.connection.gaps;
    this.ahead = this.connection.ahead;
  }

  get latency() { return this.connection.latency; }
}
