// Error against run time of a model, as `ca accuracy` measures it. It runs in a worker of its own, which ends with it, so that
// neither the sound nor an edit waits.

import { element } from "../controls.js";
import { Compiler } from "./compiler.js";
import { save } from "./connection.js";
import { table } from "./table.js";

const HEAD = ["method", "error", "cents", "× real time", "stability"];
const small = v => v === null ? "–" : v.toExponential(1);

export class Accuracy {
  /**
   * @param {(id: string) => any} find
   * @param {import("./text.js").ModelText} text
   */
  constructor(find, text) {
    this.find = find;
    this.text = text;
    /** @type {Compiler|null} the measurement that runs */
    this.running = null;
    const { parts } = text.connection;
    find("accuracy").hidden = !parts.accuracy;
    if (!parts.accuracy) return;
    this.parts = { worker: parts.worker, compiler: parts.accuracy };
    find("accuracy").addEventListener("click", () => this.running ? this.running.end("The measurement was stopped.") : this.measure());
    find("accuracySave").addEventListener("click", () => save(this.file, this.page, "text/html"));
  }

  async measure() {
    const state = this.find("accuracyState"), show = (name, text) => { this.find("accuracy").textContent = name; state.textContent = text; };
    const running = new Compiler(this.parts, 0, (done, of) => { state.textContent = `Step ${done} of ${of}`; });
    this.running = running;
    this.find("accuracyBox").hidden = false;
    this.find("accuracySave").hidden = true;
    this.find("accuracyTable").replaceChildren();
    show("Stop measuring", "Measures…");
    const made = await running.ask(this.text.request({ type: "accuracy" })).catch(error => ({ ok: false, text: error.message }));
    running.end("");
    this.running = null;
    show("Accuracy", made.ok ? `${made.seconds.toFixed(3)} s at ${made.rate} Hz, against ${made.reference.words}.` : made.text);
    if (!made.ok) return;
    this.find("accuracyTable").replaceChildren(table(HEAD, made.rows.map(r => this.row(r))), ...this.notes(made));
    [this.file, this.page] = [`${made.name}_accuracy.html`, made.bytes];
    this.find("accuracySave").hidden = false;
  }

  row(r) {
    const name = (r.times > 1 ? `${r.method} ×${r.times}` : r.method) + (r.front ? " *" : "");
    return [name, small(r.error), r.cents === null ? "–" : r.cents.toFixed(3), r.real_time_factor.toFixed(2), r.stability];
  }

  notes(made) {
    const all = ["* no other row is both more exact and faster", ...made.refused.map(r => `${r.method} is not possible: ${r.why}`), ...made.warned.map(w => `${w.method}: ${w.what}`)];
    return all.map(text => element("p", { class: "doc", text }));
  }
}
