//! The examples in C and Python and Rust, as processes, against a real gateway: a finger of 100 g on a spring of 100 N/m
//! that is pushed with 0.5 N comes to rest at 5 mm.

use crate::desk::{Place, Server, place, spawn, until};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Plays with a device process until it ends, and reads its last line.
fn played(place: &Place, mut child: Child) {
    let mut server = Server::open(&place.site, &["finger"], 3);
    server.plays = (100.0, 0.5, 100_000);
    until("it ends", || {
        server.serve();
        child.try_wait().unwrap().is_some()
    });
    let out = child.wait_with_output().unwrap();
    let (said, err) = (String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{said}\n{err}");
    let line = said.lines().find_map(|l| l.find("sent ").map(|at| &l[at..])).unwrap_or_else(|| panic!("{said}\n{err}"));
    let words: Vec<_> = line.split_whitespace().collect();
    let number = |name: &str| words[words.iter().position(|w| *w == name).unwrap() + 1].parse::<f64>().unwrap();
    assert_eq!((number("sent"), words.last().copied()), (2000.0, Some("on")), "{line}");
    assert!(number("seen") > 100.0 && number("felt") > 100.0, "{line}");
    assert!((number("x") - 0.005).abs() < 0.0005, "{line}");
    assert!(number("most") <= 0.5 + 1e-6, "it never swings back beyond the push: {line}");
    let device = server.gateway.about(0).expect("it says who it is");
    assert_eq!((device.n, device.rate, device.force[0]), (1, 1000, 10.0));
    assert!(server.got[0] >= 1900, "{} of 2000 frames came", server.got[0]);
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
