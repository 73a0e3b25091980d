//! The C example, compiled here against the header and the shared library, as a separate process.

use helpers::{played, temp_site};
use long_form::long_form;
use std::path::Path;
use std::process::{Command, Stdio};

#[allow(dead_code)]
#[path = "../../tests/host/helpers.rs"]
mod helpers;

#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;

#[test]
fn c_plays() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    // the library is beside this test, or one folder up
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let built = [deps.clone(), deps.join("..")];
    let library = built.iter().find(|d| d.join("libca_device.so").exists()).expect("the shared library is built");
    let place = temp_site();
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

/// Returns the build commands of `docs/devices.md`.
fn page() -> String {
    let page = include_str!("../../../../docs/devices.md");
    let block = page.split("```sh\n").skip(1).find(|b| b.contains("ca_device.h") || b.contains("-lca_device"));
    let block = block.expect("how to build it").split("```").next().unwrap();
    assert!(block.contains("cargo build -p ca-device") && block.contains("libca_device.a"), "{block}");
    block.to_owned()
}

#[test]
fn the_page_builds_and_links() {
    // the workspace builds it with other features, so all its dependencies are compiled again
    if !long_form("a build of ca-device alone") {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..").canonicalize().unwrap();
    // <target>/<profile>/deps, whatever the profile
    let exe = std::env::current_exe().unwrap();
    let target = exe.ancestors().nth(3).unwrap();
    let place = temp_site();
    // the page writes into `target`, the test into a temporary folder
    let lines = page()
        .replace("target/finger", &place.site.root().join("finger").display().to_string())
        .replace("$PWD/target/", &format!("{}/", target.display()))
        .replace("target/debug", &target.join("debug").display().to_string());
    let built = Command::new("sh")
        .args(["-ec", &lines])
        .current_dir(&root)
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO", env!("CARGO"))
        .output()
        .expect("a shell");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    for program in ["finger", "finger-static"] {
        let child = Command::new(place.site.root().join(program))
            .args(["finger", "2000"])
            .env("CA_SHM_ROOT", place.site.root())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        played(&place, child);
    }
}
