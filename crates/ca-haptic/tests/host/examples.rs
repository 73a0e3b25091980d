//! The examples in Rust and Python as processes (that in C is a test of `ca-device`).

use crate::desk::{Place, place, played, spawn};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[test]
fn rust() {
    let place = place();
    let child = spawn(&place.site, "device", "finger 2000");
    played(&place, child);
}

fn run(place: &Place, program: &Path, args: &[&str]) -> Child {
    Command::new(program)
        .args(args)
        .args(["finger", "2000"])
        .env("CA_SHM_ROOT", place.site.root())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

#[test]
fn python() {
    let made = Command::new(here("../../tests/python/venv")).stderr(Stdio::piped()).output().unwrap();
    if !made.status.success() {
        println!("skipped: no Python libraries here: {}", String::from_utf8_lossy(&made.stderr).trim());
        return;
    }
    let python = PathBuf::from(String::from_utf8(made.stdout).unwrap().trim());
    let place = place();
    let script = here("examples/device.py");
    let child = run(&place, &python, &[script.to_str().unwrap()]);
    played(&place, child);
}
