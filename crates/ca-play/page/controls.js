// Sliders for parameters, ports and the picture. A slider is logarithmic if its range spans decades. Arrow keys move it
// by 0.5 % of its travel, or by 0.05 % with Shift. A value can be typed with its unit. A double click, or the small
// button beside the name, restores the value at load. While a hand moves the slider, updates from the server do not.

import { format, typed, scaleOf } from "./units.js";

const STEPS = 10000;
let serial = 0;

const element = (tag, attributes = {}, ...children) => {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") e.textContent = value;
    else if (value !== null && value !== undefined && value !== false) e.setAttribute(name, value);
  }
  e.append(...children);
  return e;
};

export class Slider {
  // spec: name, value, min, max, unit, doc, plainText(value) for display; set(value or text) -> promise of {ok, text}
  // or nothing
  constructor(spec, set) {
    this.spec = spec;
    this.set = set;
    this.value = this.first = spec.value;
    let { min, max } = spec;
    if (!Number.isFinite(min)) min = spec.value > 0 ? spec.value / 100 : spec.value - 1;
    if (!Number.isFinite(max)) max = spec.value > 0 ? spec.value * 100 : spec.value + 1;
    this.min = Math.min(min, spec.value); this.max = Math.max(max, spec.value);
    this.scale = scaleOf(this.min, this.max, spec.value);
    this.busy = 0;
    this.wanted = null;
    /** @type {HTMLElement|null} */
    this.learn = null;
    const id = "s" + serial++;
    this.range = element("input", { type: "range", id, min: 0, max: STEPS, step: 1, "aria-describedby": spec.doc ? id + "d" : null });
    this.field = element("input", { type: "text", class: "value", "aria-label": spec.name + ", value", inputmode: "text", autocomplete: "off", spellcheck: "false" });
    this.back = element("button", { class: "back", type: "button", title: "Reset to the value at load", "aria-label": `${spec.name}: reset to the value at load`, hidden: "", text: "↺" });
    this.error = element("p", { class: "error", role: "status", hidden: "" });
    const label = element("label", { for: id, text: spec.label || spec.name });
    this.row = element("div", { class: "slider" }, element("div", { class: "head" }, label, this.back, this.field), this.range);
    if (spec.doc) this.row.append(element("p", { class: "doc", id: id + "d", title: spec.doc, text: spec.doc }));
    this.row.append(this.error);

    this.range.addEventListener("input", () => this.byHand(this.scale.value(this.range.value / STEPS)));
    this.range.addEventListener("change", () => { this.busy = performance.now() + 600; if (spec.ended) spec.ended(); });
    this.range.addEventListener("keydown", e => this.key(e));
    this.range.addEventListener("dblclick", () => this.byHand(this.first));
    label.addEventListener("dblclick", () => this.byHand(this.first));
    this.back.addEventListener("click", () => { this.byHand(this.first); this.range.focus(); });
    this.field.addEventListener("focus", () => this.field.select());
    this.field.addEventListener("blur", () => { if (this.field.value !== this.written) this.type(); });
    this.field.addEventListener("keydown", e => {
      if (e.key === "Enter") { this.type(); this.field.select(); }
      else if (e.key === "Escape") { this.say(""); this.write(true); this.field.blur(); }
      e.stopPropagation();
    });
    this.write(true);
  }

  text(value) {
    return this.spec.plainText ? this.spec.plainText(value) : format(value, this.spec.unit, 5);
  }

  key(e) {
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[e.key];
    if (!sign || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    const place = Math.min(1, Math.max(0, this.scale.place(this.value) + sign * (e.shiftKey ? 0.0005 : 0.005)));
    this.byHand(this.scale.value(place));
  }

  byHand(value) {
    // few digits, so that values are readable and repeatable
    const clean = value === this.first ? value : +value.toPrecision(4);
    this.value = Math.min(this.max, Math.max(this.min, clean));
    this.busy = performance.now() + 600;
    this.write();
    this.push(this.value);
  }

  type() {
    const wanted = typed(this.field.value, this.value, this.spec.unit);
    if (wanted === null || this.field.value === this.written) return this.write(true);
    this.busy = performance.now() + 600;
    if (typeof wanted === "number") {
      this.value = wanted;
      this.write(true);
    }
    this.push(wanted);
  }

  // sends only the newest value, once per frame, and the next one after the answer
  push(value) {
    this.wanted = value;
    if (this.sending) return;
    this.sending = true;
    requestAnimationFrame(async () => {
      while (this.wanted !== null) {
        const next = this.wanted;
        this.wanted = null;
        const reply = await this.set(next);
        if (this.wanted !== null) continue;
        if (reply && reply.ok === false) { this.busy = 0; this.say(reply.text || "request refused"); }
        else { this.say(""); if (typeof next === "string") this.busy = 0; }
      }
      this.sending = false;
    });
  }

  say(text) {
    this.error.textContent = text;
    this.error.hidden = !text;
    this.row.classList.toggle("refused", !!text);
  }

  // update from the server or from the picture
  update(value) {
    if (!Number.isFinite(value) || this.sending || performance.now() < this.busy || value === this.value) return;
    this.value = value;
    this.write();
  }

  write(force = false) {
    const place = this.scale.place(this.value), text = this.text(this.value);
    this.range.value = Math.round(place * STEPS);
    this.range.setAttribute("aria-valuetext", text);
    this.range.style.setProperty("--fill", (100 * Math.min(1, Math.max(0, place))).toFixed(2) + "%");
    if (force || document.activeElement !== this.field) { this.field.value = text; this.written = text; }
    this.back.hidden = this.spec.noBack || Math.abs(this.value - this.first) <= 1e-9 * Math.abs(this.first);
  }
}

// parameters of a scene; values at load come from the first scene while the names are the same
export class Parameters {
  /**
   * @param {HTMLElement} box
   * @param {HTMLInputElement} filter
   * @param {import("./messages.js").Messages} connection
   */
  constructor(box, filter, connection) {
    this.box = box; this.filter = filter; this.connection = connection;
    this.sliders = new Map();
    filter.addEventListener("input", () => this.find());
    filter.addEventListener("keydown", e => e.stopPropagation());
  }

  /** @param {Array<import("./protocol.js").Param>} specs */
  build(specs) {
    const first = new Map(this.sliders);
    this.sliders.clear();
    this.box.replaceChildren();
    if (specs.length === 0) this.box.append(element("p", { class: "doc", text: "This model has no live parameters. A parameter in [param] with live = true can change while the model plays." }));
    for (const spec of specs) {
      const slider = new Slider(spec, value => this.connection.ask({ type: "set", values: { [spec.name]: value } }));
      const old = first.get(spec.name);
      if (old && old.spec.unit === spec.unit) slider.first = old.first;
      slider.write(true);
      slider.learn = element("button", { class: "learn", type: "button", title: "Click, then move a knob of a MIDI device to bind it to this parameter", text: "MIDI knob" });
      slider.learn.addEventListener("click", async () => {
        const reply = await this.connection.ask({ type: "learn", name: this.learning === spec.name ? null : spec.name });
        slider.say(reply.ok === false ? reply.text || "request refused" : "");
      });
      slider.back.before(slider.learn);
      this.sliders.set(spec.name, slider);
      this.box.append(slider.row);
    }
    this.filter.hidden = specs.length < 10;
    this.find();
  }

  find() {
    const words = this.filter.hidden ? "" : this.filter.value.trim().toLowerCase();
    for (const [name, s] of this.sliders) s.row.hidden = words !== "" && !(name + " " + (s.spec.doc || "")).toLowerCase().includes(words);
  }

  // shows bound controllers and the parameter that waits for one
  bind(bound, learning) {
    this.learning = learning;
    const by = new Map(bound.map(b => [b.name, b]));
    for (const [name, s] of this.sliders) {
      const b = by.get(name), text = learning === name ? "turn a knob…" : b ? `knob ${b.number}` : "MIDI knob";
      s.learn.classList.toggle("bound", !!b || learning === name);
      if (s.learn.textContent !== text) s.learn.textContent = text;
    }
  }

  values() {
    return Object.fromEntries([...this.sliders].map(([name, s]) => [name, s.value]));
  }

  // sets all values in one request
  set(values) {
    for (const name in values) {
      const s = this.sliders.get(name);
      s.value = values[name];
      s.busy = performance.now() + 600;
      s.write();
    }
    this.connection.ask({ type: "set", values });
  }

  update(values) {
    for (const name in values) {
      const slider = this.sliders.get(name);
      if (slider) slider.update(values[name]);
    }
  }
}

// Sliders for ports. Positions stay where they are put; forces return to zero on release. A key of a device can be
// moved only while no device is connected. Returns a function that shows positions, whatever moves them.
/**
 * @param {HTMLElement} box
 * @param {Array<import("./protocol.js").PortInfo>} list
 * @param {import("./messages.js").Messages} connection
 */
export function ports(box, list, connection) {
  box.replaceChildren();
  const seen = [];
  for (const p of list) {
    const force = p.role === "force", rest = Number.isFinite(p.rest) ? p.rest : 0;
    const spec = {
      name: p.name, value: force ? 0 : rest, unit: force ? "N" : "m",
      min: force ? -5 : rest - 0.02, max: force ? 5 : rest + 0.02,
      doc: force ? "Force; zero after release" : p.role === "device" ? "Key of a device; this slider moves it while no device is connected" : "Position", ended: null,
    };
    const slider = new Slider(spec, value => connection.ask({ type: "port", name: p.name, value }));
    if (force) {
      const go = () => { if (slider.value !== 0) slider.byHand(0); };
      for (const name of ["pointerup", "pointercancel", "keyup", "blur"]) slider.range.addEventListener(name, () => setTimeout(go, 0));
    }
    if (!force && p.mass != null) seen.push([slider, p.mass, rest]);
    box.append(slider.row);
  }
  return (scene, pair) => {
    for (const [slider, mass, rest] of seen) {
      if (!scene.space[mass]) slider.update(rest + pair.b[scene.offset[mass]]);
    }
  };
}

export { element };
