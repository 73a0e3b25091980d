//! Tests takes: recorded data is read back, and a replay is identical to the bit.

mod arithmetic;
mod command;
mod damage;
mod kill;
pub mod performer;
mod python;

use ca_haptic::take::{Event, Replay, ReplayVerdict, Take};
use performer::{DUO, Performer, catalog};
use std::path::Path;

pub fn replay(path: &Path) -> ReplayVerdict {
    let take = Take::open(path).unwrap();
    Replay::new(&take, &catalog()).unwrap().run(&take, &mut |_| (), &mut |_| Ok(())).unwrap()
}

#[test]
fn a_replay_is_the_same_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let mut p = Performer::new(DUO, &path);
    p.play(2500);
    let reported = p.finish();
    assert_eq!(reported.lost, 0);
    assert!(p.sound.iter().any(|x| x.abs() > 0.01), "it is heard");
    let v = replay(&path);
    assert_eq!((v.difference.clone(), v.hole, v.cut.clone()), (None, None, None), "{v:?}");
    assert!(v.is_identical());
    assert_eq!((v.frames, v.forces, v.taken), (2500, 5000, p.engine.counts.taken + p.engine.counts.dropped));
    assert_eq!((v.samples, v.hashes), (p.sound.len() as u64, 8));
    assert_eq!(v.seconds, p.engine.due() as f64 / 48_000.0);
    let take = Take::open(&path).unwrap();
    let count = |f: &dyn Fn(&Event) -> bool| take.events().unwrap().filter(|e| f(e.as_ref().unwrap())).count();
    assert_eq!(count(&|e| matches!(e, Event::Change(..))), 2);
    assert_eq!(count(&|e| matches!(e, Event::Order(..))), 4);
    assert_eq!(count(&|e| matches!(e, Event::Reload(_))), 1);
    assert_eq!(count(&|e| matches!(e, Event::Energy(_))), 8);
    let on = |e: &Event| matches!(e, Event::Force(0, f) if f.mode == 2 && f.force[0].abs() > 0.1);
    assert!(count(&on) > 100, "forces were felt");
    assert!(p.engine.counts.dropped > 0, "frames were refused");
}

/// With several ticks per sample, a take counts samples, and the same hand positions give another motion.
#[test]
fn a_replay_of_finer_ticks_is_the_same_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let played = |text: &str, path: &Path| {
        let mut p = Performer::new(text, path);
        p.play(1600);
        p.finish();
        p
    };
    let plain = played(DUO, &dir.path().join("b.mcap"));
    let p = played(&format!("{DUO}[rate]\noversample = 3\n"), &path);
    assert!(p.sound.iter().any(|x| x.abs() > 0.01), "it is heard");
    assert_eq!((p.engine.due(), p.sound.len()), (plain.engine.due(), plain.sound.len()));
    assert!(p.engine.state.bits() != plain.engine.state.bits());
    let v = replay(&path);
    assert!(v.is_identical(), "{v:?}");
    assert_eq!((v.frames, v.samples), (1600, p.sound.len() as u64));
    assert_eq!(v.seconds, p.engine.due() as f64 / 48_000.0);
}

#[test]
fn the_sound_in_it_is_the_sound_that_was() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let p = performer::duo(&path, 1600);
    let take = Take::open(&path).unwrap();
    let mut heard = Vec::new();
    for e in take.events().unwrap() {
        if let Event::Sound(tick, samples) = e.unwrap() {
            assert_eq!(tick as usize * 2, heard.len(), "no gap");
            heard.extend(samples);
        }
    }
    assert!(heard.iter().map(|x| x.to_bits()).eq(p.sound.iter().map(|x| x.to_bits())));
}

#[test]
fn a_take_played_on_its_own_model_gives_its_sound() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let mut p = Performer::new(DUO, &path);
    p.frames(500);
    p.set("stiff", 731.0);
    p.frames(700);
    p.set("stiff", 150.0);
    p.frames(400);
    p.finish();
    let gesture = ca_haptic::take::gesture(&path, &catalog()).unwrap();
    let mut names: Vec<&str> = gesture.tracks().iter().map(ca_io::gesture::Track::name).collect();
    names.sort_unstable();
    assert_eq!(names, ["key", "pad", "stiff"]);
    let scene = Take::open(&path).unwrap().header.scene(&catalog()).unwrap();
    let mut again = ca_io::perform::Performance::new(&scene, Some(&gesture)).unwrap();
    // the engine fades in over 50 ms; a render does not
    let faded = 2400;
    let mut loud = 0;
    for (n, frame) in p.sound.chunks_exact(2).enumerate() {
        again.tick();
        if n > faded {
            assert_eq!(again.state.output[..2], *frame, "sample {n}");
            loud += u64::from(frame[0].abs() > 0.001);
        }
    }
    assert!(loud > 1000);
}

#[test]
fn the_layouts_name_what_there_is() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    performer::tgr12(&path);
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().expect("a summary");
    let fields = |topic: &str| {
        let channel = summary.channels.values().find(|c| c.topic == topic).unwrap_or_else(|| panic!("no {topic}"));
        let schema = channel.schema.as_ref().expect("a schema");
        (schema.encoding.clone(), String::from_utf8_lossy(&schema.data).into_owned())
    };
    let read = |name: &str| std::fs::read_to_string(crate::sandbox::from_root(name)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&read("crates/ca-haptic/layouts/ca-foxglove.json")).unwrap();
    let mut named: Vec<(String, String)> = Vec::new();
    for (id, panel) in json["configById"].as_object().unwrap() {
        assert!(json["layout"].to_string().contains(id.as_str()), "{id} is nowhere");
        for p in panel["paths"].as_array().into_iter().flatten() {
            let (topic, field) = p["value"].as_str().unwrap().split_once('.').unwrap();
            named.push((topic.into(), field.rsplit('.').next().unwrap().into()));
        }
        named.extend(panel["topics"].as_object().into_iter().flatten().map(|t| (t.0.clone(), String::new())));
    }
    let xml = read("crates/ca-haptic/layouts/ca-plotjuggler.xml");
    for curve in xml.split("<curve name=\"").skip(1) {
        let curve = curve.split('"').next().unwrap();
        let (topic, field) = curve.rsplit_once('/').unwrap();
        named.push((topic.into(), field.split('[').next().unwrap().into()));
    }
    assert!(named.len() > 20);
    for (topic, field) in named {
        let (encoding, text) = fields(&topic);
        if encoding == "ros2msg" {
            let found = text.lines().any(|l| l.split(' ').nth(1) == Some(field.as_str()));
            assert!(found, "`{topic}` has no `{field}`");
        } else {
            // a descriptor contains the names of its fields
            assert!(text.contains(&field), "`{topic}` has no `{field}`");
        }
    }
    assert_eq!(fields("/log").0, "protobuf");
}
