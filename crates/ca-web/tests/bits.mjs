// Plays one second of each model of a folder by the WebAssembly modules, and writes the samples.
// node bits.mjs MODULES MODELS OUT
import fs from "node:fs";

const [modules, models, out] = process.argv.slice(2);
const load = name => new WebAssembly.Module(fs.readFileSync(`${modules}/${name}.wasm`));
const compiler = new WebAssembly.Instance(load("compiler")).exports, engineModule = load("engine");
const encoder = new TextEncoder();

function give(wasm, bytes) {
  const place = wasm.ca_room(bytes.length);
  new Uint8Array(wasm.memory.buffer, place, bytes.length).set(bytes);
}

function framed(text, bytes = new Uint8Array()) {
  const all = new Uint8Array(4 + text.length + bytes.length);
  new DataView(all.buffer).setUint32(0, text.length, true);
  all.set(text, 4);
  all.set(bytes, 4 + text.length);
  return all;
}

for (const file of fs.readdirSync(models).filter(name => name.endsWith(".ca.toml"))) {
  const text = fs.readFileSync(`${models}/${file}`, "utf8");
  give(compiler, framed(encoder.encode(JSON.stringify({ type: "compile", file, text }))));
  const length = compiler.ca_answer(), all = new Uint8Array(compiler.memory.buffer, compiler.ca_at(), length).slice();
  const head = new DataView(all.buffer).getUint32(0, true), answer = JSON.parse(new TextDecoder().decode(all.subarray(4, 4 + head)));
  if (!answer.ok) throw new Error(`${file}: ${answer.text}`);
  if (file === "kalimba.ca.toml") {
    // the renderer too: the bytes of the command
    give(compiler, framed(encoder.encode(JSON.stringify({ type: "render", file, text, seconds: 0.5 }))));
    const length = compiler.ca_answer(), made = new Uint8Array(compiler.memory.buffer, compiler.ca_at(), length).slice();
    fs.writeFileSync(`${out}/kalimba.wav`, made.subarray(4 + new DataView(made.buffer).getUint32(0, true)));
  }
  const wasm = new WebAssembly.Instance(engineModule).exports;
  give(wasm, framed(encoder.encode(JSON.stringify(answer.facts)), all.subarray(4 + head)));
  if (wasm.ca_open() > 0) throw new Error(`${file} cannot be opened`);
  give(wasm, encoder.encode(JSON.stringify({ type: "gesture", play: true })));
  wasm.ca_request();
  const frames = Math.ceil(wasm.ca_rate() / wasm.ca_frame()), blocks = [];
  const began = performance.now();
  for (let frame = 0; frame < frames; frame++) {
    const n = wasm.ca_play(1);
    blocks.push(Buffer.from(wasm.memory.buffer, wasm.ca_sound_at(), 4 * n).subarray().toString("latin1"));
    while (wasm.ca_next() > 0);
  }
  if (process.env.CA_TIMES) console.log(`${file} ${(performance.now() - began).toFixed(1)} ms`);
  fs.writeFileSync(`${out}/${file}`, Buffer.from(blocks.join(""), "latin1"));
}
