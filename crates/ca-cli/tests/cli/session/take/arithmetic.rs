//! Tests takes of an older arithmetic. A take from before distances in space were kept from tick to tick agrees to a
//! tolerance, and larger differences are found. Without distances, such a take is compared to the bit.

use super::performer::{DUO, Performer, catalog};
use super::replay;
use ca_core::ARITHMETIC;
use ca_haptic::take::{Event, Replay, Take};
use std::path::Path;
use std::process::Command;

/// Three masses in space on springs and dampers, an LPR, and a pressed key; written with arithmetic 0.
const OLD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/takes/arithmetic-0.mcap");

#[test]
fn a_take_from_before_distances_were_kept_agrees_to_the_tolerance() {
    let take = Take::open(OLD).unwrap();
    assert_eq!(take.header.arithmetic, 0);
    let felt =
        take.events().unwrap().filter(|e| matches!(e, Ok(Event::Force(_, f)) if f.force[0].abs() > 1e-3)).count();
    assert!(felt > 50, "{felt} force frames are felt");
    let v = replay(Path::new(OLD));
    assert!(v.is_identical() && v.tolerance > 0.0, "{v:?}");
    assert!(v.forces >= 600 && v.samples >= 9600, "{v:?}");
    // compared to the bit, the take differs
    let mut strict = Take::open(OLD).unwrap();
    strict.header.arithmetic = ARITHMETIC;
    assert!(Replay::new(&strict, &catalog()).is_err(), "the state at load rounds otherwise");
    let said = Command::new(env!("CARGO_BIN_EXE_ca")).args(["replay", OLD, "--verify"]).output().unwrap();
    let text = String::from_utf8_lossy(&said.stdout);
    assert!(said.status.success() && text.contains("agrees     to 1e-9 of the peak"), "{text}");
    assert!(text.contains(&format!("arithmetic 0 in the take, {ARITHMETIC} here")), "{text}");
}

/// The replay uses a spring that is stiffer by one millionth.
#[test]
fn what_differs_by_more_is_found() {
    let mut take = Take::open(OLD).unwrap();
    take.header.changes.push(("edge.k".into(), "1000.001".into()));
    let mut replay = Replay::new(&take, &catalog()).unwrap();
    let v = replay.run(&take, &mut |_| (), &mut |_| Ok(())).unwrap();
    assert!(v.difference.is_some() && v.tolerance > 0.0, "{v:?}");
}

#[test]
fn without_distances_every_arithmetic_is_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let mut p = Performer::new(DUO, &path);
    p.play(800);
    p.finish();
    let mut take = Take::open(&path).unwrap();
    assert_eq!(take.header.arithmetic, ARITHMETIC);
    take.header.arithmetic = 0;
    let v = Replay::new(&take, &catalog()).unwrap().run(&take, &mut |_| (), &mut |_| Ok(())).unwrap();
    assert!(v.is_identical() && v.tolerance == 0.0, "{v:?}");
}

/// Contacts and springs with common masses, written with arithmetic 6, are solved as they were then.
#[test]
fn a_take_from_before_sweeps_replays_to_the_bit() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/takes/arithmetic-6.mcap");
    let mut take = Take::open(path).unwrap();
    assert_eq!(take.header.arithmetic, 6);
    let v = replay(Path::new(path));
    assert!(v.is_identical() && v.tolerance == 0.0 && v.samples >= 4000, "{v:?}");
    // with sweeps the last digits differ
    take.header.arithmetic = ARITHMETIC;
    let v = Replay::new(&take, &catalog()).unwrap().run(&take, &mut |_| (), &mut |_| Ok(())).unwrap();
    assert!(!v.is_identical(), "{v:?}");
}
