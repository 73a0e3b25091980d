// Connects the parts: the connection feeds scene, motion, meters and sound; pointer and controls send requests. One
// loop draws at the screen rate, and only if something changed and the page is visible. Attributes of the root element
// count errors and frame costs, so that tests of the page can read them.

import { Connection } from "./socket.js";
import { Scene } from "./picture/scene.js";
import { Motion } from "./motion.js";
import { Camera } from "./picture/camera.js";
import { Picture } from "./picture/gl.js";
import { Pointer } from "./pointer.js";
import { Sound } from "./sound.js";
import { Meters } from "./meters.js";
import { Energy } from "./energy.js";
import { Parameters, ports, element } from "./controls.js";
import { Status } from "./status.js";
import { View } from "./view.js";
import { Gamepads } from "./gamepad.js";
import { Keyboard } from "./keyboard.js";
import { Presets } from "./presets.js";
import { EngineConnection } from "./browser/connection.js";
import { EngineSound } from "./browser/sound.js";
import { ModelText } from "./browser/text.js";
import { model } from "./browser/model.js";
import { parts } from "./browser/parts.js";
import { Sharing } from "./share.js";

/** @type {(id: string) => any} */
const find = id => document.getElementById(id);
const root = /** @type {any} */ (document.documentElement.dataset);
root.errors = root.violations = root.frames = 0;
addEventListener("error", () => root.errors++);
addEventListener("unhandledrejection", () => root.errors++);
addEventListener("securitypolicyviolation", () => root.violations++);

const canvas = find("canvas");
const camera = new Camera(), picture = new Picture(canvas);
/** @type {import("./protocol.js").StateMessage|null} */
let state = null;
/** @type {any} */
let scene = null, motion = null, pair = null;
let follow = (scene, pair) => {}, touched = false, instead = false;

const address = new URL("ws", location.href);
address.protocol = location.protocol === "https:" ? "wss:" : "ws:";

// without a server, the engine runs in this page
const here = document.documentElement.dataset.engine === "browser";

/** @type {import("./messages.js").Handlers} */
const handlers = {
  status(name, detail) {
    status.link(name, detail);
    if (name === "heavy") return;
    if (name !== "open") pointer.releaseAll(false);
    if (name === "open") sound.asked = false;
    pointer.enabled = name === "open";
  },
  scene: load,
  state(message) {
    const other = !state || state.sound !== message.sound, before = state && state.sound;
    state = message;
    if (other) showSound(sound);
    if (other && before) elsewhere(before, message.sound);
    status.state(message, sound);
    if (scene && pair) follow(scene, pair);
    parameters.update(message.params || {});
    parameters.bind(message.bound || [], message.learning);
    gesture(message.playing);
    root.tick = message.tick;
  },
  // a report of several lines has a separate place
  said: message => status.say(message.text.split("\n")[0], message.bad),
  report: message => status.report(message),
  energy: message => energy.push(message),
  view(generation, tick, floats) {
    if (scene && generation === scene.generation) motion.push(floats, tick / scene.message.rate, performance.now() / 1000);
  },
  sound(channels, tick, floats) {
    meters.push(channels, floats);
    sound.push(channels, floats);
  },
};
const local = here ? new EngineConnection(model(), parts(), handlers) : null;
const connection = local || new Connection(address, handlers);

const status = new Status(find, connection);
const parameters = new Parameters(find("params"), find("filter"), connection);
const keyboard = new Keyboard(find, {
  send: bytes => connection.send({ type: "midi", bytes }),
  say: (text, bad) => status.say(text, bad),
});
const gamepads = new Gamepads(keyboard, { send: bytes => connection.send({ type: "midi", bytes }), say: text => status.say(text, false) });
const presets = new Presets(find, { values: () => parameters.values(), set: values => parameters.set(values) });
const meters = new Meters(find("scope"), find("spectrum"), find("level"), find("decibels"), find("scopeScale"));
const energy = new Energy(find("energy"), find("energyScale"));
const view = new View(find, { picture, camera, meters, energy, scene: () => scene, motion: () => motion });
const sound = local ? new EngineSound(local, showSound) : new Sound({ send: m => connection.send(m), changed: showSound });
const say = (text, bad = false) => status.say(text, bad);
if (local) new ModelText(find, local, say);
else new Sharing(find, connection, say);
const pointer = new Pointer({
  canvas, camera,
  scene: () => scene,
  pair: () => pair || motion.still,
  send: m => connection.send(m),
  ask: m => connection.ask(m),
  held(masses) {
    picture.held = masses;
    if (motion) motion.frozen = masses.length > 0;
    find("stage").classList.toggle("holding", masses.length > 0);
    find("hint").classList.add("gone");
  },
  hover: (mass, x, y) => view.hover(mass, x, y, connection),
  refuse: (text, x, y) => view.refuse(text, x, y),
  turned: () => find("hint").classList.add("gone"),
});

/** @param {import("./protocol.js").SceneMessage} message */
function load(message) {
  const old = scene, before = motion;
  scene = new Scene(message);
  motion = new Motion(scene);
  if (old && Math.abs(old.extent / scene.extent - 1) < 0.3) motion.carry(before);
  pair = motion.still;
  pointer.releaseAll(false);
  picture.load(scene);
  pointer.show(-1);
  // an edited model keeps the view of the user, unless its size differs
  if (!old || !camera.touched || Math.abs(old.extent / scene.extent - 1) > 0.3) camera.fit(scene);
  else camera.depth = scene.extent;
  status.scene(message);
  parameters.build(message.params || []);
  keyboard.build(message.notes || null);
  presets.scene(message.model || message.title || "", message.presets || [], (message.params || []).length > 0);
  follow = ports(find("ports"), message.ports || [], connection);
  find("portsBox").hidden = (message.ports || []).length === 0;
  meters.setScene(message.rate, message.channels || []);
  view.channels(message.channels || []);
  find("energyBox").hidden = (message.energy || []).length === 0;
  energy.scene(message.energy || []);
  sound.scene(message.rate, Math.max(1, (message.channels || []).length));
  view.scene();
  setTimeout(() => find("hint").classList.add("gone"), 12000);
  canvas.setAttribute("aria-label", `The moving instrument: ${scene.n} masses`);
  if (scene.decimated) status.say(`The picture shows ${scene.decimated.shown} of ${scene.decimated.of} masses.`);
  root.generation = scene.generation;
  root.rate = scene.message.rate;
}

// the button plays the whole instrument from its beginning, with sound; while the gesture of the model plays, it ends
// it
let begun = false;
function gesture(playing) {
  const b = find("play"), text = playing ? "Stop" : begun ? "Play again" : "Play";
  b.dataset.on = String(!!playing);
  b.classList.toggle("primary", !playing);
  if (b.lastElementChild.textContent !== text) b.lastElementChild.textContent = text;
}

function stopOrPlay() {
  if (state && state.playing) {
    state.playing = false;
    connection.send({ type: "gesture", play: false });
    gesture(false);
  } else play();
}

async function play() {
  if (!scene) return;
  begun = true;
  gesture(false);
  // the beginning should be audible, but a browser without sound must not block it
  if (!state || !state.sound || state.sound === "page") await Promise.race([sound.start(), new Promise(done => setTimeout(done, 1000))]);
  const reply = await connection.ask({ type: "play" });
  if (reply.ok === false) status.say(reply.text, true);
}

function showSound(s) {
  const b = find("sound"), on = s.state === "on";
  b.dataset.on = String(on);
  const elsewhere = !!(state && state.sound && state.sound !== "page");
  b.querySelector("span").textContent = on ? "Sound off" : s.state === "starting" ? "Starting…" : elsewhere ? "Also play here" : "Sound on";
  find("loudness").classList.toggle("off", !on);
  const mute = find("mute");
  mute.setAttribute("aria-pressed", String(s.muted));
  mute.textContent = s.muted ? "Muted" : "Mute";
  find("volume").style.setProperty("--fill", 100 * s.volume + "%");
  if (s.state === "failed" && root.sound !== "failed") status.say("No sound in this page: " + s.reason, true);
  root.sound = s.state;
  root.gaps = s.gaps;
  root.ahead = s.ahead;
}

// if a sound device disappears, this page plays until it returns; browsers require a user gesture first
function elsewhere(before, now) {
  if (now === "page" && before !== "page" && touched && sound.state === "off") {
    instead = true;
    sound.start();
  } else if (now !== "page" && instead) {
    instead = false;
    sound.stop();
  }
}

// sound starts with the first gesture if the page plays it; buttons handle their own press
function firstGesture(event) {
  if (event.target.closest && event.target.closest("#play, #sound, #stop, #mute")) return done();
  if (event.type === "keydown" && /^(Tab|Shift|Control|Alt|Meta|Escape|s|m|r| )$/.test(event.key)) return;
  done();
  if (sound.state === "off" && (!state || !state.sound || state.sound === "page")) sound.start();
  function done() {
    touched = true;
    removeEventListener("pointerup", firstGesture, true);
    removeEventListener("keydown", firstGesture, true);
  }
}
addEventListener("pointerup", firstGesture, true);
addEventListener("keydown", firstGesture, true);

find("changeForm").addEventListener("submit", async event => {
  event.preventDefault();
  const [name, value] = ["changeName", "changeValue"].map(id => find(id).value.trim());
  const reply = await connection.ask({ type: "change", name, value });
  if (reply.ok === false) status.say(reply.text, true);
});
for (const id of ["changeName", "changeValue"]) find(id).addEventListener("keydown", e => e.stopPropagation());
find("play").addEventListener("click", stopOrPlay);
find("sound").addEventListener("click", () => sound.toggle());
find("mute").addEventListener("click", () => sound.mute());
find("volume").addEventListener("input", e => sound.setVolume(+find("volume").value));
const reset = () => { if (scene) camera.fit(scene, pair); };
find("reset").addEventListener("click", reset);
find("nearer").addEventListener("click", () => camera.zoom(0.8));
find("farther").addEventListener("click", () => camera.zoom(1.25));

addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
  const on = /** @type {Element} */ (event.target), typing = on.matches("input[type=text], input[type=search], textarea, select");
  if (typing) return;
  if (event.key === " " && !on.matches("button, summary, input[type=checkbox], input[type=radio]")) stopOrPlay();
  else if (event.key === "s") sound.toggle();
  else if (event.key === "m") sound.mute();
  else if (event.key === "0") reset();
  else if (event.key === "r") play();
  else if (event.key === "Escape") { pointer.releaseAll(); pointer.show(-1); }
  else return;
  event.preventDefault();
});

const resized = new ResizeObserver(() => {
  const w = canvas.clientWidth, h = canvas.clientHeight, ratio = Math.min(2, devicePixelRatio || 1);
  if (!w || !h) return;
  picture.ratio = ratio;
  canvas.width = Math.round(w * ratio);
  canvas.height = Math.round(h * ratio);
  camera.resize(w, h);
  if (scene && !camera.touched) camera.fit(scene);
});
resized.observe(canvas);

// script time of a frame [ms]: median and maximum over a second
const costs = [];
let since = performance.now();
function frame(at) {
  requestAnimationFrame(frame);
  if (!scene) return;
  const began = performance.now(), now = began / 1000;
  pair = motion.at(now);
  motion.exaggerate(now);
  pointer.frame();
  gamepads.frame();
  picture.draw(camera, pair, motion);
  view.frame(pointer, pair, now);
  meters.draw(at);
  energy.draw(at);
  const ms = performance.now() - began;
  costs.push(ms);
  root.frames = +root.frames + 1;
  if (began - since > 1000) {
    root.fps = (1000 * costs.length / (began - since)).toFixed(1);
    costs.sort((a, b) => a - b);
    root.scriptMs = costs[costs.length >> 1].toFixed(2);
    root.worstMs = costs[costs.length - 1].toFixed(2);
    costs.length = 0;
    since = began;
  }
}

if (!picture.gl) {
  find("stage").append(element("p", { class: "none", text: "WebGL2 is not available in this browser, so the picture is missing. Sound, parameters and meters work." }));
}
showSound(sound);
connection.connect();
requestAnimationFrame(frame);
