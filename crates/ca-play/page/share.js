// Gives the model to other people: as a link that carries it, and as one file that plays it.

import { pack } from "./browser/model.js";
import { save } from "./browser/connection.js";

// copies a link to the page of a site that plays a text
/**
 * @param {string} text
 * @param {string} site
 * @param {(text: string, bad?: boolean) => void} say
 */
export async function share(text, site, say) {
  const at = new URL("play.html", site);
  try {
    at.hash = "model=" + await pack(text);
  } catch (error) {
    return say(error.message, true);
  }
  try {
    await navigator.clipboard.writeText(String(at));
    say("The link is copied. It opens this instrument.");
  } catch {
    window.prompt("Copy this link. It opens this instrument.", String(at));
  }
}

// the buttons of the page of `ca play`, whose server has the model
export class Sharing {
  /**
   * @param {(id: string) => any} find
   * @param {import("./messages.js").Messages} connection
   * @param {(text: string, bad?: boolean) => void} say
   */
  constructor(find, connection, say) {
    this.connection = connection;
    this.say = say;
    const { site, oneFile } = document.documentElement.dataset;
    find("sharing").hidden = !site && !oneFile;
    find("oneFile").hidden = !oneFile;
    find("shareLink").hidden = !site;
    find("oneFile").addEventListener("click", () => this.give(oneFile, async made => {
      save(`${find("model").textContent || "instrument"}.html`, await made.blob(), "text/html");
    }));
    find("shareLink").addEventListener("click", () => this.give("model.ca.toml", async made => share(await made.text(), site, say)));
  }

  // stores the model as it is now, and passes on what the server makes of it
  async give(file, act) {
    const reply = await this.connection.ask({ type: "snapshot" });
    if (reply.ok === false) return this.say(reply.text, true);
    try {
      const made = await fetch(file);
      if (!made.ok) throw new Error(`status ${made.status}`);
      await act(made);
    } catch (error) {
      this.say(`The model cannot be shared: ${error.message}.`, true);
    }
  }
}
