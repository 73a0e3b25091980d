// Gives the engine malformed plans: plans of models with bytes changed, cut, added, copied, or taken from another plan.
// Each must be refused with a reason, or play. Prints the counts, and the cases that stopped the module, as JSON.
// node malformed.mjs SITE CASES SEED
import fs from "node:fs";
import { pathToFileURL } from "node:url";

const [site, cases, seed] = process.argv.slice(2), { ask, framed, give } = await import(pathToFileURL(`${site}/npm/wasm.js`));
// bytes before the record: magic, versions, length, checksum
const HEAD = 32, LONGEST = 60000;
// cases of one instance, and frames played in each
const REUSED = 20, FRAMES = 4;

let state = Number(seed) >>> 0;
// a number below n, by a xorshift of 32 bits
function below(n) {
  state ^= state << 13; state ^= state >>> 17; state ^= state << 5;
  return (state >>> 0) % n;
}

// FNV-1a in 64 bits, as two halves
function checksum(bytes) {
  let low = 0x84222325, high = 0xcbf29ce4;
  for (const byte of bytes) {
    low = (low ^ byte) >>> 0;
    const product = low * 0x1b3;
    high = (Math.imul(high, 0x1b3) + Math.floor(product / 2 ** 32) + (low << 8)) >>> 0;
    low = product >>> 0;
  }
  return [low, high];
}

// a plan with this record and the head of another plan
function sealed(head, record) {
  const all = new Uint8Array(HEAD + record.length), view = new DataView(all.buffer), [low, high] = checksum(record);
  all.set(head);
  all.set(record, HEAD);
  view.setUint32(16, record.length, true); view.setUint32(20, 0, true);
  view.setUint32(24, low, true); view.setUint32(28, high, true);
  return all;
}

const some = (bytes, most) => { const at = below(bytes.length); return bytes.subarray(at, at + 1 + below(most)); };
const spliced = (bytes, at, cut, put) => Uint8Array.from([...bytes.subarray(0, at), ...put, ...bytes.subarray(at + cut)]);

function changed(record, other) {
  const at = below(record.length), kind = below(12);
  if (kind < 6) record[at] = [below(256), record[at] ^ 1 << below(8), 0, 255][below(4)];
  else if (kind === 6) return spliced(record, at, 1 + below(8), []);
  else if (kind === 7) return spliced(record, at, 0, Array.from({ length: 1 + below(8) }, () => below(256)));
  else if (kind === 8) return record.slice(0, at + 1);
  else if (kind === 9) return spliced(record, at, record.length, other.subarray(Math.min(at, other.length)));
  else record.set(some(kind === 10 ? record : other, Math.min(32, record.length - at)), at);
  return record;
}

const load = name => new WebAssembly.Module(fs.readFileSync(`${site}/${name}.wasm`));
const compiler = new WebAssembly.Instance(load("compiler")).exports, engine = load("engine");
const plans = fs.readdirSync(`${site}/models`).flatMap(file => {
  const text = fs.readFileSync(`${site}/models/${file}`, "utf8"), { object, bytes } = ask(compiler, { type: "compile", file, text });
  return object.ok && bytes.length < LONGEST ? [{ file, facts: object.facts, bytes }] : [];
});

if (!plans.every(({ bytes }) => Buffer.compare(sealed(bytes.subarray(0, HEAD), bytes.subarray(HEAD)), bytes) === 0)) throw new Error("plans have another form");

const say = (wasm, request) => { give(wasm, new TextEncoder().encode(JSON.stringify(request))); wasm.ca_request(); };
// messages of the engine, as far as they are texts
function* messages(wasm) {
  for (let length; (length = wasm.ca_next()) > 0;) {
    const bytes = new Uint8Array(wasm.memory.buffer, wasm.ca_at(), length).slice();
    if (bytes[0] === 0x7b) yield JSON.parse(new TextDecoder().decode(bytes));
  }
}
function perform(wasm) {
  for (const { type, params = [] } of [...messages(wasm)]) {
    if (type === "scene") for (const { name, min, max, value } of params) say(wasm, { type: "set", values: { [name]: max ?? min ?? value } });
  }
  for (const request of [{ type: "sound", on: true }, { type: "gesture", play: true }, { type: "grab", mass: 0 }, { type: "drag", by: [1e-3] }]) say(wasm, request);
  wasm.ca_play(FRAMES);
  [...messages(wasm)];
}

const counts = { plans: plans.length, refused: 0, played: 0, stopped: [] }, SHOWN = 5;
let wasm = null;
for (let n = 0; n < cases; n++) {
  const { file, facts, bytes } = plans[below(plans.length)], other = plans[below(plans.length)].bytes.subarray(HEAD);
  let record = bytes.slice(HEAD);
  for (let k = 1 + below(4); k > 0 && record.length > 1; k--) record = changed(record, other);
  // one in eight has the old length and checksum
  const plan = below(8) ? sealed(bytes.subarray(0, HEAD), record) : Uint8Array.from([...bytes.subarray(0, HEAD), ...record]);
  try {
    if (!wasm || n % REUSED === 0) wasm = new WebAssembly.Instance(engine).exports;
    if (below(2)) {
      give(wasm, framed(facts, plan));
      const length = wasm.ca_open();
      counts[length > 0 ? "refused" : "played"]++;
      if (length === 0) perform(wasm);
    } else {
      // a new version of an instrument that plays
      give(wasm, framed(facts, bytes));
      if (wasm.ca_open() > 0) throw new Error("a good plan is refused");
      say(wasm, { type: "play" });
      give(wasm, framed(facts, plan));
      wasm.ca_compiled();
      wasm.ca_play(FRAMES);
      const bad = [...messages(wasm)].some(m => m.type === "report" && !m.ok);
      counts[bad ? "refused" : "played"]++;
      perform(wasm);
    }
  } catch (error) {
    wasm = null;
    counts.stopped.push({ case: n, file, error: String(error.stack || error).split("\n").slice(0, 12).join("\n") });
  }
}
console.log(JSON.stringify({ ...counts, stopped: counts.stopped.slice(0, SHOWN) }));
