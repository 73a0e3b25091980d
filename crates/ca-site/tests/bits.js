async model => {
  const encoder = new TextEncoder();
  const give = (wasm, bytes) => {
    const place = wasm.ca_room(bytes.length);
    new Uint8Array(wasm.memory.buffer, place, bytes.length).set(bytes);
  };
  const framed = (text, bytes = new Uint8Array()) => {
    const all = new Uint8Array(4 + text.length + bytes.length);
    new DataView(all.buffer).setUint32(0, text.length, true);
    all.set(text, 4);
    all.set(bytes, 4 + text.length);
    return all;
  };
  const load = async name => WebAssembly.compile(await (await fetch(name + ".wasm")).arrayBuffer());
  window.modules ??= [await load("compiler"), await load("engine")];
  const compiler = (await WebAssembly.instantiate(window.modules[0])).exports;
  give(compiler, framed(encoder.encode(JSON.stringify(model))));
  const length = compiler.ca_answer(), at = compiler.ca_at(), all = new Uint8Array(compiler.memory.buffer, at, length).slice();
  const head = new DataView(all.buffer).getUint32(0, true), answer = JSON.parse(new TextDecoder().decode(all.subarray(4, 4 + head)));
  const wasm = (await WebAssembly.instantiate(window.modules[1])).exports;
  give(wasm, framed(encoder.encode(JSON.stringify(answer.facts)), all.subarray(4 + head)));
  if (wasm.ca_open() > 0) return "it cannot be opened";
  give(wasm, encoder.encode('{"type": "gesture", "play": true}'));
  wasm.ca_request();
  const frames = Math.ceil(wasm.ca_rate() / wasm.ca_frame());
  let n = 0, hash = 0x811c9dc5;
  for (let frame = 0; frame < frames; frame++) {
    const length = wasm.ca_play(1), words = new Uint32Array(wasm.memory.buffer, wasm.ca_sound_at(), length);
    for (const word of words) hash = Math.imul(hash ^ word, 0x01000193);
    n += length;
    while (wasm.ca_next() > 0);
  }
  return [n, hash >>> 0];
}
