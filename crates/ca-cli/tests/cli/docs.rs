//! The pages of `docs/`: what is generated is fresh, what is written is true.

use crate::desk::{Desk, blocks, from_root};
use std::fs;

const INTRO: &str = "# Kinds of modules

Made by `ca list --markdown`: do not edit. `ca list BUT` shows the whole page of a kind: each parameter with its unit,
range and default, the sources in full, and an example that sounds. `e` is the elongation of a link, second end minus
first, and `F` its force, positive where it pulls; `x1` is the position one tick before, `T` the tick, `f` the summed
force. [model-format.md](model-format.md) tells how a model file is written.

";

#[test]
fn the_page_of_kinds_is_fresh() {
    let want = format!("{INTRO}{}", Desk::new().ca(&["list", "--markdown"]).is(0).out);
    let path = from_root("docs/kinds.md");
    if std::env::var_os("UPDATE").is_some() {
        fs::write(&path, &want).unwrap();
    }
    let is = fs::read_to_string(&path).unwrap_or_default();
    assert!(is == want, "docs/kinds.md is stale; run `UPDATE=1 cargo test -p ca-cli docs` and look at what changed");
}

#[test]
fn the_examples_of_the_format_are_models_without_findings() {
    let page = fs::read_to_string(from_root("docs/model-format.md")).unwrap();
    let models = blocks(&page, "toml");
    assert!(models.len() >= 5, "only {} examples were found", models.len());
    let desk = Desk::new();
    for (_, model) in &models {
        desk.put("example.ca.toml", model);
        let r = desk.ca(&["render", "example.ca.toml", "--seconds", "2"]).is(0);
        assert_eq!(r.err, "", "{model}");
        let check = desk.ca(&["check", "example.ca.toml"]).is(0);
        assert_eq!(check.err, "", "{model}");
    }
}

#[test]
fn the_page_of_the_format_names_all_there_is() {
    use ca_core::model::read::{GROUP, META, RATES, SECTIONS};
    let page = fs::read_to_string(from_root("docs/model-format.md")).unwrap();
    for word in META.iter().chain(RATES).chain(GROUP) {
        assert!(page.contains(&format!("`{word}`")), "the page does not know `{word}`");
    }
    for section in SECTIONS {
        assert!(page.contains(&format!("`[{section}]`")), "the page does not know `[{section}]`");
    }
}
