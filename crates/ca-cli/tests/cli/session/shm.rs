//! Tests `ca shm` in a private folder: files of dead processes are listed and removed, files of living ones are kept.

use crate::sandbox::Sandbox;
use std::fs;

#[test]
fn debris_is_shown_and_removed() {
    let sandbox = Sandbox::new();
    sandbox.ca(&["shm", "list"]).is(0).says(&["no shared memory"]);
    let prefix = sandbox.ca(&["shm", "list", "--json"]).is(0).json()["prefix"].as_str().unwrap().to_owned();
    let other = prefix.replacen("ca1-", "ca0-", 1);
    let (ours, theirs) = (format!("/dev/shm/{prefix}test.data"), format!("/dev/shm/{other}test.data"));
    fs::write(&ours, [0; 64]).unwrap();
    fs::write(&theirs, vec![0; 20_000]).unwrap();
    let list = sandbox.ca(&["shm", "list"]).is(0).says(&[&ours, &theirs, "not in use", "another version", "20 kB"]);
    assert!(!list.out.contains("used by"));
    let held = fs::File::open(&theirs).unwrap();
    let me = std::process::id().to_string();
    sandbox.ca(&["shm", "list"]).is(0).says(&["used by", &me]);
    let clean = sandbox.ca(&["shm", "clean"]).is(0).says(&["1 files removed, 64 bytes", "kept frames 0", &me]);
    assert!(clean.out.contains(&format!("removed {ours}")) && fs::metadata(&theirs).is_ok());
    drop(held);
    let json = sandbox.ca(&["shm", "clean", "--json"]).is(0).json();
    assert_eq!(json["removed"][0]["path"], theirs);
    sandbox.ca(&["shm", "list"]).is(0).says(&["no shared memory"]);
}
