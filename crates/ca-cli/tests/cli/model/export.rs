//! Tests `ca export` and `ca site`, with and without the engine for browsers in this build.

use crate::sandbox::Sandbox;

/// A build without the engine says how to get one, and writes nothing.
#[test]
fn a_page_needs_the_engine() {
    let sandbox = Sandbox::new();
    let (page, site) = (["export", "kalimba", "--html", "k.html"], ["site", "public"]);
    if ca_site::modules().is_none() {
        for args in [&page[..], &site] {
            sandbox.ca(args).is(1).says(&["without the engine for browsers", "tools/site"]);
        }
        assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
        return;
    }
    sandbox.ca(&page).is(0).says(&["k.html written"]);
    let text = std::fs::read_to_string(sandbox.path("k.html")).unwrap();
    assert!(text.contains("kalimba.ca.toml") && text.len() > 1_000_000 && !text.contains("src=\"main.js\""));
    sandbox.ca(&site).is(0).says(&["public: ", "files"]);
    for name in ["index.html", "play.html", "engine.wasm", "models/kalimba.ca.toml", "npm/package.json", "sw.js"] {
        assert!(sandbox.path("public").join(name).is_file(), "{name}");
    }
    // a part from another file would be missing in the page
    sandbox.put("part.ca.toml", "[MAS]\nbob = { m = '1 g', dx0 = '1 mm' }\n");
    sandbox.put("whole.ca.toml", "[use]\na = { file = 'part.ca.toml' }\n[SOX]\nout = { from = 'a.bob' }\n");
    sandbox.ca(&["export", "whole.ca.toml", "--html", "w.html"]).is(1).says(&["from other files"]);
    // a bundled part is not
    sandbox.ca(&["export", "bowed_string", "--html", "b.html", "--site", "https://a.example/x"]).is(0);
    let text = std::fs::read_to_string(sandbox.path("b.html")).unwrap();
    assert!(text.contains("dataset.site = \"https://a.example/x/\""));
    sandbox.ca(&["export", "bowed_string", "--html", "b.html", "--site", "a.example"]).is(2).says(&["begins with"]);
    // a model of another program is in the page as a model file
    sandbox.put("chains.mdl", include_str!("../../../../../tests/mims/chains.mdl"));
    sandbox.ca(&["export", "chains.mdl", "--html", "c.html"]).is(0);
    let text = std::fs::read_to_string(sandbox.path("c.html")).unwrap();
    assert!(text.contains("chains.ca.toml") && text.contains("[SOX]"));
}
