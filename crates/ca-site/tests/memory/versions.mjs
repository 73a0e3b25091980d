// Sizes of the memories of both modules after each of 50 versions of a model, as JSON. Beside `wasm.js` of the package.
// node versions.mjs MODEL
import fs from "node:fs";
import { ask, framed, give } from "./wasm.js";

const load = name => new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(new URL(`../${name}.wasm`, import.meta.url)))).exports;
const compiler = load("compiler"), engine = load("engine"), text = fs.readFileSync(process.argv[2], "utf8");
const compile = n => {
  const { object, bytes } = ask(compiler, { type: "compile", file: "a.ca.toml", text: `${text}\n# ${n}` });
  return framed(object.facts, bytes);
};
const play = () => { engine.ca_play(200); while (engine.ca_next() > 0); };

give(engine, compile(0));
if (engine.ca_open() > 0) throw new Error("the plan cannot be opened");
const sizes = [];
for (let n = 1; n <= 50; n++) {
  engine.ca_changed();
  play();
  give(engine, compile(n));
  engine.ca_compiled();
  play();
  sizes.push({ compiler: compiler.memory.buffer.byteLength, engine: engine.memory.buffer.byteLength });
}
console.log(JSON.stringify(sizes));
