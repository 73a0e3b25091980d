// The worker of the compiler: a request is a JSON object and bytes, and so is its answer (crates/ca-web/src/exports.rs).

let wasm = null;

addEventListener("message", ({ data }) => {
  if (data.wasm) {
    wasm = new WebAssembly.Instance(new WebAssembly.Module(data.wasm)).exports;
    return;
  }
  const text = new TextEncoder().encode(JSON.stringify(data.request)), n = text.length;
  const place = wasm.ca_room(4 + n + data.bytes.length), memory = new Uint8Array(wasm.memory.buffer);
  new DataView(wasm.memory.buffer).setUint32(place, n, true);
  memory.set(text, place + 4);
  memory.set(data.bytes, place + 4 + n);
  const length = wasm.ca_answer(), at = wasm.ca_at();
  const all = new Uint8Array(wasm.memory.buffer, at, length), head = new DataView(wasm.memory.buffer).getUint32(at, true);
  const object = JSON.parse(new TextDecoder().decode(all.subarray(4, 4 + head))), bytes = all.slice(4 + head);
  /** @type {any} */ (self).postMessage({ object, bytes }, [bytes.buffer]);
});
