// The modes of a model as a table, and below it a form that tunes a part, as `ca tune` does.

import { element } from "../controls.js";
import { table } from "./table.js";

// rows of the table
const ROWS = 40;

export class Modes {
  /**
   * @param {(id: string) => any} find
   * @param {import("./text.js").ModelText} text
   */
  constructor(find, text) {
    this.find = find;
    this.text = text;
    find("modes").addEventListener("click", () => this.show());
    find("tuneForm").addEventListener("submit", e => { e.preventDefault(); this.tune(); });
    find("tuneForm").addEventListener("keydown", e => e.stopPropagation());
    find("tuneScale").addEventListener("change", () => { find("tunePitch").setAttribute("aria-label", find("tuneScale").value ? "Pitch of the root" : "Pitch"); });
  }

  async show() {
    const made = await this.text.ask({ type: "modes" }, this.find("modes"));
    this.find("modesBox").hidden = !made.ok;
    if (!made.ok) return;
    const sounding = made.modes.filter(m => m.heard_hz > 0);
    const row = m => [m.heard_hz.toFixed(2), (m.cents >= 0 ? "+" : "−") + Math.abs(m.cents).toFixed(1), m.grows ? "grows" : m.t60_s === null ? "–" : m.t60_s.toPrecision(3)];
    const more = sounding.length > ROWS ? `${sounding.length - ROWS} more. ` : "", out = made.left_out.map(l => l.name);
    const note = more + (out.length ? `Not included, because they are not linear: ${out.join(", ")}.` : "");
    this.find("modesTable").replaceChildren(table(["Hz", "cents", "T60 [s]"], sounding.slice(0, ROWS).map(row)), element("p", { class: "doc", text: note }));
    const part = this.find("tunePart"), before = part.value;
    part.replaceChildren(...made.parts.map(name => element("option", { value: name, text: name })));
    if (made.parts.includes(before)) part.value = before;
    this.find("tuneForm").hidden = made.parts.length === 0;
  }

  // tunes a part, and plays the text with the new number
  async tune() {
    const [part, scale, pitch, mode] = ["tunePart", "tuneScale", "tunePitch", "tuneMode"].map(id => this.find(id).value.trim());
    const to = scale ? { parts: [part], scale, root: pitch } : { parts: [`${part}=${pitch}`] };
    const made = await this.text.ask({ type: "tune", ...to, mode: Number(mode) }, this.find("tune"));
    if (!made.ok) return;
    this.text.replace(made.text);
    this.text.say(made.tuned.map(t => `${t.part}: ${t.before_hz.toFixed(2)} Hz → ${t.heard_hz.toFixed(2)} Hz`).join(", "));
    await this.show();
  }
}
