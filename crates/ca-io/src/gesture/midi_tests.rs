//! Tests of [`super`] and of `smf.rs`, with files written byte by byte.

use super::*;
use crate::error::FileErrorKind;
use ca_core::internal::io::midi::Velocity;

/// Makes a file of this format and timing, each track given as (delta, bytes of the event) without its end.
fn file(format: u16, timing: u16, tracks: &[&[(u32, &[u8])]]) -> Vec<u8> {
    let mut b = b"MThd\0\0\0\x06".to_vec();
    b.extend(format.to_be_bytes());
    b.extend((tracks.len() as u16).to_be_bytes());
    b.extend(timing.to_be_bytes());
    for events in tracks {
        let mut t = Vec::new();
        for (delta, bytes) in *events {
            let groups = (0..4).rev().map(|i| (delta >> (7 * i)) & 0x7f).skip_while(|g| *g == 0).collect::<Vec<_>>();
            let groups = if groups.is_empty() { vec![0] } else { groups };
            for (i, g) in groups.iter().enumerate() {
                t.push(*g as u8 | if i + 1 < groups.len() { 0x80 } else { 0 });
            }
            t.extend(*bytes);
        }
        t.extend([0, 0xff, 0x2f, 0]);
        b.extend(b"MTrk");
        b.extend((t.len() as u32).to_be_bytes());
        b.extend(t);
    }
    b
}

fn port(name: &str, source: MidiSource, channel: Option<u8>) -> PortMap {
    let map = MidiMap { source, channel, from: 1.0, to: 2.0, attack: 0.25, release: 0.5, ..MidiMap::new(source) };
    PortMap { port: name.to_owned(), map }
}

fn key() -> PortMap {
    port("key", MidiSource::Note { low: 60, high: 72 }, None)
}

/// Ticks per beat: at 120 beats a minute, a tick is a millisecond.
const MS: u16 = 500;

fn one(map: PortMap, events: &[(u32, &[u8])]) -> Track {
    read(&file(0, MS, &[events]), &[map]).unwrap().tracks()[0].clone()
}

fn velocity(v: f64) -> f64 {
    1.0 + v / 127.0
}

#[test]
fn a_note_glides_up_holds_and_glides_back() {
    let t = one(key(), &[(1000, &[0x90, 60, 127]), (1000, &[0x80, 60, 64])]);
    for (time, want) in
        [(0.0, 1.0), (1.0, 1.0), (1.125, 1.5), (1.25, 2.0), (1.9, 2.0), (2.0, 2.0), (2.25, 1.5), (2.5, 1.0), (9.0, 1.0)]
    {
        assert_eq!(t.at(time), want, "at {time}");
    }
    assert_eq!(t.duration(), 2.5);
    let t = one(key(), &[(0, &[0x90, 60, 100])]);
    assert_eq!(t.at(1.0), velocity(100.0));
}

#[test]
fn running_status_and_velocity_0() {
    let status = one(key(), &[(0, &[0x90, 60, 127]), (1000, &[0x90, 60, 0]), (1000, &[0x90, 61, 64])]);
    let running = one(key(), &[(0, &[0x90, 60, 127]), (1000, &[60, 0]), (1000, &[61, 64])]);
    assert_eq!(status, running);
    assert_eq!((running.at(0.9), running.at(1.5), running.at(2.25)), (2.0, 1.0, velocity(64.0)));
}

#[test]
fn running_status_goes_on_after_meta_and_system_exclusive_events_with_a_remark() {
    let plain = file(0, MS, &[&[(0, &[0x90, 60, 127]), (1000, &[0x90, 60, 0])]]);
    let plain = read(&plain, &[key()]).unwrap();
    for between in [&[0xff, 1, 1, 0x41][..], &[0xf0, 5, 0x7e, 0x7f, 9, 1, 0xf7], &[0xf7, 1, 0x41]] {
        let g = read(&file(0, MS, &[&[(0, &[0x90, 60, 127]), (0, between), (1000, &[60, 0])]]), &[key()]).unwrap();
        assert_eq!(g.tracks(), plain.tracks());
        let [remark] = g.remarks() else { panic!("{:?}", g.remarks()) };
        assert!(remark.starts_with("running status continues once"), "{remark}");
    }
    // an event with a status byte needs no remark
    let events: &[(u32, &[u8])] = &[(0, &[0x90, 60, 127]), (0, &[0xff, 1, 1, 0x41]), (1000, &[0x90, 60, 0])];
    assert_eq!(read(&file(0, MS, &[events]), &[key()]).unwrap(), plain);
    // another track begins without a status
    let tracks: [&[(u32, &[u8])]; 2] = [&[(0, &[0x90, 60, 127])], &[(0, &[0xff, 1, 1, 0x41]), (0, &[60, 0])]];
    assert!(read(&file(1, MS, &tracks), &[key()]).is_err());
}

#[test]
fn all_tracks_are_read_whatever_the_header_announces() {
    let one: &[(u32, &[u8])] = &[(0, HIT)];
    let two: &[(u32, &[u8])] = &[(500, HIT)];
    let mut bytes = file(1, MS, &[one, two]);
    assert!(read(&bytes, &[key()]).unwrap().remarks().is_empty());
    bytes[11] = 1;
    assert_eq!(times(&bytes), [0.0, 0.5]);
    let g = read(&bytes, &[key()]).unwrap();
    assert_eq!(g.remarks(), ["its header announces 1 of its 2 tracks; all are read"]);
    bytes[11] = 5;
    let g = read(&bytes, &[key()]).unwrap();
    assert_eq!(g.remarks(), ["its header announces 5 tracks, but it has 2; the file may be cut short"]);
    bytes[11] = 1;
    // not a track, but data that some program left behind the last one
    bytes.extend(*b"TAG\0\xff\xff\xff\xff\x01");
    assert_eq!(times(&bytes), [0.0, 0.5]);
    bytes[11] = 3;
    assert!(read(&bytes, &[key()]).is_err());
}

#[test]
fn a_file_in_a_riff_container_is_read() {
    let plain = file(0, MS, &[&[(0, HIT), (1000, HIT)]]);
    let wrap = |form: &[u8], chunks: &[(&[u8], &[u8])]| {
        let mut b = form.to_vec();
        for (id, body) in chunks {
            b.extend(*id);
            b.extend((body.len() as u32).to_le_bytes());
            b.extend(*body);
            b.extend(&[0][..body.len() % 2]);
        }
        [b"RIFF", &(b.len() as u32).to_le_bytes()[..], &b].concat()
    };
    for chunks in [&[(&b"data"[..], &plain[..])][..], &[(b"DISP", b"odd"), (b"data", &plain)]] {
        assert_eq!(times(&wrap(b"RMID", chunks)), times(&plain));
    }
    for bad in [wrap(b"WAVE", &[(b"data", &plain)]), wrap(b"RMID", &[(b"DISP", &plain)]), b"RIFF".to_vec()] {
        assert_eq!(read(&bad, &[key()]).unwrap_err().kind, FileErrorKind::Format);
    }
    let whole = wrap(b"RMID", &[(b"data", &plain)]);
    for missing in 2..whole.len() {
        assert!(read(&whole[..whole.len() - missing], &[key()]).is_err(), "{missing} bytes short");
    }
}

#[test]
fn a_release_during_the_attack_starts_from_there() {
    let t = one(key(), &[(0, &[0x90, 60, 127]), (125, &[0x80, 60, 0])]);
    assert_eq!((t.at(0.125), t.at(0.375), t.at(0.625)), (1.5, 1.25, 1.0));
}

#[test]
fn the_newest_note_wins_and_its_release_falls_back() {
    let t = one(
        key(),
        &[
            (0, &[0x90, 60, 127]),
            (1000, &[0x90, 64, 32]),
            (1000, &[0x90, 67, 64]),
            (1000, &[0x80, 64, 0]), // not the newest: nothing moves
            (1000, &[0x80, 67, 0]), // back to note 60
            (1000, &[0x80, 60, 0]),
        ],
    );
    let held = [(0.9, 127.0), (1.9, 32.0), (2.9, 64.0), (3.9, 64.0), (4.25, 127.0), (4.9, 127.0)];
    for (time, v) in held {
        assert_eq!(t.at(time), velocity(v), "at {time}");
    }
    assert_eq!((t.at(5.25), t.at(5.5)), (1.5, 1.0));
    // the same key twice is one key; the same key on another channel is another
    let t = one(key(), &[(0, &[0x90, 60, 127]), (500, &[0x90, 60, 64]), (500, &[0x80, 60, 0])]);
    assert_eq!((t.at(0.75), t.at(1.5)), (velocity(64.0), 1.0));
    let t = one(key(), &[(0, &[0x90, 60, 127]), (500, &[0x91, 60, 64]), (500, &[0x81, 60, 0])]);
    assert_eq!(t.at(1.5), 2.0);
    // all notes off
    let t = one(key(), &[(0, &[0x90, 60, 127]), (500, &[0x90, 61, 64]), (500, &[0xb0, 123, 0])]);
    assert_eq!(t.at(1.5), 1.0);
}

#[test]
fn controllers_bend_and_pressure() {
    let t = one(port("x", MidiSource::Control(7), None), &[(0, &[0xb0, 7, 127]), (0, &[8, 3]), (500, &[7, 0])]);
    assert_eq!((t.at(0.0), t.at(0.125), t.at(0.25), t.at(0.625), t.at(0.75)), (1.0, 1.5, 2.0, 1.5, 1.0));
    let t = one(port("x", MidiSource::Pressure, None), &[(0, &[0xd0, 127])]);
    assert_eq!(t.at(0.25), 2.0);
    let bend = port("x", MidiSource::PitchBend, None);
    let t = one(
        bend,
        &[(1000, &[0xe0, 0x7f, 0x7f]), (1000, &[0xe0, 0, 0]), (1000, &[0xe0, 0, 0x40]), (1000, &[0xe0, 0, 0x20])],
    );
    let seen: Vec<f64> = [0.0, 1.5, 2.5, 3.5, 4.5].iter().map(|s| t.at(*s)).collect();
    assert_eq!(seen, [1.5, 2.0, 1.0, 1.5, 1.25]);
}

#[test]
fn channels_choose_and_unmoved_ports_rest() {
    let ports = [
        port("a", MidiSource::Note { low: 0, high: 127 }, Some(1)),
        port("b", MidiSource::Note { low: 0, high: 127 }, Some(2)),
        port("c", MidiSource::Control(1), None),
        port("d", MidiSource::PitchBend, None),
    ];
    let g = read(&file(0, MS, &[&[(100, &[0x91, 5, 127])]]), &ports).unwrap();
    let last: Vec<f64> = g.tracks().iter().map(|t| t.at(9.0)).collect();
    assert_eq!(last, [1.0, 2.0, 1.0, 1.5]);
    assert_eq!(g.tracks().iter().filter(|t| t.moves()).count(), 1);
}

#[test]
fn an_attack_of_0_is_a_jump() {
    let mut p = key();
    p.map.attack = 0.0;
    let t = one(p, &[(1000, &[0x90, 60, 127])]);
    assert_eq!((t.at(0.999_999), t.at(1.0)), (1.0, 2.0));
}

/// Returns the times at which note 60 is struck.
fn times(bytes: &[u8]) -> Vec<f64> {
    let hits = smf::messages(bytes).unwrap().events;
    hits.iter().filter(|e| matches!(e.message, MidiMessage::NoteOn { .. })).map(|e| e.time).collect()
}

const HIT: &[u8] = &[0x90, 60, 1];
const BPM_60: &[u8] = &[0xff, 0x51, 3, 0x0f, 0x42, 0x40];
const BPM_240: &[u8] = &[0xff, 0x51, 3, 0x03, 0xd0, 0x90];

#[test]
fn tempo_changes_land_exactly() {
    // 120 beats a minute, 60 after a beat, then 240 after another; 96 ticks a beat
    let inside = file(0, 96, &[&[(0, HIT), (96, BPM_60), (0, HIT), (96, BPM_240), (0, HIT), (96, HIT), (48, HIT)]]);
    assert_eq!(times(&inside), [0.0, 0.5, 1.5, 1.75, 1.875]);
    // the same with the tempo in a separate track, which may come last
    let tempo: &[(u32, &[u8])] = &[(96, BPM_60), (96, BPM_240)];
    let notes: &[(u32, &[u8])] = &[(0, HIT), (96, HIT), (96, HIT), (96, HIT), (48, HIT)];
    assert_eq!(times(&file(1, 96, &[tempo, notes])), [0.0, 0.5, 1.5, 1.75, 1.875]);
    assert_eq!(times(&file(1, 96, &[notes, tempo])), [0.0, 0.5, 1.5, 1.75, 1.875]);
    // a million ticks of a third of a millisecond each do not drift
    let many: Vec<(u32, &[u8])> = (0..3000).map(|_| (1000, HIT)).collect();
    let t = times(&file(0, 1500, &[&many]));
    assert_eq!((t[2], t[2999]), (1.0, 1000.0));
}

#[test]
fn smpte_time_knows_no_tempo() {
    let at = |fps: i8, sub: u8| {
        let timing = u16::from_be_bytes([(-fps) as u8, sub]);
        times(&file(0, timing, &[&[(0, BPM_60), (1000, HIT), (0, BPM_240), (1000, HIT)]]))
    };
    assert_eq!(at(25, 40), [1.0, 2.0]);
    assert_eq!(at(24, 10), [1000.0 / 240.0, 2000.0 / 240.0]);
    assert_eq!(at(30, 100), [1.0 / 3.0, 2.0 / 3.0]);
    assert_eq!(at(29, 100), [1001.0 / 3000.0, 2002.0 / 3000.0]);
}

#[test]
fn tracks_merge_in_order_within_a_tick() {
    let one: &[(u32, &[u8])] = &[(10, &[0x90, 1, 1]), (0, &[0x90, 2, 1])];
    let two: &[(u32, &[u8])] = &[(5, &[0x90, 3, 1]), (5, &[0x90, 4, 1])];
    let events = smf::messages(&file(1, 96, &[one, two])).unwrap().events;
    let keys: Vec<u8> =
        events.iter().map(|e| if let MidiMessage::NoteOn { key, .. } = e.message { key.as_int() } else { 0 }).collect();
    assert_eq!(keys, [3, 1, 2, 4]);
}

#[test]
fn says_what_the_file_has() {
    let bytes =
        file(0, MS, &[&[(0, &[0x99, 36, 9]), (0, &[52, 9]), (0, &[0xb0, 1, 5]), (0, &[64, 5]), (0, &[0xe0, 0, 0])]]);
    let e = read(&bytes, &[key(), port("f", MidiSource::Control(7), Some(3))]).unwrap_err();
    assert_eq!(
        e.what,
        "no event in it moves `key` (notes 60 to 72) and `f` (controller 7, channel 3): it has controllers 1 and 64 \
         and pitch bend on channel 1, notes 36 to 52 on channel 10"
    );
    let e = read(&file(0, MS, &[&[]]), &[key()]).unwrap_err();
    assert!(e.what.ends_with("it has no notes or controllers"), "{e}");
    // releasing a note that was never struck moves nothing
    assert!(read(&file(0, MS, &[&[(0, &[0x80, 60, 0])]]), &[key()]).is_err());
}

#[test]
fn refuses_what_it_would_misread() {
    let kind = |bytes: &[u8]| read(bytes, &[key()]).unwrap_err().kind;
    let good = file(1, MS, &[&[(0, HIT)], &[(0, HIT)]]);
    assert!(read(&good, &[key()]).is_ok());
    assert_eq!(kind(&file(2, MS, &[&[(0, HIT)]])), FileErrorKind::Unsupported);
    assert_eq!(kind(&file(0, 0, &[&[(0, HIT)]])), FileErrorKind::Format);
    assert_eq!(kind(&file(0, 0xe700, &[&[(0, HIT)]])), FileErrorKind::Format);
    for frames in [0x80u16, 0x81, 0xff] {
        assert_eq!(kind(&file(0, frames << 8 | 4, &[&[(0, HIT)]])), FileErrorKind::Unsupported);
    }
    assert_eq!(kind(b"MThd"), FileErrorKind::Format);
    assert_eq!(kind(b""), FileErrorKind::Format);
    assert_eq!(kind(&file(0, MS, &[&[(0, &[0xff, 0x51, 3, 0, 0, 0]), (0, HIT)]])), FileErrorKind::Content);
    // a file without the whole second track is read, with a remark
    let track = file(1, MS, &[&[(0, HIT)]]).len() - 14;
    assert_eq!(read(&good[..good.len() - track], &[key()]).unwrap().remarks().len(), 1);
    for missing in (1..good.len()).filter(|n| *n != track) {
        assert_eq!(kind(&good[..good.len() - missing]), FileErrorKind::Format, "{missing} bytes short");
    }
    let e = read(&file(0, MS, &[&[(0, HIT), (3, &[0xf4])]]), &[key()]).unwrap_err();
    assert_eq!(e.place, "track 1, event 2, byte 4 of the track");
    // ports
    assert_eq!(read(&good, &[]).unwrap_err().kind, FileErrorKind::Usage);
    let mut p = key();
    p.map.attack = -1.0;
    assert_eq!(read(&good, &[p.clone()]).unwrap_err().kind, FileErrorKind::Usage);
    p.map.attack = f64::NAN;
    assert_eq!(read(&good, &[p]).unwrap_err().kind, FileErrorKind::Usage);
    assert!(read(&good, &[key(), key()]).unwrap_err().what.contains("two tracks"));
}

#[test]
fn a_velocity_may_be_how_fast_it_goes() {
    let mut map = key();
    map.map.velocity = Velocity::Speed;
    let t =
        one(map, &[(1000, &[0x90, 60, 127]), (1000, &[0x80, 60, 0]), (1000, &[0x90, 60, 32]), (2000, &[0x80, 60, 0])]);
    // the full range, in a quarter of a second at velocity 127; the speed decreases linearly to a fifth of that
    let slow = 0.25 / (0.2 + 0.8 * 32.0 / 127.0);
    for (time, want) in
        [(1.125, 1.5), (1.25, 2.0), (2.25, 1.5), (2.5, 1.0), (3.0 + 0.5 * slow, 1.5), (3.0 + slow, 2.0), (5.5, 1.0)]
    {
        assert!((t.at(time) - want).abs() < 1e-12, "at {time}: {}", t.at(time));
    }
}

#[test]
fn a_velocity_may_say_nothing() {
    let mut map = key();
    map.map.velocity = Velocity::None;
    let loud = one(map.clone(), &[(1000, &[0x90, 60, 127]), (1000, &[0x80, 60, 0])]);
    let soft = one(map, &[(1000, &[0x90, 60, 1]), (1000, &[0x80, 60, 0])]);
    assert_eq!(loud, soft);
    assert_eq!((soft.at(1.125), soft.at(1.25), soft.at(2.5)), (1.5, 2.0, 1.0));
}

#[test]
fn a_plectrum_goes_to_its_other_side_with_each_note_and_never_back_alone() {
    let mut map = key();
    map.map.back = false;
    let events: &[(u32, &[u8])] = &[
        (1000, &[0x90, 60, 127]),
        (500, &[0x80, 60, 0]),
        (1500, &[0x90, 62, 64]),
        (500, &[0x80, 62, 0]),
        (500, &[0x90, 60, 64]),
        (100, &[0xb0, 123, 0]),
    ];
    let t = one(map, events);
    for (time, want) in
        [(0.9, 1.0), (1.25, 2.0), (2.9, 2.0), (3.25, 1.0), (3.9, 1.0), (4.25, velocity(64.0)), (9.0, velocity(64.0))]
    {
        assert!((t.at(time) - want).abs() < 1e-12, "at {time}: {}", t.at(time));
    }
}

#[test]
fn notes_that_move_nothing_are_named() {
    let events: &[(u32, &[u8])] =
        &[(0, &[0x90, 60, 127]), (1, &[0x90, 40, 1]), (1, &[0x90, 40, 0]), (1, &[0x99, 36, 9]), (1, &[0x99, 36, 9])];
    let g = read(&file(0, MS, &[events]), &[key()]).unwrap();
    assert_eq!(g.remarks(), ["3 notes move no port: 40 on channel 1; 36 on channel 10"]);
    let g = read(&file(0, MS, &[&[(0, &[0x90, 60, 127])]]), &[key()]).unwrap();
    assert!(g.remarks().is_empty());
}

#[test]
fn the_pedal_holds_notes_until_it_is_up() {
    // pedal down after the key; key up at 1 s, pedal up at 2 s
    let held: &[(u32, &[u8])] = &[
        (0, &[0x90, 60, 127]),
        (500, &[0xb0, 64, 64]),
        (500, &[0x80, 60, 0]),
        (500, &[0xb1, 64, 0]),
        (500, &[0xb0, 64, 63]),
    ];
    let t = one(key(), held);
    for (time, want) in [(0.25, 2.0), (1.25, 2.0), (2.0, 2.0), (2.25, 1.5), (2.5, 1.0)] {
        assert_eq!(t.at(time), want, "at {time}");
    }
    // a key down when the pedal comes up stays held; all sound off ends notes held by the pedal, all notes off does not
    let pedal = |last: &[u8]| -> f64 {
        one(key(), &[(0, &[0xb0, 64, 127]), (0, &[0x90, 60, 127]), (500, last), (500, &[0xb0, 64, 0])]).at(0.75)
    };
    assert_eq!([pedal(&[0xb0, 123, 0]), pedal(&[0xb0, 120, 0]), pedal(&[0xb0, 121, 0])], [2.0, 1.5, 2.0]);
    let t = one(key(), &[(0, &[0xb0, 64, 127]), (0, &[0x90, 60, 127]), (500, &[0xb0, 64, 0])]);
    assert_eq!(t.at(9.0), 2.0);
    // a plectrum (`back = false`) does not return, whatever the pedal does
    let mut map = key();
    map.map.back = false;
    let events: &[(u32, &[u8])] = &[(0, &[0xb0, 64, 127]), (0, &[0x90, 60, 127]), (500, &[60, 0])];
    assert_eq!(one(map.clone(), events), one(map, &events[1..2]));
}

#[test]
fn a_note_that_the_pedal_alone_holds_comes_up_before_the_next_one() {
    let again: &[(u32, &[u8])] = &[
        (0, &[0xb0, 64, 127]),
        (0, &[0x90, 60, 127]),
        (1000, &[0x80, 60, 0]),
        (1000, &[0x90, 62, 64]),
        (1000, &[0x80, 62, 0]),
        (1000, &[0xb0, 64, 0]),
    ];
    let t = one(key(), again);
    let there = velocity(64.0);
    for (time, want) in [(2.0, 2.0), (2.25, 1.5), (2.5, 1.0), (2.75, there), (4.0, there), (4.5, 1.0)] {
        assert_eq!(t.at(time), want, "at {time}");
    }
    // a later event cuts the motion short
    let t = one(key(), &[&again[..4], &[(250, &[0xb0, 120, 0][..])]].concat());
    assert_eq!((t.at(2.25), t.at(2.75), t.at(9.0)), (1.5, 1.0, 1.0));
}

#[test]
fn a_model_with_a_port_for_controller_64_has_no_pedal() {
    let ports = [key(), port("damper", MidiSource::Control(64), None)];
    let events: &[(u32, &[u8])] = &[(0, &[0xb0, 64, 127]), (0, &[0x90, 60, 127]), (500, &[0x80, 60, 0])];
    let g = read(&file(0, MS, &[events]), &ports).unwrap();
    assert_eq!(g.tracks().iter().map(|t| t.at(9.0)).collect::<Vec<_>>(), [1.0, 2.0]);
    assert!(g.remarks().is_empty());
}

#[test]
fn what_no_port_follows_is_told() {
    let events: &[(u32, &[u8])] = &[
        (0, &[0x90, 60, 127]),
        (0, &[0xb0, 64, 127]),
        (0, &[0xb0, 7, 100]),
        (0, &[0xb0, 123, 0]),
        (0, &[0xe1, 0, 0]),
        (0, &[0xd1, 5]),
        (0, &[0xa1, 60, 5]),
    ];
    let g = read(&file(0, MS, &[events]), &[key()]).unwrap();
    let told = "no port follows controller 7 on channel 1, pitch bend, channel pressure and key pressure on channel 2";
    assert_eq!(g.remarks(), [told]);
    // the pedal gets a remark if no port has notes to hold
    let g = read(&file(0, MS, &[events]), &[port("x", MidiSource::Control(7), None)]).unwrap();
    assert!(g.remarks()[1].starts_with("no port follows controller 64 on channel 1"), "{:?}", g.remarks());
}

#[test]
fn a_file_lasts_a_day_at_most() {
    let long: &[(u32, &[u8])] = &[(0, &[0x90, 60, 100]), (0x0fff_ffff, &[0x80, 60, 0])];
    let e = read(&file(0, 480, &[long]), &[key()]).unwrap_err().to_string();
    assert!(e.contains("the time is 279620") && e.contains("86400 s at most"), "{e}");
}
