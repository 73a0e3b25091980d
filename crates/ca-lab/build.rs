//! Embeds the models of `models/`, a link to the folder of the workspace so that a source archive contains it.
//!
//! A model is named by its file without `.ca.toml`, in alphabetical order. Twenty lines here replace a crate that
//! embeds folders, and a new file needs no entry anywhere.
#![forbid(unsafe_code)]

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

fn main() {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("models");
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut files: Vec<(String, String)> = fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|f| {
            let name = f.file_name().to_str()?.strip_suffix(".ca.toml")?.to_owned();
            Some((name, fs::canonicalize(f.path()).ok()?.to_str()?.to_owned()))
        })
        .collect();
    assert!(!files.is_empty(), "no models in {}", folder.display());
    files.sort();
    let mut list =
        String::from("/// The bundled models: name and text, by name.\npub static BUNDLED: &[(&str, &str)] = &[\n");
    for (name, path) in files {
        println!("cargo:rerun-if-changed={path}");
        let _ = writeln!(list, "    ({name:?}, include_str!({path:?})),");
    }
    list.push_str("];\n");
    let out = Path::new(&env::var("OUT_DIR").unwrap_or_default()).join("bundled.rs");
    fs::write(out, list).expect("the build directory can be written");
}
