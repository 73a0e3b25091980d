// The worker of the compiler, and of the module that measures.

import { ask, imports } from "./wasm.js";

let wasm = null, told = -1;

// a message for each finished step
function progress(done, of) {
  if (done === told) return;
  told = done;
  postMessage({ progress: { done, of } });
}

addEventListener("message", ({ data }) => {
  if (data.wasm) {
    wasm = new WebAssembly.Instance(new WebAssembly.Module(data.wasm), imports(progress)).exports;
    return;
  }
  told = -1;
  const answer = ask(wasm, data.request, data.bytes);
  /** @type {any} */ (self).postMessage(answer, [answer.bytes.buffer]);
});
