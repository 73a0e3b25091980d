//! An instrument as one HTML file: page, engine, compiler and model. It needs no network and plays from a disk.
//!
//! A page from a disk may not load modules, workers or worklets from files, so the scripts are classic. The worker starts
//! from a blob, the worklet from a data address. The WebAssembly modules are compressed, as base64.

use crate::{WebModules, page};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ca_play::{STYLE, bundle};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use std::io::Write as _;

/// Returns the page of a model. `file` is the name of its file, and `site` the address of a site for links to the
/// model; links are left out if it is empty.
pub fn one_file(text: &str, file: &str, site: &str, modules: WebModules) -> String {
    let style = format!("<style>\n{STYLE}</style>\n");
    let model = inside(&json!({"file": file, "text": text}));
    let parts = format!(
        "const unpack = text => new Response(new Blob([Uint8Array.from(atob(text), c => c.charCodeAt(0))]).stream()\
         .pipeThrough(new DecompressionStream(\"gzip\"))).arrayBuffer();\n\
         const script = text => URL.createObjectURL(new Blob([text], {{ type: \"text/javascript\" }}));\n\
         globalThis.caParts = {{\n\
         worker: () => new Worker(script({worker})),\n\
         worklet: \"data:text/javascript;base64,{worklet}\",\n\
         engine: () => unpack({engine}),\n\
         compiler: () => unpack({compiler}),\n}};\n",
        worker = inside(&bundle("browser/compiler-worker.js").into()),
        // a worklet of a page from a disk may come from a data address, but not from a blob
        worklet = STANDARD.encode(bundle("browser/worklet.js")),
        engine = inside(&packed(modules.engine).into()),
        compiler = inside(&packed(modules.compiler).into()),
    );
    let site = format!("document.documentElement.dataset.site = {};\n", inside(&site.into()));
    let script = format!(
        "<script type=\"application/json\" id=\"instrument\">{model}</script>\n<script>\n{site}{parts}</script>\n\
         <script>\naddEventListener(\"DOMContentLoaded\", () => {{\n{}}});\n</script>\n",
        bundle("main.js")
    );
    page(&style, &script)
}

/// A value as text inside a script: no end of the script can be in it.
fn inside(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

fn packed(bytes: &[u8]) -> String {
    let mut out = GzEncoder::new(Vec::new(), Compression::best());
    // writing to memory does not fail
    let _ = out.write_all(bytes);
    STANDARD.encode(out.finish().unwrap_or_default())
}
