//! The example in C, compiled here against the header and the shared library, as a process of its own.

use desk::{place, played};
use std::path::Path;
use std::process::{Command, Stdio};

#[allow(dead_code)]
#[path = "../../tests/host/desk.rs"]
mod desk;

#[test]
fn c_plays() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    // the library lies beside this test, or one folder up
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let built = [deps.clone(), deps.join("..")];
    let library = built.iter().find(|d| d.join("libca_device.so").exists()).expect("the shared library is built");
    let place = place();
    let program = place.site.root().join("device");
    let cc = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-o"])
        .arg(&program)
        .arg(here.join("../examples/device.c"))
        .arg("-I")
        .arg(here.join("include"))
        .arg("-L")
        .arg(library)
        .args(["-lca_device", "-lm"])
        .output()
        .expect("a C compiler");
    assert!(cc.status.success(), "{}", String::from_utf8_lossy(&cc.stderr));
    let child = Command::new(&program)
        .args(["finger", "2000"])
        .env("CA_SHM_ROOT", place.site.root())
        .env("LD_LIBRARY_PATH", library)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    played(&place, child);
}
