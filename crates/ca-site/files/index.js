// Renders, checks, tunes and measures models, in Node and in browsers.

import { ask, imports } from "./wasm.js";

export { pack } from "./model.js";

let compiler = null;

async function load(name, progress) {
  const at = new URL(name, import.meta.url);
  const bytes = at.protocol === "file:" ? await (await import("node:fs/promises")).readFile(at) : await (await fetch(at)).arrayBuffer();
  return (await WebAssembly.instantiate(bytes, imports(progress))).instance.exports;
}

async function made(request, wasm = compiler ??= load("compiler.wasm")) {
  const { object, bytes } = ask(await wasm, request);
  if (!object.ok) throw new Error(object.text);
  return { ...object, bytes };
}

export async function render(text, { seconds, file = "model.ca.toml", files = {}, changes = {} } = {}) {
  const all = await made({ type: "render", file, text, files, changes: Object.entries(changes), seconds });
  return { wav: all.bytes, rate: all.rate, channels: all.channels, frames: all.frames };
}

export async function modes(text, { file = "model.ca.toml", files = {}, changes = {} } = {}) {
  const { ok, bytes, ...all } = await made({ type: "modes", file, text, files, changes: Object.entries(changes) });
  return all;
}

export async function tune(text, parts, { file = "model.ca.toml", files = {}, scale, root, a4, mode } = {}) {
  const all = await made({ type: "tune", file, text, files, parts: [parts].flat(), scale, root, a4, mode });
  return { text: all.text, name: all.name, tuned: all.tuned };
}

export async function accuracy(text, { file = "model.ca.toml", files = {}, changes = {}, seconds, times, reference, probes, error, progress = () => true } = {}) {
  const request = { type: "accuracy", file, text, files, changes: Object.entries(changes), seconds, times, reference, probes, error };
  const { ok, bytes, ...all } = await made(request, load("accuracy.wasm", progress));
  return { ...all, page: new TextDecoder().decode(bytes) };
}

export async function check(text, { file = "model.ca.toml", files = {}, changes = {} } = {}) {
  const all = await made({ type: "check", file, text, files, changes: Object.entries(changes) });
  return { text: all.text, findings: all.findings, stability: all.stability, masses: all.masses, links: all.links };
}
