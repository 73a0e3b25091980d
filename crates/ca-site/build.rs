//! Finds the WebAssembly modules that the pages need. `tools/site` builds them and names their folder in
//! `CA_WEB_ENGINE`; without it, the pages cannot be made.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-env-changed=CA_WEB_ENGINE");
    println!("cargo::rustc-check-cfg=cfg(engine)");
    let Some(folder) = std::env::var_os("CA_WEB_ENGINE").map(PathBuf::from) else { return };
    for name in ["engine", "compiler", "accuracy"] {
        let path = folder.join(format!("{name}.wasm"));
        assert!(path.is_file(), "CA_WEB_ENGINE: {} is not a file", path.display());
        println!("cargo::rerun-if-changed={}", path.display());
        println!("cargo::rustc-env=CA_WEB_{}_FILE={}", name.to_uppercase(), path.display());
    }
    println!("cargo::rustc-cfg=engine");
}
