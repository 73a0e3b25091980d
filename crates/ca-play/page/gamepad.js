// Game controllers, as MIDI. Buttons play notes of the model, from the lowest key on the screen up. Sticks are the MIDI
// controllers 16 to 19 and triggers 20 and 21, which *MIDI knob* binds to parameters.

const BUTTONS = [0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, 14, 15];
const TRIGGERS = [6, 7];
const VELOCITY = 100;
const FIRST = 16;
// a stick at rest is not exactly in the middle
const MIDDLE = 0.1;

export class Gamepads {
  // keyboard: on(key, note, velocity), end(key), nth(n); send(bytes), say(text)
  constructor(keyboard, { send, say }) {
    this.keyboard = keyboard; this.send = send;
    this.pads = new Map();
    addEventListener("gamepadconnected", e => say(`${e.gamepad.id}: its buttons play notes; sticks and triggers are the MIDI controllers ${FIRST} to ${FIRST + 5}`));
    addEventListener("gamepaddisconnected", e => this.gone(e.gamepad.index));
  }

  // reads all controllers, once per frame
  frame() {
    if (!navigator.getGamepads) return;
    for (const pad of navigator.getGamepads()) if (pad && pad.connected) this.read(pad);
  }

  read(pad) {
    const first = !this.pads.has(pad.index), last = this.pads.get(pad.index) || { down: new Set(), sent: new Map() };
    this.pads.set(pad.index, last);
    BUTTONS.forEach((button, n) => {
      const now = !!pad.buttons[button]?.pressed, who = `pad ${pad.index} ${button}`;
      if (now === last.down.has(who)) return;
      const note = this.keyboard.nth(n);
      if (now && note !== undefined) this.keyboard.on(who, note, VELOCITY);
      else this.keyboard.end(who);
      last.down[now ? "add" : "delete"](who);
    });
    const sticks = [0, 1, 2, 3].map(a => Math.abs(pad.axes[a] || 0) < MIDDLE ? 0.5 : 0.5 + 0.5 * pad.axes[a]);
    [...sticks, ...TRIGGERS.map(b => pad.buttons[b]?.value || 0)].forEach((part, n) => {
      const value = Math.round(127 * Math.min(1, Math.max(0, part)));
      // a controller that has not moved yet must not move a parameter
      if (!first && value !== last.sent.get(n)) this.send([0xb0, FIRST + n, value]);
      last.sent.set(n, value);
    });
  }

  gone(index) {
    for (const who of this.pads.get(index)?.down || []) this.keyboard.end(who);
    this.pads.delete(index);
  }
}
