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

/// Every number of the guard stands on the page of safety with its default, every cause with its name, and the README
/// leads there (H19).
#[test]
fn the_page_of_safety_has_the_numbers_of_the_guard() {
    let page = std::fs::read_to_string(from_root("docs/safety.md")).unwrap();
    let defaults = serde_json::to_value(ca_haptic::profile::Limits::default()).unwrap();
    let mut seen = 0;
    for (name, value) in defaults.as_object().unwrap() {
        // the band, the stiffness of an edge and the like are not chosen by people
        let Some(row) = page.lines().find(|l| l.contains(&format!("| `{name}` |"))) else {
            assert!(value.is_null() || value.is_array(), "`{name}` is not on the page");
            continue;
        };
        let cell = row.trim_end_matches('|').rsplit('|').next().unwrap().trim();
        let first = cell.split(' ').next().unwrap();
        match value {
            serde_json::Value::Number(n) => {
                assert_eq!(first.parse::<f64>().ok(), n.as_f64(), "{row}");
                seen += 1;
            }
            serde_json::Value::Bool(b) => assert_eq!(first, b.to_string(), "{row}"),
            _ => {}
        }
    }
    assert!(seen >= 12, "{seen}");
    for cause in ca_haptic::frame::CAUSES {
        assert!(page.contains(cause.name()), "{cause:?}");
    }
    for words in ["cannot replace a switch", "Hands off", "who calibrated"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(std::fs::read_to_string(from_root("README.md")).unwrap().contains("docs/safety.md"));
}
