//! Tests the page with playing instruments, in wide and narrow windows, dark and light. The picture moves, the console
//! stays empty, nothing is wider than the window, and names of outputs are complete.
//!
//! `UPDATE=1 cargo test $ALL --test page -- pictures` writes `docs/pictures/`, which README.md and docs/play.md show.

use crate::browser::Tab;
use crate::host::{Host, until};
use crate::long_form::long_form;
use std::path::Path;

/// Model, width, height, colours, seconds into its gesture.
const SHOWN: [(&str, u32, u32, &str, f64); 5] = [
    ("hammered_string", 1440, 900, "dark", 1.0),
    ("rattle", 1440, 900, "light", 2.0),
    ("membrane", 1440, 900, "dark", 0.1),
    ("hammer_piano", 390, 844, "light", 2.0),
    ("plucked_string", 390, 844, "dark", 1.0),
];

pub fn are_made() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let update = std::env::var_os("UPDATE").is_some();
    let all = long_form("all but one of the pictures of the page") || update;
    let tried = |shown: &&(&str, u32, u32, &str, f64)| all || shown.0 == "plucked_string";
    for (model, width, height, colours, seconds) in SHOWN.iter().copied().filter(|s| tried(&s)) {
        let text = std::fs::read_to_string(root.join("models").join(format!("{model}.ca.toml"))).unwrap();
        let mut host = Host::play(&text, &["--seconds", "60"]);
        let Some(mut tab) = Tab::open(&host.address) else { return };
        tab.looks(width, height, colours);
        until("it is drawn", || tab.js("+document.documentElement.dataset.frames > 20") == true);
        let canvas = tab.part("canvas");
        tab.js("document.getElementById('play').click()");
        let began = tab.js("+document.documentElement.dataset.tick").as_f64().unwrap_or_default();
        until("it plays", || {
            let tick = tab.js("+document.documentElement.dataset.tick").as_f64().unwrap_or_default();
            tick > began + seconds * 48_000.0
        });
        assert_ne!(tab.part("canvas"), canvas, "{model}: the picture moves");
        assert_eq!(tab.js("document.documentElement.scrollWidth <= innerWidth"), true, "{model} at {width}");
        let names = "(c => c.scrollWidth <= c.clientWidth)(document.getElementById('channels'))";
        assert_eq!(tab.js(names), true, "{model} at {width}: names of outputs are whole");
        assert_eq!(tab.js("document.documentElement.dataset.errors"), "0", "{model}");
        if update {
            let folder = root.join("docs/pictures");
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(format!("{model}.webp")), tab.webp()).unwrap();
        }
        assert_eq!(tab.errors(), Vec::<String>::new(), "{model}");
        let mut page = host.page();
        page.done(&serde_json::json!({"type": "stop"}));
        host.ended();
    }
}
