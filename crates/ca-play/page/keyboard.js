// Keyboard for models whose ports receive notes: keys on the screen, computer keys, and MIDI of this browser. All are
// sent as MIDI, so that a note acts as from a cable. The vertical position of a press sets the velocity. Keys without a
// port are gaps. Computer keys play only while that is switched on, because letters are shortcuts otherwise.

import { element } from "./controls.js";

const NAMES = ["C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"];
const BLACK = new Set([1, 3, 6, 8, 10]);
// two rows of physical keys, independent of the layout
const ROWS = ["KeyZ KeyS KeyX KeyD KeyC KeyV KeyG KeyB KeyH KeyN KeyJ KeyM Comma", "KeyQ Digit2 KeyW Digit3 KeyE KeyR Digit5 KeyT Digit6 KeyY Digit7 KeyU KeyI"];
const PLACES = new Map(ROWS.flatMap((row, octave) => row.split(" ").map((code, n) => [code, 12 * octave + n])));
const MOST = 25;

const name = note => NAMES[note % 12] + (Math.floor(note / 12) - 1);

export class Keyboard {
  // send(bytes), say(text, bad)
  constructor(find, { send, say }) {
    this.box = find("keyboardBox"); this.keys = find("keyboard"); this.octaves = find("octaves");
    this.letters = find("letters"); this.browser = find("webmidi");
    this.send = send; this.say = say;
    this.down = new Map();
    this.from = 60;
    this.range = null;
    this.keys.addEventListener("pointerdown", e => this.press(e));
    this.keys.addEventListener("pointermove", e => this.slide(e));
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) this.keys.addEventListener(kind, e => this.end(e.pointerId));
    for (const [id, by] of [["lower", -12], ["higher", 12]]) find(id).addEventListener("click", () => this.shift(by));
    addEventListener("keydown", e => this.letter(e, true), true);
    addEventListener("keyup", e => this.letter(e, false), true);
    addEventListener("blur", () => this.allOff());
    this.letters.addEventListener("change", () => this.allOff());
    this.browser.hidden = !navigator.requestMIDIAccess;
    this.browser.addEventListener("click", () => this.connect());
  }

  // notes of the ports of the scene, lowest first, or null
  build(notes) {
    this.allOff();
    const range = notes && notes.length ? [notes[0], notes[notes.length - 1]] : null;
    this.playable = new Set(notes || []);
    this.range = range;
    this.box.hidden = !range;
    if (!range) return;
    this.from = Math.max(range[0], Math.min(this.from, Math.max(range[0], range[1] - MOST + 1)));
    if (range[1] - range[0] < MOST) this.from = range[0];
    this.draw();
  }

  // the note of playable key number n, from the lowest key on the screen
  nth(n) {
    return [...this.playable || []].filter(note => note >= this.from)[n];
  }

  shift(by) {
    this.allOff();
    this.from = Math.max(this.range[0], Math.min(this.from + by, Math.max(this.range[0], this.range[1] - MOST + 1)));
    this.draw();
  }

  draw() {
    const last = Math.min(this.range[1], this.from + MOST - 1);
    this.octaves.hidden = this.range[1] - this.range[0] < MOST;
    this.keys.replaceChildren();
    for (let note = this.from; note <= last; note++) {
      const black = BLACK.has(note % 12), plays = this.playable.has(note);
      this.keys.append(element("button", {
        type: "button", class: black ? "black" : "white", "data-note": note, "aria-label": name(note), disabled: !plays && "", "aria-hidden": !plays && "true",
        text: plays && (note % 12 === 0 || note === this.from) ? name(note) : "",
      }));
    }
  }

  keyAt(event) {
    const key = /** @type {HTMLButtonElement|null} */ (document.elementFromPoint(event.clientX, event.clientY));
    return key && key.parentNode === this.keys && !key.disabled ? key : null;
  }

  press(event) {
    const key = this.keyAt(event);
    if (!key) return;
    event.preventDefault();
    this.keys.setPointerCapture(event.pointerId);
    this.strike(event.pointerId, key, event);
  }

  strike(who, key, event) {
    const box = key.getBoundingClientRect(), deep = Math.min(1, Math.max(0, (event.clientY - box.top) / box.height));
    this.on(who, +key.dataset.note, Math.round(40 + 87 * deep));
  }

  slide(event) {
    if (!this.down.has(event.pointerId)) return;
    const key = this.keyAt(event);
    if (key && +key.dataset.note !== this.down.get(event.pointerId)) this.strike(event.pointerId, key, event);
  }

  letter(event, down) {
    const place = PLACES.get(event.code);
    if (!this.range || !this.letters.checked || place === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches && event.target.matches("input[type=text], input[type=search], textarea, select")) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!down) this.end(event.code);
    else if (!event.repeat) this.on(event.code, this.from + place, 100);
  }

  on(who, note, velocity) {
    this.end(who);
    if (!this.playable.has(note)) return;
    this.down.set(who, note);
    this.mark(note, true);
    this.send([0x90, note, velocity]);
  }

  end(who) {
    const note = this.down.get(who);
    if (note === undefined) return;
    this.down.delete(who);
    // another finger still holds the key
    if ([...this.down.values()].includes(note)) return;
    this.mark(note, false);
    this.send([0x80, note, 0]);
  }

  allOff() {
    for (const who of [...this.down.keys()]) this.end(who);
  }

  mark(note, on) {
    const key = this.keys.querySelector(`[data-note="${note}"]`);
    if (key) key.classList.toggle("down", on);
  }

  async connect() {
    let access;
    try {
      access = await navigator.requestMIDIAccess();
    } catch (error) {
      return this.say("MIDI is not available in this browser: " + error.message, true);
    }
    const listen = () => {
      const inputs = [...access.inputs.values()];
      for (const input of inputs) input.onmidimessage = e => { if (e.data[0] < 0xf0) this.send([...e.data]); };
      this.browser.textContent = inputs.length ? "MIDI: " + inputs.map(i => i.name).join(", ") : "MIDI: no device connected";
    };
    access.onstatechange = listen;
    listen();
  }
}
