// Overlay and settings of the picture: colours, exaggeration, theme, legend, tooltip of a mass, line from a held mass
// to the pointer, and refusals to hold a mass. The tooltip appears after the pointer has rested on a mass for a moment.
// The theme follows the system until the user chooses one.

import { Slider, element } from "./controls.js";
import { format, plain } from "./units.js";
import { legend, kindColour } from "./picture/colour.js";

const STAY = 140;

function remembered(name, value) {
  try {
    if (value === undefined) return localStorage.getItem("ca-play-" + name);
    localStorage.setItem("ca-play-" + name, value);
  } catch { /* storage is forbidden: the choice lasts as long as the page */ }
  return null;
}

const times = f => "× " + (f >= 1e5 || f < 0.01 ? f.toExponential(1).replace("e+", "e") : plain(f, f < 10 ? 2 : 3));

export class View {
  constructor(find, world) {
    this.find = find;
    this.world = world;
    this.line = this.space = null;
    this.told = null;
    const dark = matchMedia("(prefers-color-scheme: light)");
    const choose = () => this.theme(remembered("theme") || (dark.matches ? "light" : "dark"));
    dark.addEventListener("change", choose);
    choose();
    find("theme").addEventListener("click", () => {
      const next = world.picture.theme === "dark" ? "light" : "dark";
      remembered("theme", next);
      this.theme(next);
    });
    for (const input of find("colours").querySelectorAll("input")) {
      input.addEventListener("change", () => { world.picture.mode = +input.value; remembered("colour", input.value); this.legend(); });
      if (input.value === remembered("colour")) { input.checked = true; world.picture.mode = +input.value; }
    }
    find("contacts").addEventListener("change", e => { world.picture.contacts = e.target.checked; this.legend(); });
  }

  theme(name) {
    document.documentElement.dataset.theme = name;
    this.world.picture.setTheme(name);
    this.world.meters.setTheme();
    this.world.energy.setTheme();
    this.legend();
  }

  // creates the sliders that this scene needs
  scene() {
    const scene = this.world.scene(), motion = this.world.motion(), box = this.find("factors");
    this.find("contactsRow").hidden = !scene.links.some(l => l.contact);
    box.replaceChildren();
    this.line = this.space = null;
    if (scene.linear) {
      const spec = { name: "exaggeration", label: "Exaggeration", value: 1, min: 0.1, max: 1e6, unit: "", noBack: true, plainText: times };
      this.line = new Slider(spec, value => {
        const factor = typeof value === "number" ? value : parseFloat(String(value).replace(/[^0-9.e+-]/gi, ""));
        if (!(factor > 0)) return { ok: false, text: "enter a number above zero" };
        motion.setLine(factor);
        this.auto.checked = false;
        return { ok: true };
      });
      this.line.field.setAttribute("aria-label", "Exaggeration of motion, value");
      this.auto = element("input", { type: "checkbox", id: "auto" });
      this.auto.checked = motion.auto;
      this.auto.addEventListener("change", () => motion.setLine(this.auto.checked ? null : scene.line));
      this.line.row.querySelector(".head").insertBefore(element("label", { class: "check small" }, this.auto, element("span", { text: "auto" })), this.line.field);
      this.line.update(scene.line);
      box.append(this.line.row);
    }
    if (scene.spatial) {
      const spec = { name: "exaggeration in space", label: scene.linear ? "Exaggeration in space" : "Exaggeration", value: 1, min: 0.1, max: 1000, unit: "", plainText: times };
      this.space = new Slider(spec, value => {
        const factor = typeof value === "number" ? value : parseFloat(String(value).replace(/[^0-9.e+-]/gi, ""));
        if (!(factor > 0)) return { ok: false, text: "enter a number above zero" };
        scene.true = factor;
        this.space.update(factor);
        return { ok: true };
      });
      this.space.update(scene.true);
      box.append(this.space.row);
    }
    this.told = null;
    this.find("tooltip").hidden = true;
    this.legend();
  }

  // shows the names of the outputs in the colours of their traces
  channels(names) {
    const few = names.length > 1 ? names.slice(0, 4) : [];
    this.find("channels").replaceChildren(...few.map((name, k) => element("span", { class: "trace" + k, text: name })));
  }

  legend() {
    const { picture } = this.world, scene = this.world.scene(), find = this.find;
    if (!scene) return;
    const kinds = picture.mode === 2, box = find("swatches");
    find("ramp").hidden = kinds;
    box.hidden = !kinds;
    if (!kinds) {
      const signed = picture.mode === 1 && scene.linear;
      legend(find("bar"), picture.theme, signed ? 1 : 0);
      return;
    }
    const used = new Set(scene.kind), item = (name, i) => {
      const dot = element("i");
      dot.style.background = `rgb(${kindColour(picture.theme, i).join(",")})`;
      return element("span", {}, dot, name);
    };
    const links = scene.links.map((l, k) => [l, k]).filter(([l]) => !l.contact || picture.contacts);
    box.replaceChildren(...[...used].map(k => item(scene.kinds[k] || "?", k)), ...links.map(([l, k]) => item(l.kind, k + scene.kinds.length)));
  }

  /**
   * @param {number} mass
   * @param {number} x
   * @param {number} y
   * @param {import("./messages.js").Messages} connection
   */
  hover(mass, x, y, connection) {
    const { picture } = this.world;
    picture.hover = mass;
    clearTimeout(this.timer);
    const tip = this.find("tooltip");
    tip.hidden = true;
    this.told = null;
    this.find("stage").classList.toggle("over", mass >= 0);
    if (mass < 0) return;
    this.timer = setTimeout(async () => {
      const reply = await connection.ask({ type: "pick", mass });
      if (picture.hover !== mass || reply.ok === false) return;
      tip.replaceChildren(
        element("p", {}, element("strong", { text: reply.name || `mass ${mass}` }), element("span", { class: "kind", text: reply.kind || "" })),
        element("dl", {}, element("dt", { text: "displacement" }), element("dd", { class: "live" })));
      tip.hidden = false;
      this.told = mass;
    }, STAY);
  }

  refuse(text, x, y) {
    const box = this.find("refusal"), stage = this.find("stage");
    this.find("tooltip").hidden = true;
    box.textContent = text;
    box.hidden = false;
    const w = Math.min(box.offsetWidth, stage.clientWidth - 16);
    box.style.left = Math.max(8, Math.min(stage.clientWidth - w - 8, x - w / 2)) + "px";
    box.style.top = Math.max(8, y - box.offsetHeight - 18) + "px";
    clearTimeout(this.refusal);
    this.refusal = setTimeout(() => { box.hidden = true; }, 2600);
  }

  // the line from a held mass to the pointer, with both ends
  pull() {
    const make = (name, r) => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", name);
      if (r) made.setAttribute("r", r);
      return made;
    };
    const pull = make("g");
    pull.append(make("line"), make("circle", 3), make("circle", 9));
    return pull;
  }

  // updates what follows the motion, once per frame
  frame(pointer, pair, now) {
    const { camera, motion, picture } = this.world, scene = this.world.scene(), find = this.find, p = this.p || (this.p = new Float64Array(6));
    const overlay = find("overlay");
    overlay.classList.toggle("on", pointer.grips.size > 0);
    for (const pull of overlay.children) pull.classList.add("off");
    for (const grip of pointer.grips.values()) {
      scene.place(grip.mass, pair, p, 0);
      camera.project(p, 0, p, 3);
      while (overlay.children.length <= grip.finger) overlay.append(this.pull());
      const pull = overlay.children[grip.finger];
      const [line, held, finger] = pull.children, [x1, y1, x2, y2] = [p[3], p[4], grip.x, grip.y].map(v => v.toFixed(1));
      pull.classList.remove("off");
      for (const [name, value] of Object.entries({ x1, y1, x2, y2 })) line.setAttribute(name, value);
      held.setAttribute("cx", x1); held.setAttribute("cy", y1);
      finger.setAttribute("cx", x2); finger.setAttribute("cy", y2);
    }
    if (this.told !== null && this.told < scene.n) this.follow(pair, p);
    if (now - (this.slow || 0) < 0.2) return;
    this.slow = now;
    if (this.line && motion().auto) this.line.update(scene.line);
    const note = scene.linear ? `motion ${times(scene.line)}` : scene.true !== 1 ? `motion ${times(scene.true)}` : "";
    this.text("scaleNote", note);
    const m = motion();
    if (picture.mode === 0) { this.text("low", "still"); this.text("high", m.speed > 0 && !scene.linear ? format(m.speed, "m/s", 2) : "fast"); }
    else if (picture.mode === 1) {
      const far = m.far > 0 ? format(m.far, "m", 2) : "";
      this.text("low", scene.linear ? "−" + far : "at rest");
      this.text("high", scene.linear ? "+" + far : far);
    }
  }

  text(id, text) {
    const e = this.find(id);
    if (e.textContent !== text) e.textContent = text;
  }

  follow(pair, p) {
    const scene = this.world.scene(), tip = this.find("tooltip"), stage = this.find("stage");
    scene.place(this.told, pair, p, 0);
    this.world.camera.project(p, 0, p, 3);
    const o = scene.offset[this.told], now = k => pair.a[o + k] + (pair.b[o + k] - pair.a[o + k]) * pair.mix;
    const live = tip.querySelector(".live");
    if (live) live.textContent = scene.space[this.told] ? format(Math.hypot(now(0), now(1), now(2)), "m", 3) : format(now(0), "m", 3).replace("-", "−");
    const w = tip.offsetWidth, h = tip.offsetHeight;
    const x = p[3] + 18 + w > stage.clientWidth - 8 ? p[3] - 18 - w : p[3] + 18;
    tip.style.transform = `translate(${Math.max(8, Math.min(stage.clientWidth - w - 8, x)).toFixed(1)}px, ${Math.max(8, Math.min(stage.clientHeight - h - 8, p[4] - h / 2)).toFixed(1)}px)`;
  }
}
