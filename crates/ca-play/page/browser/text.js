// The text of the model, where the page itself compiles it: edit, hear, save, share.

import { share } from "../share.js";
import { save } from "./connection.js";
import { Modes } from "./modes.js";
import { Accuracy } from "./accuracy.js";

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
    new Modes(find, this);
    new Accuracy(find, this);
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

  // a request about the text as it is now
  request(what) { return { ...this.connection.model, ...what, text: this.area.value }; }

  // asks the compiler; a refusal is said
  async ask(what, button) {
    button.disabled = true;
    const made = await this.connection.compiler.ask(this.request(what)).catch(error => ({ ok: false, text: error.message }));
    button.disabled = false;
    if (!made.ok) this.say(made.text.split("\n")[0], true);
    return made;
  }

  // plays a text that the page made
  replace(text) {
    this.area.value = text;
    this.apply();
  }

  async render(button) {
    const made = await this.ask({ type: "render" }, button);
    if (made.ok) save(made.file, made.bytes, "audio/wav");
  }
}
