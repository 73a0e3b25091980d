//! Snapshots: restored in another state of the same scene, play continues identically. Bytes that are not a snapshot of
//! this scene change nothing, and none makes a tick fail.

use crate::play::{audited, scene};
use ca_core::internal::state::SNAPSHOT_VERSION;
use ca_core::{NotRestored, Scene, State, tick};
use ca_tests::{KEY, gesture, texts};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Ticks before and after a snapshot: into a contact, and beyond two gesture frames.
const TICKS: [u64; 2] = [700, 150];

fn play(scene: &Scene, s: &mut State, ticks: u64) {
    for _ in 0..ticks {
        gesture(scene, s);
        tick(scene, s);
    }
}

#[test]
fn every_model_goes_on_from_a_snapshot() {
    for (name, text) in texts() {
        let scene = audited(&text).scene;
        let mut s = scene.state();
        play(&scene, &mut s, TICKS[0]);
        let bytes = s.to_bytes();
        let before = (s.bits(), s.ledger.clone());
        play(&scene, &mut s, TICKS[1]);
        // another compilation, in a state with a different history
        let again = audited(&text).scene;
        let mut other = again.state();
        play(&again, &mut other, 33);
        other.restore(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(other.bits(), before.0, "{name}");
        assert_eq!(other.to_bytes(), bytes, "{name}");
        let sums = |s: &State| s.ledger.as_ref().map(|l| l.balance());
        assert_eq!(sums(&other), before.1.map(|l| l.balance()), "{name}");
        play(&again, &mut other, TICKS[1]);
        assert_eq!(other.bits(), s.bits(), "{name}");
        assert_eq!(other.output, s.output, "{name}");
        assert_eq!(sums(&other), sums(&s), "{name}");
    }
}

const LIVE: &str = "[param]\ngrip = { value = \"500 N/m\", live = true, min = \"100 N/m\", max = \"5 kN/m\" }\n";

fn live_key() -> Scene {
    scene(&format!("{LIVE}{}", KEY.replace("k = 500", "k = \"grip\""))).scene
}

#[test]
fn what_is_on_its_way_arrives() {
    let scene = live_key();
    let mut s = scene.state();
    s.input[0] = 0.01;
    let patch = scene.controls().set("grip", 4000.0).expect("in range");
    assert!(s.apply(&patch, 100));
    (0..40).for_each(|_| tick(&scene, &mut s));
    let mut other = scene.state();
    other.restore(&s.to_bytes()).expect("a snapshot");
    assert!(other.ramps.is_moving());
    for _ in 0..100 {
        tick(&scene, &mut s);
        tick(&scene, &mut other);
        assert_eq!(other.bits(), s.bits());
    }
    assert!(!other.ramps.is_moving());
    assert_eq!(other.output, s.output);
}

#[test]
fn what_is_no_snapshot_of_this_scene_changes_nothing() {
    let scene_of = |k: &str| scene(&KEY.replace("500", k)).scene;
    let (mine, other) = (scene_of("500"), scene_of("600"));
    let mut s = mine.state();
    play(&mine, &mut s, 50);
    let (whole, mut target) = (s.to_bytes(), mine.state());
    let before = target.clone();
    let mut refuse = |bytes: &[u8], why: NotRestored| {
        assert_eq!(target.restore(bytes), Err(why));
        assert_eq!(target, before);
    };
    refuse(&[], NotRestored::NoSnapshot);
    refuse(b"RIFF....WAVE....", NotRestored::NoSnapshot);
    refuse(&other.state().to_bytes(), NotRestored::OtherScene);
    refuse(&State::default().to_bytes(), NotRestored::OtherScene);
    let mut later = whole.clone();
    later[8] += 1;
    refuse(&later, NotRestored::Version(SNAPSHOT_VERSION + 1));
    for n in 8..whole.len() {
        refuse(&whole[..n], NotRestored::Damaged);
        let mut changed = whole.clone();
        changed[n] ^= 0x10;
        assert!(mine.state().restore(&changed).is_err(), "byte {n}");
    }
    refuse(&[&whole[..], &[0]].concat(), NotRestored::Damaged);
    let said = NotRestored::OtherScene.to_string();
    assert!(said.contains("another scene") && said.contains("rate"), "{said}");
}

/// Snapshots with a valid checksum, made so that a tick would fail.
#[test]
fn no_snapshot_makes_a_tick_fail() {
    let fnv = |bytes: &[u8]| {
        bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
    };
    let moving = "[STRING]\nlow = { n = 8, f = \"110 Hz\", t60 = 1, m = \"1 g\" }\n[ENX]\nbow = {}\nalong = { x = \"0.3 m\" }\n\
                  [FRO]\nrub = { between = [\"bow\", \"low@along\"], z = 0.1 }\n[SOX]\nout = { from = \"low[3]\" }\n";
    for text in [format!("{LIVE}{}", KEY.replace("k = 500", "k = \"grip\"")), moving.into()] {
        let scene = scene(&text).scene;
        let mut s = scene.state();
        if let Ok(patch) = scene.controls().set("grip", 1000.0) {
            assert!(s.apply(&patch, 100));
        }
        play(&scene, &mut s, 20);
        let whole = s.to_bytes();
        let (mut taken, words) = (0, (whole.len() - 32) / 8);
        for at in 0..words {
            for value in [0, 1, 2, 7, 1000, u64::MAX, f64::NAN.to_bits(), f64::MAX.to_bits()] {
                let mut bytes = whole.clone();
                bytes[24 + 8 * at..][..8].copy_from_slice(&value.to_le_bytes());
                let end = bytes.len() - 8;
                let sum = fnv(&bytes[..end]);
                bytes[end..].copy_from_slice(&sum.to_le_bytes());
                let mut s = scene.state();
                if s.restore(&bytes).is_ok() {
                    taken += 1;
                    let fine = catch_unwind(AssertUnwindSafe(|| play(&scene, &mut s, 200)));
                    assert!(fine.is_ok(), "number {at} as {value:x}");
                }
            }
        }
        assert!(taken > words, "{taken} of {words} numbers with eight values each");
    }
}
