// Renders and checks models, in Node and in browsers.

export { pack } from "./model.js";

let compiler = null;

async function load() {
  const at = new URL("compiler.wasm", import.meta.url);
  const bytes = at.protocol === "file:" ? await (await import("node:fs/promises")).readFile(at) : await (await fetch(at)).arrayBuffer();
  return (await WebAssembly.instantiate(bytes)).instance.exports;
}

async function ask(request) {
  const wasm = await (compiler ??= load()), text = new TextEncoder().encode(JSON.stringify(request));
  const place = wasm.ca_room(4 + text.length);
  new DataView(wasm.memory.buffer).setUint32(place, text.length, true);
  new Uint8Array(wasm.memory.buffer).set(text, place + 4);
  const length = wasm.ca_answer(), at = wasm.ca_at();
  const head = new DataView(wasm.memory.buffer).getUint32(at, true), all = new Uint8Array(wasm.memory.buffer, at, length);
  const answer = JSON.parse(new TextDecoder().decode(all.subarray(4, 4 + head)));
  if (!answer.ok) throw new Error(answer.text);
  return { ...answer, bytes: all.slice(4 + head) };
}

export async function render(text, { seconds, file = "model.ca.toml", files = {}, changes = {} } = {}) {
  const made = await ask({ type: "render", file, text, files, changes: Object.entries(changes), seconds });
  return { wav: made.bytes, rate: made.rate, channels: made.channels, frames: made.frames };
}

export async function check(text, { file = "model.ca.toml", files = {}, changes = {} } = {}) {
  const made = await ask({ type: "check", file, text, files, changes: Object.entries(changes) });
  return { text: made.text, findings: made.findings, stability: made.stability, masses: made.masses, links: made.links };
}
