//! Files left behind by killed processes and other versions.

use crate::helpers::{about, spawn, temp_site, until};
use ca_haptic::host::stale_shm::{clean, list};
use ca_haptic::host::{DeviceClient, Gateway, HostErrorKind};
use std::fs;
use std::io::BufRead;
use std::path::PathBuf;

#[test]
fn what_the_dead_leave_is_listed_and_removed() {
    let place = temp_site();
    assert_eq!(list(&place.site), []);
    let mut child = spawn(&place.site, "server", "a b");
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|l| l.unwrap().contains("open")));
    let alive = list(&place.site);
    assert!(alive.len() == 1 && alive[0].current && alive[0].bytes() > 0);
    assert_eq!(alive[0].alive.iter().map(|a| a.0).collect::<Vec<_>>(), [child.id()]);
    // files of a live process are not touched
    let kept = clean(&place.site);
    assert_eq!((kept.removed.len(), kept.in_use.len()), (0, 1));
    assert_eq!(list(&place.site)[0].files, alive[0].files);
    child.kill().unwrap();
    child.wait().unwrap();
    let dead = list(&place.site);
    assert!(dead[0].alive.is_empty() && dead[0].files.len() == alive[0].files.len());
    let cleaned = clean(&place.site);
    assert_eq!((cleaned.removed.len(), cleaned.failed.len()), (dead[0].files.len(), 0));
    assert_eq!(list(&place.site), []);
}

#[test]
fn another_version_is_named_not_met() {
    let place = temp_site();
    let other = place.site.prefix().replacen("ca1-", "ca9-", 1);
    let shm = PathBuf::from(format!("/dev/shm/{other}x.data"));
    let file = place.site.root().join(format!("{other}x.event"));
    fs::write(&shm, [0; 100]).unwrap();
    fs::write(&file, "").unwrap();
    // a file of another folder must be left alone
    let foreign = PathBuf::from(format!("/dev/shm/ca9-0.10.0-{:08x}_test{}", 0, std::process::id()));
    fs::write(&foreign, "").unwrap();
    // without a live process, they do not matter
    drop(Gateway::open(&place.site, &["key"]).unwrap());
    // with one that has the file open, they do
    let held = fs::File::open(&shm).unwrap();
    let e = Gateway::open(&place.site, &["key"]).err().expect("two versions at one place");
    assert!(e.kind == HostErrorKind::Version && e.what.contains("frame version 9"), "{e}");
    assert!(e.what.contains(&std::process::id().to_string()), "{e}");
    assert_eq!(DeviceClient::open(&place.site, about("key", 1)).err().unwrap().kind, HostErrorKind::Version);
    assert!(clean(&place.site).in_use.iter().any(|g| g.frames == "9"));
    assert!(shm.exists() && file.exists(), "the living keep theirs");
    drop(held);
    until("nobody has it open", || !list(&place.site).iter().any(|g| !g.alive.is_empty()));
    let cleaned = clean(&place.site);
    assert!(!shm.exists() && !file.exists() && foreign.exists());
    assert!(cleaned.removed.contains(&(shm, 100)));
    fs::remove_file(foreign).unwrap();
}

#[test]
fn frames_of_another_layout_under_our_name_are_refused() {
    use iceoryx2::prelude::*;
    let place = temp_site();
    let node = NodeBuilder::new().config(&place.site.config()).create::<ipc::Service>().unwrap();
    let name = ServiceName::new("ca/v1/key/in").unwrap();
    let _older = node.service_builder(&name).publish_subscribe::<u64>().create().unwrap();
    let e = DeviceClient::open(&place.site, about("key", 1)).err().expect("another layout");
    assert!(e.kind == HostErrorKind::Version && e.what.contains("ca/v1/key/in"), "{e}");
    assert!(Gateway::open(&place.site, &["key"]).err().unwrap().what.contains("another frame layout"));
    // opened with other queue settings
    let name = ServiceName::new("ca/v1/other/in").unwrap();
    let frames = node.service_builder(&name).publish_subscribe::<ca_haptic::frame::DeviceFrame>();
    let _careless = frames.enable_safe_overflow(false).create().unwrap();
    let e = DeviceClient::open(&place.site, about("other", 1)).err().expect("other queues");
    assert!(e.kind == HostErrorKind::Version && e.what.contains("other queue settings"), "{e}");
}
