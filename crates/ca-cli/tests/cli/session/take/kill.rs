//! Tests a program killed while it plays: everything written until shortly before is kept and replays.
//!
//! The program is this test binary, run with an ignored test that plays until it is killed.

use super::performer::{DUO, Performer, catalog};
use super::replay;
use ca_haptic::take::{End, Take, recover};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PLACE: &str = "CA_TEST_TAKE";

#[test]
#[ignore = "run by another test, in a process of its own, until it is killed"]
fn plays_until_it_is_killed() {
    let Some(path) = std::env::var_os(PLACE).map(PathBuf::from) else { return };
    let mut p = Performer::new(DUO, &path);
    p.command(ca_haptic::engine::EngineCommand::Order(None, ca_haptic::guard::Order::Arm));
    let begin = Instant::now();
    // at most two minutes, in case it is not killed
    for n in 1..=360_000_u32 {
        p.frame();
        // plays in real time
        let due = Duration::from_secs_f64(f64::from(n) / 3000.0);
        if let Some(rest) = due.checked_sub(begin.elapsed()).filter(|r| r.as_millis() > 2) {
            std::thread::sleep(rest);
        }
        // reports its progress; the rename avoids an empty file if it is killed between two writes
        if n.is_multiple_of(30) {
            let next = path.with_extension("next");
            std::fs::write(&next, p.engine.due().to_string()).unwrap();
            std::fs::rename(&next, path.with_extension("reported")).unwrap();
        }
    }
}

#[test]
fn a_killed_take_loses_less_than_a_second_and_replays() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("killed.mcap");
    let here = module_path!().split_once("::").expect("below the crate").1;
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", &format!("{here}::plays_until_it_is_killed"), "--ignored"])
        .env(PLACE, &path)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let reported = || std::fs::read_to_string(path.with_extension("reported")).ok()?.parse::<u64>().ok();
    let begin = Instant::now();
    while reported().unwrap_or(0) < 3 * 48_000 {
        assert!(begin.elapsed() < Duration::from_secs(30), "it does not play");
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let reached = reported().unwrap();

    let cut = replay(&path);
    assert!(cut.cut.is_some() && cut.difference.is_none(), "{cut:?}");
    let take = Take::open(&path).unwrap();
    let summary = take.summary().unwrap();
    assert!(matches!(summary.end, End::Cut(..)));
    if summary.lost == [0; 3] {
        assert!(cut.is_identical());
        // counted in sound samples, not by a clock
        let (end, at) = (cut.seconds, reached as f64 / 48_000.0);
        assert!(at - end < 1.0, "played up to {at} s, and {end} s are there");
        assert!(cut.frames >= 6000 && cut.hashes >= 10);
    }

    // the recovered file contains the same messages
    let whole = dir.path().join("whole.mcap");
    let saved = recover(&path, &whole).unwrap();
    assert!(saved.cut.is_some());
    let again = replay(&whole);
    assert_eq!(again.cut, None);
    assert_eq!((again.frames, again.forces, again.samples), (cut.frames, cut.forces, cut.samples));
    assert_eq!(again.is_identical(), cut.is_identical());
    let full = Take::open(&whole).unwrap().summary().unwrap();
    assert_eq!((full.topics, full.end, full.lost), (summary.topics.clone(), End::Whole, summary.lost));
    let messages: u64 = summary.topics.values().map(|t| t.messages).sum();
    assert_eq!(saved.messages, messages);
    // the index agrees
    let bytes = std::fs::read(&whole).unwrap();
    let index = mcap::Summary::read(&bytes).unwrap().expect("a summary");
    assert_eq!(index.stats.expect("statistics").message_count, messages);
    assert!(take.header.scene(&catalog()).is_ok());
}
