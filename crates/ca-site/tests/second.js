// One second of a model by the WebAssembly modules, in Node and in a browser; beside `wasm.js` of the package.

import { ask, framed, give } from "./wasm.js";

export function second(compiler, engine, file, text) {
  const { object, bytes } = ask(compiler, { type: "compile", file, text });
  if (!object.ok) throw new Error(object.text);
  const wasm = new WebAssembly.Instance(engine).exports;
  give(wasm, framed(object.facts, bytes));
  if (wasm.ca_open() > 0) throw new Error("the plan cannot be opened");
  give(wasm, new TextEncoder().encode('{"type": "gesture", "play": true}'));
  wasm.ca_request();
  const frames = Math.ceil(wasm.ca_rate() / wasm.ca_frame()), blocks = [], began = performance.now();
  for (let frame = 0; frame < frames; frame++) {
    const length = wasm.ca_play(1);
    blocks.push(new Uint32Array(wasm.memory.buffer, wasm.ca_sound_at(), length).slice());
    while (wasm.ca_next() > 0);
  }
  const ms = performance.now() - began;
  let samples = 0, hash = 0x811c9dc5;
  for (const block of blocks) {
    samples += block.length;
    for (const word of block) hash = Math.imul(hash ^ word, 0x01000193);
  }
  return { samples, hash: hash >>> 0, ms };
}
