// Presets of the model, and presets that this browser stores for a model of this name. A slider interpolates between
// the values before the choice and the chosen preset: its middle is halfway for each parameter.

import { element } from "./controls.js";

const KEY = "ca play presets ";

export class Presets {
  // values() -> {name: number}, set({name: number})
  constructor(find, { values, set }) {
    this.box = find("presetsBox"); this.list = find("presets"); this.name = find("presetName"); this.way = find("morph");
    this.values = values; this.set = set;
    this.model = "";
    this.ofModel = [];
    this.near = this.far = null;
    find("presetForm").addEventListener("submit", e => { e.preventDefault(); this.save(this.name.value.trim()); });
    this.name.addEventListener("keydown", e => e.stopPropagation());
    this.way.addEventListener("input", () => this.morph());
  }

  // A scene begins: its model, its presets, and whether it has parameters.
  scene(model, presets, any) {
    this.model = model;
    // an edit of a model with presets leaves the box as it is
    if (presets.length && !this.ofModel.length) this.box.open = true;
    this.ofModel = presets;
    this.box.hidden = !any;
    this.far = null;
    this.draw();
  }

  read() {
    try {
      const all = JSON.parse(localStorage.getItem(KEY + this.model));
      return all && typeof all === "object" ? all : {};
    } catch {
      return {};
    }
  }

  write(all) {
    try {
      localStorage.setItem(KEY + this.model, JSON.stringify(all));
    } catch {
      // a browser without storage does not keep presets
    }
    this.draw();
  }

  save(name) {
    if (!name) return;
    this.write({ ...this.read(), [name]: this.values() });
    this.name.value = "";
  }

  choose(key, values) {
    const now = this.values();
    this.near = now;
    // only finite values of parameters that this model has
    this.far = Object.fromEntries(Object.entries(values).filter(([n, v]) => n in now && Number.isFinite(v)));
    this.way.value = 100;
    this.morph();
    this.draw(key);
  }

  morph() {
    if (!this.far) return;
    const t = this.way.value / 100;
    this.way.style.setProperty("--fill", 100 * t + "%");
    const all = Object.entries(this.far).map(([n, v]) => [n, t >= 1 ? v : this.near[n] + t * (v - this.near[n])]);
    if (all.length) this.set(Object.fromEntries(all));
  }

  draw(chosen) {
    const stored = this.read();
    const row = (key, text, values, ...more) => {
      const pick = element("button", { type: "button", class: "pick", "aria-pressed": String(key === chosen), text });
      pick.addEventListener("click", () => this.choose(key, values));
      return element("div", { class: "preset" }, pick, ...more);
    };
    const own = name => {
      const drop = element("button", { type: "button", class: "back", title: "Delete", "aria-label": `Delete ${name}`, text: "×" });
      drop.addEventListener("click", () => { const rest = this.read(); delete rest[name]; this.write(rest); });
      return row("own " + name, name, stored[name] || {}, drop);
    };
    this.list.replaceChildren(
      ...this.ofModel.map(p => row("model " + p.name, p.name.replaceAll("_", " "), p.values)),
      ...Object.keys(stored).map(own),
    );
    this.way.parentNode.hidden = !this.far;
  }
}
