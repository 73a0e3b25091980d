// Shows load, lateness, losses, devices, messages and the connection. Losses, divergence and refusals are coloured.
// Some messages stay, and others fade after a while.

import { element } from "./controls.js";

const LOAD = "Computing time as a share of real time";
const count = (n, one, many = one + "s") => `${n} ${n === 1 ? one : many}`;

export class Status {
  /**
   * @param {(id: string) => any} find
   * @param {import("./messages.js").Messages} connection
   */
  constructor(find, connection) {
    this.find = find;
    this.before = {};
    find("arm").addEventListener("click", () => this.arm(connection, true));
    find("disarm").addEventListener("click", () => this.arm(connection, false));
    const stop = find("stop");
    stop.addEventListener("click", () => {
      if (!stop.classList.contains("sure")) {
        stop.classList.add("sure");
        stop.textContent = "Press again to end";
        setTimeout(() => { stop.classList.remove("sure"); stop.replaceChildren("End ", element("code", { text: "ca play" })); }, 3000);
      } else connection.ask({ type: "stop" });
    });
    const record = find("record");
    record.addEventListener("click", () => this.ask(connection, { type: "record", on: record.getAttribute("aria-pressed") !== "true" }));
    find("save").addEventListener("click", () => this.ask(connection, { type: "save" }));
    const output = find("output");
    output.addEventListener("change", () => this.ask(connection, { type: "audio", device: output.value }));
    find("reportClose").addEventListener("click", () => { find("report").hidden = true; });
    find("again").addEventListener("click", () => {
      find("banner").hidden = true;
      connection.again();
    });
  }

  // result of compiling a version of the model
  /** @param {import("./protocol.js").ReportMessage} message */
  report({ ok, text }) {
    this.find("report").hidden = ok;
    this.find("reportText").textContent = ok ? "" : text;
    // error messages of a repaired model are removed
    if (ok) this.find("news").querySelectorAll(".bad").forEach(old => old.remove());
  }

  arm(connection, on) { return this.ask(connection, { type: "arm", on }); }

  /**
   * @param {import("./messages.js").Messages} connection
   * @param {import("./protocol.js").Request} request
   */
  async ask(connection, request) {
    const reply = await connection.ask(request);
    if (reply.ok === false) this.say(reply.text || "request refused", true);
  }

  // shows the state of the connection
  link(name, { tries = 0, text: why = "" } = {}) {
    if (name === "heavy" && this.find("banner").hidden === false) return;
    const dot = this.find("link"), banner = this.find("banner"), text = this.find("bannerText"), again = this.find("again");
    const told = { open: "connected", connecting: "connecting", lost: "connection lost", ended: "ended", failed: "stopped" }[name];
    if (told && (name !== "connecting" || tries === 0)) { dot.dataset.state = name; dot.setAttribute("aria-label", told); dot.title = told; }
    document.body.classList.toggle("away", name === "ended" || name === "lost" || name === "failed" || (name === "connecting" && tries > 0));
    if (name === "open") banner.hidden = true;
    else if (name === "heavy") {
      text.textContent = why;
      again.textContent = "Play at half the rate";
      again.hidden = banner.hidden = false;
    } else if (name === "failed") {
      text.textContent = why;
      again.hidden = true;
      banner.hidden = false;
    } else if (name === "ended") {
      text.textContent = "`ca play` has ended. The picture shows its last moment. To continue, run `ca play` again and open the new address.";
      again.hidden = true;
      banner.hidden = false;
    } else if (name === "lost" || tries > 0) {
      text.textContent = tries > 3
        ? "Lost connection to `ca play`. If it has stopped, run it again and open the new address."
        : "Connection lost. Trying again…";
      again.hidden = tries <= 3;
      banner.hidden = false;
    }
  }

  /** @param {import("./protocol.js").SceneMessage} message */
  scene(message) {
    this.find("title").textContent = message.title || message.model || "Untitled";
    this.find("model").textContent = message.model || "";
    document.title = (message.title || message.model || "Untitled") + " – ca";
    this.before = {};
    this.stability = message.stability;
  }

  /**
   * @param {import("./protocol.js").StateMessage} s
   * @param {import("./sound.js").Sound} sound
   */
  state(s, sound) {
    const load = Number.isFinite(s.load) ? s.load : 0, meter = this.find("load");
    meter.value = Math.min(1, load);
    this.find("loadText").textContent = `${Math.round(100 * load)} %`;
    const seconds = Math.max(0, s.seconds || 0), minutes = Math.floor(seconds / 60);
    this.find("clock").textContent = `${minutes}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
    const facts = [
      ["Load", `${Math.round(100 * load)} % of real time`, load > 0.85],
      ["Late", s.late ? count(s.late, "missed period") : "never", s.late > (this.before.late ?? s.late)],
      ["Lost", s.lost ? count(s.lost, "frame") : "none", s.lost > (this.before.lost ?? s.lost)],
      ["Clipped", s.clipped ? count(s.clipped, "sample") : "none", s.clipped > (this.before.clipped ?? s.clipped)],
      ["Sound", s.sound === "page" ? "this page" : s.sound ? `${s.sound}, ${(s.latency ?? 0).toFixed(1)} ms` : "–", false],
    ];
    if (sound.state === "on") facts.push(["This page", `latency ${Math.round(1000 * sound.latency)} ms, ${sound.gaps ? count(sound.gaps, "gap") : "no gaps"}`, false]);
    if (s.sound !== "page" && Number.isFinite(s.underruns)) facts.push(["Underruns", s.underruns ? String(s.underruns) : "none", s.underruns > (this.before.underruns ?? s.underruns)]);
    if (this.stability) facts.push(["Stability", this.stability, false]);
    const record = this.find("record");
    record.setAttribute("aria-pressed", String(!!s.recording));
    record.textContent = s.recording ? "Stop recording" : "Record sound";
    const arm = this.find("arm");
    arm.disabled = s.arms === false;
    arm.title = arm.disabled ? "Run `ca arm`, or restart with --allow-arm" : "";
    const save = this.find("save");
    save.disabled = s.keeps === false;
    if (save.disabled) save.title = "With devices, a take is recorded only if ca is started with --log TAKE";
    if (s.recording) facts.push(["Recording", s.recording, false]);
    if (s.clients > 1) facts.push(["Pages", `${s.clients} open`, false]);
    if (s.diverged) facts.unshift(["Model", "diverged: values out of range", true]);
    // lateness or loss colours the load for three seconds
    if (s.late > this.before.late || s.lost > this.before.lost) this.missed = performance.now();
    const missed = performance.now() - (this.missed ?? -1e9) < 3000, gauge = this.find("gauge");
    gauge.classList.toggle("bad", load > 0.95 || missed);
    const why = missed ? `Red: the computer was too busy; ${count(s.late || 0, "period")} missed so far. ` : "";
    if (gauge.title !== why + LOAD) gauge.title = why + LOAD;
    if (s.diverged && !this.before.diverged) this.say("The model diverged: its values are out of range. To restart it from the state at load, change a value in the model or save its file.", true);
    this.before = { late: s.late, lost: s.lost, clipped: s.clipped, underruns: s.underruns, diverged: s.diverged };
    const list = this.find("facts");
    if (list.children.length !== 2 * facts.length) list.replaceChildren(...facts.flatMap(() => [element("dt"), element("dd")]));
    facts.forEach(([name, text, bad], k) => {
      const dt = list.children[2 * k], dd = list.children[2 * k + 1];
      if (dt.textContent !== name) dt.textContent = name;
      if (dd.textContent !== text) dd.textContent = text;
      dd.classList.toggle("bad", bad);
    });
    this.devices(s.devices || []);
    this.outputs(s.outputs || {});
  }

  // lists the sound outputs, without disturbing a choice in progress
  outputs({ choices = [], wanted = "", busy = false }) {
    const output = this.find("output"), all = choices.includes(wanted) || !wanted ? choices : [wanted, ...choices];
    this.find("outputBox").hidden = choices.length === 0;
    const key = JSON.stringify(all);
    if (key !== this.offered) {
      this.offered = key;
      output.replaceChildren(...all.map(name => element("option", { value: name, text: name === "page" ? "this page" : name })));
      output.value = wanted;
    }
    output.disabled = busy;
    if (!busy && document.activeElement !== output || wanted !== this.wanted) output.value = wanted;
    this.wanted = wanted;
  }

  devices(list) {
    this.find("devicesBox").hidden = list.length === 0;
    const key = JSON.stringify(list);
    if (key === this.shown) return;
    this.shown = key;
    this.find("devices").replaceChildren(...list.map(d => element("div", { class: "device", "data-mode": d.mode },
      element("span", { class: "dot" }), element("strong", { text: d.name }), element("span", { text: d.mode + (d.cause && d.cause !== "NONE" ? `: ${d.cause}` : "") }))));
  }

  // shows a message; errors stay longer and can be closed
  say(text, bad = false) {
    const box = this.find("news");
    const close = element("button", { class: "close", "aria-label": "Close", text: "×" });
    const item = element("div", { class: "said" + (bad ? " bad" : "") }, element("span", { text }), close);
    const gone = () => item.remove();
    close.addEventListener("click", gone);
    for (const old of [...box.children]) if (old.firstChild.textContent === text) old.remove();
    box.append(item);
    while (box.children.length > 4) box.firstChild.remove();
    setTimeout(gone, bad ? 20000 : 6000);
  }
}
