//! Tests that a model without devices uses neither their threads nor shared memory nor a folder.

use crate::sandbox::{Proc, Sandbox, until};
use std::fs;

const BAR: &str =
    "[CEL]\nbar = { m = \"1 g\", f = \"220 Hz\", t60 = \"1 s\", dx0 = \"1 mm\" }\n[SOX]\nout = { from = \"bar\" }\n";

fn threads(p: &Proc) -> Vec<String> {
    let tasks = fs::read_dir(format!("/proc/{}/task", p.id())).unwrap();
    let mut names: Vec<String> = tasks
        .filter_map(|t| fs::read_to_string(t.unwrap().path().join("comm")).ok())
        .map(|n| n.trim().to_owned())
        .collect();
    names.sort();
    names
}

fn has_no_shared_memory(sandbox: &Sandbox, p: &Proc, folders: &[&str]) {
    let maps = fs::read_to_string(format!("/proc/{}/maps", p.id())).unwrap();
    assert!(!maps.contains("/dev/shm") && !maps.contains("iox2"), "{maps}");
    assert!(maps.contains("/ca"), "the maps of our own process:\n{maps}");
    let root = sandbox.site.root();
    // the test itself has created the prefix
    let mut names: Vec<_> = fs::read_dir(root).unwrap().flatten().map(|e| e.file_name()).collect();
    names.sort();
    assert_eq!(names, folders, "nothing more in {}", root.display());
}

#[test]
fn rendering_starts_no_thread_and_opens_no_shared_memory() {
    let sandbox = Sandbox::shared();
    sandbox.put("bar.ca.toml", BAR).put("dev.ca.toml", crate::sandbox::KEY);
    // rendering never uses a device, even if the model names one
    for model in ["bar.ca.toml", "dev.ca.toml"] {
        let p = sandbox.spawn(&["render", model, "-o", "/dev/null", "--seconds", "3600", "--quiet"]);
        // one thread waits for Ctrl-C
        until("it has begun", || threads(&p).iter().any(|n| n == "ctrl-c"));
        for _ in 0..20 {
            assert_eq!(threads(&p), ["ca", "ctrl-c"], "{}", p.stderr());
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        has_no_shared_memory(&sandbox, &p, &["prefix"]);
        p.kill();
    }
}

#[test]
fn serving_a_model_without_devices_opens_no_shared_memory() {
    let sandbox = Sandbox::shared();
    sandbox.put("bar.ca.toml", BAR);
    let p = sandbox.spawn(&["serve", "bar.ca.toml", "--seconds", "60", "--priority", "0", "--no-lock"]);
    until("it plays", || threads(&p).iter().any(|n| n == "ca engine"));
    // a new thread gets its name with a short delay
    until("it is ready for Ctrl-C", || threads(&p).iter().any(|n| n == "ctrl-c"));
    assert_eq!(threads(&p), ["ca", "ca engine", "ctrl-c"], "{}", p.stderr());
    has_no_shared_memory(&sandbox, &p, &["prefix"]);
    let ran = p.stop();
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    // with a device, both exist, so this test can detect them
    let p = sandbox.serve("key.ca.toml", &["--quiet"]);
    assert!(threads(&p).iter().any(|n| n == "ca gateway"), "{:?}", threads(&p));
    let maps = fs::read_to_string(format!("/proc/{}/maps", p.id())).unwrap();
    assert!(maps.contains("/dev/shm"));
}

/// Other processes stop and set a page through a socket only.
#[test]
fn a_page_without_devices_is_reached_and_opens_no_shared_memory() {
    let sandbox = Sandbox::shared();
    sandbox.put("bar.ca.toml", BAR);
    let p = sandbox.spawn(&["play", "bar.ca.toml", "--no-open", "--priority", "0", "--no-lock", "--seconds", "60"]);
    until("it answers", || sandbox.ca(&["status"]).code == Some(0));
    assert!(!threads(&p).iter().any(|n| n == "ca gateway"), "{:?}", threads(&p));
    has_no_shared_memory(&sandbox, &p, &["control", "prefix"]);
    sandbox.ca(&["audio"]).is(0).says(&["sound:"]);
    sandbox.ca(&["set", "bar.mm=1"]).is(1).says(&["`bar` has no parameter `mm`", "it has `m`, `k`"]);
    sandbox.ca(&["set", "bar.m=-1"]).is(0).says(&["errors appear in its terminal"]);
    until("it is refused", || p.stderr().contains("`m`"));
    sandbox.ca(&["stop"]).is(0);
    p.end();
}
