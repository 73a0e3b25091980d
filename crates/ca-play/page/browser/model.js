// The model that a page without a server plays: written into the page, named in the address, or carried by a link. Links
// come from strangers, so their text is limited before it is unpacked.

const LONGEST = 300000, MODULES = 20000, NAME = /^[a-z0-9_]{1,60}$/;

/** @returns {Promise<import("./connection.js").Model>} */
export async function model() {
  const inside = document.getElementById("instrument");
  if (inside) return JSON.parse(inside.textContent);
  const packed = new URLSearchParams(location.hash.slice(1)).get("model");
  if (packed !== null) return { file: "shared.ca.toml", text: await unpack(packed), limit: MODULES };
  const name = new URLSearchParams(location.search).get("model") || "";
  if (!NAME.test(name)) throw new Error("the address names no instrument; choose one in the gallery");
  const found = await fetch(`models/${name}.ca.toml`);
  if (!found.ok) throw new Error(`there is no instrument \`${name}\`; choose one in the gallery`);
  return { file: `${name}.ca.toml`, text: await found.text() };
}

// a model as a part of an address, and back
export async function pack(text) {
  const blob = new Blob([text]);
  if (blob.size > LONGEST) throw new Error(`The model is too long for a link: at most ${LONGEST / 1000} kB.`);
  const bytes = new Uint8Array(await new Response(blob.stream().pipeThrough(new CompressionStream("deflate-raw"))).arrayBuffer());
  let binary = "";
  for (const b of bytes) binary += String.fromCharCode(b);
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

export async function unpack(packed) {
  const bad = new Error("the model in this link is damaged or too long; ask for the link again");
  if (packed.length > LONGEST) throw bad;
  let bytes;
  try {
    bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), c => c.charCodeAt(0));
  } catch {
    throw bad;
  }
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  const decoder = new TextDecoder("utf-8", { fatal: true });
  let text = "", read = 0;
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return text + decoder.decode();
      read += value.length;
      if (read > LONGEST) throw bad;
      text += decoder.decode(value, { stream: true });
    }
  } catch {
    throw bad;
  }
}
