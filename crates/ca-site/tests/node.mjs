// Plays a second of each model of a site, and prints a line of JSON for each.
// node node.mjs SITE
import fs from "node:fs";
import { pathToFileURL } from "node:url";

const site = process.argv[2], { second } = await import(pathToFileURL(`${site}/npm/second.js`));
const load = name => new WebAssembly.Module(fs.readFileSync(`${site}/${name}.wasm`));
const compiler = new WebAssembly.Instance(load("compiler")).exports, engine = load("engine");
for (const file of fs.readdirSync(`${site}/models`)) {
  const text = fs.readFileSync(`${site}/models/${file}`, "utf8");
  console.log(JSON.stringify({ file, ...second(compiler, engine, file, text) }));
}
