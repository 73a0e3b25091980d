//! Stability atlas: maps of the running engine compared with theory, the survival table, and non-finite numbers.
//!
//! Prints the page; with `UPDATE=1` writes it to `docs/measured/atlas.md` and its maps to `docs/measured/atlas/`.
#![allow(missing_docs)]

use ca_benches::atlas::page::{page, section};
use ca_benches::atlas::{MAPS, svg};
use std::path::Path;

fn main() {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    let (across, up) = if long { (80, 60) } else { (2, 2) };
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/measured");
    let update = long && std::env::var_os("UPDATE").is_some();
    let mut maps = String::new();
    for map in MAPS {
        let field = map.play(across, up);
        maps += &section(map, &field);
        eprintln!("{}: {} contradictions", map.name, field.contradictions());
        if update {
            let folder = docs.join("atlas");
            std::fs::create_dir_all(&folder).expect("a folder for the maps");
            std::fs::write(folder.join(format!("{}.svg", map.name)), svg::draw(map, &field)).expect("a map is written");
        }
    }
    if !long {
        return;
    }
    let text = page(&maps);
    println!("{text}");
    if update {
        std::fs::write(docs.join("atlas.md"), text).expect("the page can be written");
    }
}
