// Calls of the WebAssembly modules (crates/ca-web/src/exports.rs).

// the imports of the module that measures: a clock, and the progress of its work, which ends if the answer is `false`
export function imports(progress) {
  return { ca: { now: () => performance.now(), progress: (done, of) => Number(progress(done, of) !== false) } };
}

// writes a request into the memory of a module
export function give(wasm, bytes) {
  const place = wasm.ca_room(bytes.length);
  new Uint8Array(wasm.memory.buffer, place, bytes.length).set(bytes);
}

// a request of an object and bytes
export function framed(object, bytes = new Uint8Array()) {
  const text = new TextEncoder().encode(JSON.stringify(object)), all = new Uint8Array(4 + text.length + bytes.length);
  new DataView(all.buffer).setUint32(0, text.length, true);
  all.set(text, 4);
  all.set(bytes, 4 + text.length);
  return all;
}

// asks a module, and returns the object and the bytes of its answer
export function ask(wasm, request, bytes) {
  give(wasm, framed(request, bytes));
  const length = wasm.ca_answer(), all = new Uint8Array(wasm.memory.buffer, wasm.ca_at(), length);
  const end = 4 + new DataView(wasm.memory.buffer, all.byteOffset).getUint32(0, true);
  return { object: JSON.parse(new TextDecoder().decode(all.subarray(4, end))), bytes: all.slice(end) };
}
