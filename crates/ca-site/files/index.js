// Renders and checks models, in Node and in browsers.

import { ask } from "./wasm.js";

export { pack } from "./model.js";

let compiler = null;

async function load() {
  const at = new URL("compiler.wasm", import.meta.url);
  const bytes = at.protocol === "file:" ? await (await import("node:fs/promises")).readFile(at) : await (await fetch(at)).arrayBuffer();
  return (await WebAssembly.instantiate(bytes)).instance.exports;
}

async function made(request) {
  const { object, bytes } = ask(await (compiler ??= load()), request);
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

export async function check(text, { file = "model.ca.toml", files = {}, changes = {} } = {}) {
  const all = await made({ type: "check", file, text, files, changes: Object.entries(changes) });
  return { text: all.text, findings: all.findings, stability: all.stability, masses: all.masses, links: all.links };
}
