//! Reads takes with the Python libraries of MCAP, in a virtual environment.

use super::performer::{DUO, Performer, duo};
use crate::sandbox::{Sandbox, from_root};
use crate::skipped::skipped;
use std::process::Command;

#[track_caller]
fn python() -> Option<String> {
    let made = Command::new("bash").arg(from_root("tests/python/venv")).output().unwrap();
    let said = String::from_utf8_lossy(&made.stdout).trim().to_owned();
    if made.status.success() {
        return said.lines().last().map(str::to_owned);
    }
    skipped("python", &format!("no Python with packages: {}", String::from_utf8_lossy(&made.stderr)));
    None
}

#[test]
fn every_message_is_read_by_the_libraries_of_others() {
    let Some(python) = python() else { return };
    let sandbox = Sandbox::new();
    duo(&sandbox.path("whole.mcap"), 1600);
    let mut p = Performer::new(DUO, &sandbox.path("x.mcap"));
    p.frames(1000);
    p.finish();
    let bytes = std::fs::read(sandbox.path("x.mcap")).unwrap();
    std::fs::write(sandbox.path("cut.mcap"), &bytes[..bytes.len() * 4 / 5]).unwrap();
    sandbox.ca(&["log", "recover", "cut.mcap", "-o", "saved.mcap"]).is(3);
    sandbox.ca(&["log", "export", "whole.mcap", "/device/left/in", "-o", "hand.npy"]).is(0);
    for (file, extra) in [("whole.mcap", "hand.npy"), ("cut.mcap", "-"), ("saved.mcap", "-")] {
        let o = Command::new(&python)
            .arg(from_root("tests/python/take.py"))
            .args([sandbox.path(file), sandbox.path(extra)])
            .output()
            .unwrap();
        let (out, err) = (String::from_utf8_lossy(&o.stdout), String::from_utf8_lossy(&o.stderr));
        assert!(o.status.success(), "{file}:\n{out}\n{err}");
        let counted: serde_json::Value = serde_json::from_str(out.lines().last().unwrap()).unwrap();
        let ours = sandbox.ca(&["log", "info", file, "--json"]).is(0).json();
        for (topic, t) in ours["topics"].as_object().unwrap() {
            assert_eq!(counted[topic], t["messages"], "{file}: {topic}");
        }
        assert!(counted["/scene"].as_u64().unwrap() > 3);
    }
}
