// The parts of the engine on a site: files beside the page.

const load = name => async () => {
  const found = await fetch(new URL(name, document.baseURI));
  if (!found.ok) throw new Error(`\`${name}\` cannot be loaded (${found.status}); reload the page`);
  return found.arrayBuffer();
};

/** @returns {import("./connection.js").Parts} */
export function parts() {
  const inside = /** @type {any} */ (globalThis).caParts;
  if (inside) return inside;
  const engine = load("engine.wasm");
  return {
    worker: () => new Worker(new URL("browser/compiler-worker.js", document.baseURI)),
    compiler: load("compiler.wasm"),
    accuracy: load("accuracy.wasm"),
    engine,
    worklet: String(new URL("browser/worklet.js", document.baseURI)),
  };
}
