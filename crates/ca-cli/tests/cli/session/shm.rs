//! Tests `ca shm` in a private folder: files of dead processes are listed and removed, files of living ones are kept.

use crate::desk::Desk;
use std::fs;

#[test]
fn debris_is_shown_and_removed() {
    let desk = Desk::new();
    desk.ca(&["shm", "list"]).is(0).says(&["no shared memory"]);
    let prefix = desk.ca(&["shm", "list", "--json"]).is(0).json()["prefix"].as_str().unwrap().to_owned();
    let other = prefix.replacen("ca1-", "ca0-", 1);
    let (ours, theirs) = (format!("/dev/shm/{prefix}test.data"), format!("/dev/shm/{other}test.data"));
    fs::write(&ours, [0; 64]).unwrap();
    fs::write(&theirs, vec![0; 20_000]).unwrap();
    let list = desk.ca(&["shm", "list"]).is(0).says(&[&ours, &theirs, "not in use", "another version", "20 kB"]);
    assert!(!list.out.contains("used by"));
    let held = fs::File::open(&theirs).unwrap();
    let me = std::process::id().to_string();
    desk.ca(&["shm", "list"]).is(0).says(&["used by", &me]);
    let clean = desk.ca(&["shm", "clean"]).is(0).says(&["1 files removed, 64 bytes", "kept frames 0", &me]);
    assert!(clean.out.contains(&format!("removed {ours}")) && fs::metadata(&theirs).is_ok());
    drop(held);
    let json = desk.ca(&["shm", "clean", "--json"]).is(0).json();
    assert_eq!(json["removed"][0]["path"], theirs);
    desk.ca(&["shm", "list"]).is(0).says(&["no shared memory"]);
}
