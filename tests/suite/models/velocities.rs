//! Every bundled instrument with MIDI notes, from the softest to the loudest velocity: each note is audible, a higher
//! velocity is never softer, and no new sound begins at its end.

use super::rendering::{file_names, load};
use crate::acoustics::{db, peak};
use ca_compile::{Options, compile};
use ca_core::Scene;
use ca_core::internal::io::midi::MidiSource;
use ca_io::gesture::{Gesture, GestureFormat, PortMap};
use ca_io::perform::Performance;
use ca_tests::catalog;
use ca_tests::long_form::long_form;
use std::collections::BTreeSet;

const VELOCITIES: [u8; 5] = [1, 20, 64, 100, 127];

/// Hands that damp: their notes reduce the sound. `a_palm_damps_at_any_velocity` tests them.
const DAMPERS: [(&str, u8); 2] = [("gong", 50), ("tam_tam", 50)];

/// Instruments whose damper lands with an intended soft thud, and its largest level relative to the softest note [dB].
/// It adds to what still rings.
const THUDS: [(&str, f64); 4] = [("hammer_piano", -2.0), ("piano24", -2.0), ("piano_key", -2.0), ("piano_wire", -2.0)];

/// A body that is thrown up falls later and sounds then.
const LATER: &str = "tossed_grains";

/// Start of a note, after loose bodies have come to rest, and length of a held note [s].
const BEGINS: f64 = 1.0;
const HELD: f64 = 2.0;
/// Lengths of notes, and listening time after them [s]. After a long note a mallet that leaves its rest is heard.
const LENGTHS: [f64; 3] = [0.1, 0.5, 2.0];
const AFTER: f64 = 0.3;
/// Velocities of notes whose end is tested: the softest masks least, the loudest moves most.
const ENDING: [u8; 2] = [1, 127];
/// Levels after the end are taken over parts of this length [s].
const PART: f64 = 0.05;
/// Listening time for a palm [s].
const LISTENS: f64 = 2.2;

/// A track of these events (second, status, key, velocity), in ticks of a millisecond.
fn midi(events: &[(f64, [u8; 3])]) -> Vec<u8> {
    let mut track = vec![0, 0xff, 0x51, 3, 0x0f, 0x42, 0x40];
    let mut last = 0;
    for (second, event) in events {
        let tick = (1000.0 * second) as u32;
        let delta = tick - last;
        track.extend([(delta >> 7) as u8 | 0x80, (delta & 0x7f) as u8]);
        track.extend(event);
        last = tick;
    }
    track.extend([0, 0xff, 0x2f, 0]);
    let mut file = b"MThd\0\0\0\x06\0\0\0\x01\x03\xe8MTrk".to_vec();
    file.extend((track.len() as u32).to_be_bytes());
    file.extend(track);
    file
}

/// All outputs for `seconds` under these events. Ports not moved by MIDI follow the model's own gesture.
fn play(scene: &Scene, events: &[(f64, [u8; 3])], seconds: f64) -> Vec<Vec<f64>> {
    let ports: Vec<PortMap> =
        scene.inputs.iter().filter_map(|i| Some(PortMap { port: i.name.clone(), map: i.midi? })).collect();
    let played = Gesture::read(GestureFormat::Midi, &midi(events), &ports, None).expect("it is MIDI");
    let mut p = Performance::new(scene, Some(&played)).unwrap();
    let mut out = vec![Vec::new(); scene.counts.channels];
    for _ in 0..(seconds * scene.rate) as usize {
        p.tick();
        out.iter_mut().zip(&p.state.output).for_each(|(o, v)| o.push(*v));
    }
    assert!(!p.diverged, "{}: diverged", scene.about.title);
    out
}

/// Level of the loudest channel from `t0` to `t1` [s, dBFS].
fn level(sound: &[Vec<f64>], rate: f64, t0: f64, t1: f64) -> f64 {
    sound.iter().map(|c| db(peak(&c[(t0 * rate) as usize..(t1 * rate) as usize]))).fold(-300.0, f64::max)
}

/// Faults of a note of this key.
fn faults(name: &str, scene: &Scene, key: u8) -> Vec<String> {
    let mut wrong = Vec::new();
    let (mut softer, mut softest) = (f64::MIN, f64::MAX);
    for velocity in VELOCITIES {
        let strike = (BEGINS, [0x90, key, velocity]);
        let held = play(scene, &[strike], BEGINS + HELD + AFTER);
        let early = level(&held, scene.rate, BEGINS, BEGINS + 0.5);
        let late = level(&held, scene.rate, BEGINS + 0.5, BEGINS + HELD);
        let note = early.max(late);
        if note < -60.0 {
            wrong.push(format!("{name}: key {key} at {velocity} is silent, {note:.1} dBFS"));
        }
        if note < softer - 0.5 {
            wrong.push(format!("{name}: key {key} at {velocity} has {note:.1} dBFS, a softer one {softer:.1}"));
        }
        if late > (early + 1.0).max(-60.0) && name != LATER {
            wrong.push(format!("{name}: key {key} at {velocity} sounds again: {early:.1}, then {late:.1} dBFS"));
        }
        (softer, softest) = (note, softest.min(note));
        if !ENDING.contains(&velocity) {
            continue;
        }
        for length in LENGTHS {
            let end = BEGINS + length;
            let sound = play(scene, &[strike, (end, [0x80, key, 0])], end + AFTER);
            let before = level(&sound, scene.rate, end - 0.1, end);
            let thud = THUDS.iter().find(|t| t.0 == name).map_or(-60.0, |t| softest + t.1);
            let amplitude = |db: f64| 10f64.powf(db / 20.0);
            // a sound no louder than before, or than in the held note, is not new
            let parts = (0..(AFTER / PART).round() as u32).map(|i| {
                let t = end + f64::from(i) * PART;
                let of = |x: &[Vec<f64>]| level(x, scene.rate, t, t + PART);
                (of(&sound), of(&held))
            });
            let (after, held) = parts.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            if after > (before + 1.0).max(held + 1.0).max(db(amplitude(held) + amplitude(thud))).max(-60.0) {
                wrong.push(format!(
                    "{name}: key {key} at {velocity} sounds as it ends after {length} s: {before:.1}, then {after:.1} dBFS, held {held:.1}"
                ));
            }
        }
    }
    wrong
}

fn scene(name: &str) -> Scene {
    compile(&load(name), &catalog(), &Options::default()).expect("it compiles").scene
}

/// Keys that ports listen to, the lowest of each port.
fn keys(scene: &Scene) -> BTreeSet<u8> {
    let low = |m: ca_core::internal::io::midi::MidiMap| match m.source {
        MidiSource::Note { low, .. } => Some(low),
        _ => None,
    };
    scene.inputs.iter().filter_map(|i| low(i.midi?)).collect()
}

#[test]
fn every_note_is_heard_and_louder_with_velocity_and_ends_quietly() {
    let whole = long_form("notes of every key, not of the lowest and the highest alone");
    let names = file_names();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let wrong = std::sync::Mutex::new(Vec::new());
    let played = std::sync::Mutex::new(0);
    std::thread::scope(|s| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            s.spawn(|| {
                while let Some(name) = names.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    let scene = scene(name);
                    let keys = keys(&scene);
                    let ends = [keys.first().copied(), keys.last().copied()];
                    for key in keys.iter().filter(|k| whole || ends.contains(&Some(**k))) {
                        if !DAMPERS.contains(&(name.as_str(), *key)) {
                            let found = faults(name, &scene, *key);
                            wrong.lock().unwrap().extend(found);
                            *played.lock().unwrap() += 1;
                        }
                    }
                }
            });
        }
    });
    let (wrong, played) = (wrong.into_inner().unwrap(), played.into_inner().unwrap());
    assert!(played >= 25, "only {played} keys are there to play");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_palm_damps_at_any_velocity() {
    for (name, palm) in DAMPERS {
        let scene = scene(name);
        let strike = (0.1, [0x90, 48, 100]);
        let off = (0.3, [0x80, 48, 0]);
        let rings = level(&play(&scene, &[strike, off], LISTENS), scene.rate, 2.0, LISTENS);
        for velocity in [1, 127] {
            let damped =
                level(&play(&scene, &[strike, off, (0.8, [0x90, palm, velocity])], LISTENS), scene.rate, 2.0, LISTENS);
            assert!(damped < rings - 6.0, "{name}, velocity {velocity}: {damped:.1} dBFS, without the palm {rings:.1}");
        }
    }
}
