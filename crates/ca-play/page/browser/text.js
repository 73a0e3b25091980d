// The text of the model, where the page itself compiles it: edit, hear, save, share.

import { share } from "../share.js";
import { save } from "./connection.js";

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

  async render(button) {
    button.disabled = true;
    const made = await this.connection.compiler.ask({ type: "render", ...this.connection.model, text: this.area.value });
    button.disabled = false;
    if (made.ok) save(made.file, made.bytes, "audio/wav");
    else this.say(made.text.split("\n")[0], true);
  }
}
