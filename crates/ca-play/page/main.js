// The page: what comes over the line goes to the picture, to the ears and to the panel, and what hands do goes back.

import { Socket } from "./socket.js";
import { Camera, Scene } from "./scene.js";
import { Picture } from "./gl.js";
import { Hand } from "./pointer.js";
import { Sound } from "./sound.js";
import { Meters } from "./meters.js";
import { slider, tidy } from "./controls.js";

const $ = (id) => document.getElementById(id);
const canvas = $("view");
const picture = new Picture(canvas);
const host = { scene: null, camera: null, gain, pointed, touched, refused };
let state = {}, params = {}, manual = 1, tipUntil = 0, where = [0, 0], busy = 0;

const socket = new Socket({
  line: (how) => {
    const words = { open: "", lost: "The line to the engine is lost. Trying again…", ended: "The engine has ended." };
    $("banner").textContent = words[how];
    $("banner").hidden = how === "open";
    if (how !== "open") hand.release();
    else if (sound.on) sound.again();
  },
  scene: load,
  state: news,
  said: ({ bad, text }) => say(text, bad),
  view: (generation, tick, x) => generation === host.scene?.generation && host.scene.view(tick, x, performance.now()),
  heard: (channels, _, samples) => sound.heard(channels, samples),
});
const sound = new Sound(socket);
const meters = new Meters($("scope"), $("spectrum"), sound);
const hand = new Hand(canvas, socket, host);

function load(message) {
  const { drawing } = message;
  host.scene = new Scene(drawing, message.generation);
  host.camera = new Camera(host.scene);
  picture.load(host.scene);
  $("title").textContent = message.title || message.model;
  document.title = `${message.model} – ca play`;
  const links = drawing.links.reduce((n, l) => n + l.ends.length / 2, 0);
  const part = drawing.decimated ? `, ${drawing.decimated.shown} of ${drawing.decimated.of} shown` : "";
  $("facts").textContent = `${drawing.masses} masses, ${links} links${part}, ${message.rate / 1000} kHz. Drag a mass to pull it.`;
  $("sound").hidden = !message.channels.length;
  $("gesture").hidden = !message.gesture;
  params = rows($("params"), message.params, (p) => (v) => socket.ask({ type: "set", values: { [p.name]: v } }));
  const ports = message.ports.filter((p) => p.role !== "device");
  const span = (p) => (p.role === "force" ? 10 : Math.max(0.01, 2 * Math.abs(p.rest)));
  const port = (p) => ({ ...p, value: p.rest, min: p.rest - span(p), max: p.rest + span(p), unit: p.role === "force" ? "N" : "m" });
  rows($("ports"), ports.map(port), (p) => (v) => socket.ask({ type: "port", name: p.name, value: Number.parseFloat(v) }));
  sound.scene(message.channels.length, message.rate);
}

function rows(section, list, send) {
  section.hidden = !list.length;
  const made = list.map((p) => [p.name, slider(p, send(p), refused)]);
  section.querySelector(".rows").replaceChildren(...made.map(([, s]) => s.row));
  return Object.fromEntries(made);
}

function news(message) {
  state = message;
  for (const [name, value] of Object.entries(message.params)) params[name]?.show(value);
  pressed($("gesture"), message.playing);
  $("gesture").textContent = message.playing ? "Stop" : "Play";
  $("devices").hidden = !message.devices.length;
  const device = ({ name, mode, cause }) => item("li", `${name}: ${mode}${cause === "NONE" ? "" : ` (${cause})`}`);
  $("devices").querySelector("ul").replaceChildren(...message.devices.map(device));
  const facts = [
    ["time", `${message.seconds.toFixed(1)} s`],
    ["computing", message.load == null ? "…" : `${(100 * message.load).toFixed(1)} %`, message.load > 0.8],
    ["late periods", message.late, message.late > 0],
    ["lost", message.lost, message.lost > 0],
    ["clipped samples", message.clipped, message.clipped > 0],
    ["sound", sound.on ? `page, ${(1000 * sound.latency()).toFixed(0)} ms` : message.sound === "page" ? "off" : message.sound],
    ["pages open", message.clients],
    ["drawing", `${busy.toFixed(1)} ms`],
  ];
  $("state").replaceChildren(...facts.flatMap(([name, value, bad]) => [item("dt", name), item("dd", value, bad && "bad")]));
  if (message.diverged) {
    $("banner").hidden = false;
    $("banner").textContent = "The model has diverged: it is silent. Start it again.";
  }
}

function item(kind, text, name) {
  const made = document.createElement(kind);
  made.textContent = text;
  if (name) made.className = name;
  return made;
}

function say(text, bad) {
  const list = $("news");
  list.prepend(item("li", text, bad ? "bad" : ""));
  while (list.children.length > 50) list.lastChild.remove();
}

function refused(text) {
  tip(text, true);
  tipUntil = performance.now() + 2500;
}

function tip(text, bad) {
  const at = $("tip");
  at.textContent = text;
  at.hidden = !text;
  at.classList.toggle("bad", Boolean(bad));
  const x = Math.min(where[0] + 14, canvas.clientWidth - at.offsetWidth - 8);
  at.style.left = `${Math.max(8, x)}px`;
  at.style.top = `${Math.min(where[1] + 14, canvas.clientHeight - at.offsetHeight - 8)}px`;
}

async function pointed(mass) {
  if (performance.now() < tipUntil) return;
  if (mass < 0) return tip("");
  const answer = await socket.ask({ type: "pick", mass });
  if (hand.marked === mass && performance.now() >= tipUntil) tip(answer.ok ? `${answer.name} (${answer.kind})` : answer.text);
}

function touched() {
  // a browser lets a page sound once somebody has touched it
  if (!sound.on && !touched.once) toggleSound();
  touched.once = true;
}

async function toggleSound() {
  pressed($("sound"), await sound.toggle());
}

function pressed(button, on) {
  button.setAttribute("aria-pressed", on ? "true" : "false");
}

function play() {
  socket.ask({ type: "gesture", play: !state.playing }).then((a) => a.ok || refused(a.text));
  touched();
}

function gain() {
  return $("auto").checked ? host.scene?.shown || 1 : manual;
}

function theme() {
  const chosen = $("theme").value;
  if (chosen) document.documentElement.dataset.theme = chosen;
  else delete document.documentElement.dataset.theme;
  const light = chosen ? chosen === "light" : matchMedia("(prefers-color-scheme: light)").matches;
  picture.wear(light ? "light" : "dark");
}

canvas.addEventListener("pointermove", (e) => (where = [e.offsetX, e.offsetY]));
$("sound").onclick = () => ((touched.once = true), toggleSound());
$("gesture").onclick = play;
$("home").onclick = () => host.camera?.reset();
$("arm").onclick = () => socket.ask({ type: "arm", on: true }).then((a) => say(a.text, !a.ok));
$("disarm").onclick = () => socket.ask({ type: "arm", on: false }).then((a) => say(a.text, !a.ok));
$("theme").onchange = theme;
matchMedia("(prefers-color-scheme: light)").addEventListener("change", theme);
$("gain").oninput = () => {
  $("auto").checked = false;
  manual = Math.pow(10, Number($("gain").value));
};
document.addEventListener("keydown", (e) => {
  if (e.target.matches("input, select, textarea") || e.ctrlKey || e.metaKey || e.altKey) return;
  const key = e.key.toLowerCase();
  if (key === " " && !e.target.matches("button") && !$("gesture").hidden) play();
  else if (key === "s") $("sound").click();
  else if (key === "0") host.camera?.reset();
  else if (key === "arrowleft" || key === "arrowright") host.camera?.orbit(key === "arrowleft" ? 20 : -20, 0);
  else if (key === "+" || key === "-") host.camera?.scale(key === "+" ? 1.15 : 1 / 1.15);
  else return;
  e.preventDefault();
});

let frames = 0;
function frame(now) {
  requestAnimationFrame(frame);
  const begin = performance.now();
  if (host.scene) {
    const { scene, camera } = host;
    if ($("auto").checked && !hand.held) scene.automatic();
    scene.update(now, gain(), $("colour").value);
    picture.draw({ camera, marked: hand.marked, contacts: $("contacts").checked, pulled: hand.held });
    if (frames % 12 === 0) {
      $("gain-value").textContent = scene.space.every((s) => s) ? "true" : `× ${tidy(gain())}`;
      if ($("auto").checked) $("gain").value = Math.log10(gain());
    }
  }
  busy += 0.1 * (performance.now() - begin - busy);
  if (frames++ % 6 === 0) meters.draw();
}
theme();
if (!picture.gl) {
  $("banner").hidden = false;
  $("banner").textContent = "This browser has no WebGL2: no picture; sound and controls work.";
}
requestAnimationFrame(frame);
