// The text of the model, where the page itself compiles it: edit, hear, save, share.

import { share } from "../share.js";
import { save } from "./connection.js";
import { element } from "../controls.js";

// rows of the table of modes
const ROWS = 40;

export class ModelText {
  /**
   * @param {(id: string) => any} find
   * @param {import("./connection.js").EngineConnection} connection
   * @param {(text: string, bad?: boolean) => void} say
   */
  constructor(find, connection, say) {
    this.connection = connection;
    this.say = say;
    this.area = find("modelText");
    find("textBox").hidden = false;
    find("record").title = "Records the sound from now on, and saves it as a WAV file";
    find("apply").addEventListener("click", () => this.apply());
    find("saveText").addEventListener("click", () => save(connection.model.file, this.area.value, "text/plain"));
    find("share").hidden = !this.site;
    find("share").addEventListener("click", () => share(this.area.value, this.site, say));
    find("render").addEventListener("click", () => this.render(find("render")));
    find("modes").addEventListener("click", () => this.modes(find("modes"), find("modesBox")));
    this.area.addEventListener("keydown", e => {
      e.stopPropagation();
      if (e.key === "Enter" && (e.ctrlKey || e.metaKey)) { e.preventDefault(); this.apply(); }
    });
    connection.first.then(model => { this.area.value = model.text; }, () => undefined);
  }

  apply() { this.connection.edit(this.area.value); }

  // the address of the page on its site, where there is one
  get site() {
    const site = document.documentElement.dataset.site;
    return site || (location.protocol.startsWith("http") ? document.baseURI : "");
  }

  // asks the compiler about the text as it is now
  async ask(type, button) {
    button.disabled = true;
    const made = await this.connection.compiler.ask({ type, ...this.connection.model, text: this.area.value });
    button.disabled = false;
    return made;
  }

  async modes(button, box) {
    const made = await this.ask("modes", button);
    box.hidden = !made.ok;
    if (!made.ok) return this.say(made.text.split("\n")[0], true);
    const sounding = made.modes.filter(m => m.heard_hz > 0);
    const cells = (kind, values) => values.map(text => element(kind, { text }));
    const row = m => [m.heard_hz.toFixed(2), (m.cents >= 0 ? "+" : "−") + Math.abs(m.cents).toFixed(1), m.grows ? "grows" : m.t60_s === null ? "–" : m.t60_s.toPrecision(3)];
    const table = element("table", {});
    table.append(...[["th", ["Hz", "cents", "T60 [s]"]], ...sounding.slice(0, ROWS).map(m => ["td", row(m)])].map(([kind, values]) => {
      const line = element("tr", {});
      line.append(...cells(kind, values));
      return line;
    }));
    const more = sounding.length > ROWS ? `${sounding.length - ROWS} more. ` : "", out = made.left_out.map(l => l.name);
    const note = more + (out.length ? `Not included, because they are not linear: ${out.join(", ")}.` : "");
    box.replaceChildren(table, element("p", { class: "doc", text: note }));
  }

  async render(button) {
    const made = await this.ask("render", button);
    if (made.ok) save(made.file, made.bytes, "audio/wav");
    else this.say(made.text.split("\n")[0], true);
  }
}
