//! The Rust and Python examples as processes (`ca-device` tests the C example).

use crate::helpers::{TempSite, played, spawn, temp_site};
use crate::skipped::skipped;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[test]
fn rust() {
    let place = temp_site();
    let child = spawn(&place.site, "device", "finger 2000");
    played(&place, child);
}

/// Copies the device module alone to a package: it needs no compiled half.
fn package(place: &TempSite) -> PathBuf {
    let folder = place.site.root().join("python");
    let package = folder.join("cordis_anima");
    std::fs::create_dir_all(&package).unwrap();
    std::fs::write(package.join("__init__.py"), "").unwrap();
    for name in ["device.py", "_errors.py"] {
        std::fs::copy(here("../ca-py/python/cordis_anima").join(name), package.join(name)).unwrap();
    }
    folder
}

#[test]
fn python() {
    // the documentation shows the example itself
    let example = std::fs::read_to_string(here("../ca-py/examples/device.py")).unwrap();
    let page = std::fs::read_to_string(here("../../docs/devices.md")).unwrap();
    let shown = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let (_, code) = example.split_once("\"\"\"\n\n").expect("a document, and then the code");
    assert_eq!(shown, code);
    assert!(code.lines().filter(|l| !l.trim().is_empty()).count() <= 15, "about fifteen lines");

    let made = Command::new(here("../../tests/python/venv")).stderr(Stdio::piped()).output().unwrap();
    if !made.status.success() {
        skipped("python", &format!("no Python with packages: {}", String::from_utf8_lossy(&made.stderr)));
        return;
    }
    let python = PathBuf::from(String::from_utf8(made.stdout).unwrap().trim());
    let place = temp_site();
    let folder = package(&place);
    let child = Command::new(&python)
        .arg(here("../ca-py/examples/device.py"))
        .args(["finger", "2000"])
        .env("CA_SHM_ROOT", place.site.root())
        .env("PYTHONPATH", folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    played(&place, child);
}
