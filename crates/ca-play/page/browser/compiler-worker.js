// The worker of the compiler.

import { ask } from "./wasm.js";

let wasm = null;

addEventListener("message", ({ data }) => {
  if (data.wasm) {
    wasm = new WebAssembly.Instance(new WebAssembly.Module(data.wasm)).exports;
    return;
  }
  const answer = ask(wasm, data.request, data.bytes);
  /** @type {any} */ (self).postMessage(answer, [answer.bytes.buffer]);
});
