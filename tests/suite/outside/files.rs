//! Files through the public interface: written files are read back, independent libraries agree, and no file content
//! ends the process. `PROPTEST_CASES=100000` makes a long search.

use ca_core::internal::io::midi::{MidiMap, MidiSource};
use ca_io::FileErrorKind;
use ca_io::format::Format;
use ca_io::gesture::{Gesture, GestureFormat, PortMap};
use ca_io::probe::ProbeOut;
use ca_io::sound::WavOut;
use npyz::WriterBuilder;
use proptest::prelude::*;
use std::path::Path;

const ALL: [GestureFormat; 4] = [GestureFormat::Csv, GestureFormat::Npy, GestureFormat::Wav, GestureFormat::Midi];

fn ports() -> Vec<PortMap> {
    [MidiSource::Note { low: 0, high: 127 }, MidiSource::Control(1), MidiSource::PitchBend, MidiSource::Pressure]
        .into_iter()
        .enumerate()
        .map(|(i, source)| PortMap {
            port: format!("p{i}"),
            map: MidiMap {
                source,
                channel: None,
                from: 0.0,
                to: -0.005,
                attack: 0.01,
                release: 0.02,
                ..MidiMap::new(source)
            },
        })
        .collect()
}

/// Checks what holds for every gesture, whatever its format.
fn playable(g: &Gesture) {
    assert!(!g.tracks().is_empty());
    let end = g.duration();
    assert!(end.is_finite() && end >= 0.0);
    for t in g.tracks() {
        assert!(!t.name().is_empty() && t.n_points() > 0);
        let mut cursor = t.cursor();
        for i in -2..12 {
            let time = end * f64::from(i) / 9.0;
            let x = cursor.at(time);
            assert!(x.is_finite(), "`{}` at {time} s", t.name());
            assert_eq!(x.to_bits(), t.at(time).to_bits());
        }
    }
}

/// The file is read into a playable gesture, or refused with a message in the style of all findings.
fn survives(format: GestureFormat, bytes: &[u8], rate: Option<f64>) {
    match Gesture::read(format, bytes, &ports(), rate) {
        Ok(g) => playable(&g),
        Err(e) => {
            let text = e.to_string();
            assert!(!e.what.is_empty() && !text.contains("please") && !text.contains("invalid input"), "{text}");
            assert!(text.chars().count() < 2000, "{text}");
        }
    }
}

fn smf(events: &[u8]) -> Vec<u8> {
    let mut b = b"MThd\0\0\0\x06\0\0\0\x01\x01\xe0MTrk".to_vec();
    b.extend((events.len() as u32 + 4).to_be_bytes());
    b.extend(events);
    b.extend([0, 0xff, 0x2f, 0]);
    b
}

fn wav(dir: &Path, format: Format, channels: usize, samples: &[f64]) -> Vec<u8> {
    let path = dir.join("seed.wav");
    let mut out = WavOut::create(&path, 44_100.0, channels, format).unwrap();
    out.write(samples).unwrap();
    out.finish().unwrap();
    std::fs::read(path).unwrap()
}

fn npy(dir: &Path, names: &[&str], values: &[f64]) -> Vec<u8> {
    let path = dir.join("seed.npy");
    let mut out = ProbeOut::create(&path, names, 3000.0).unwrap();
    out.write(values).unwrap();
    out.finish().unwrap();
    std::fs::read(path).unwrap()
}

/// Valid files of every format.
fn seeds() -> Vec<(GestureFormat, Vec<u8>)> {
    let dir = tempfile::tempdir().unwrap();
    let fields = b"{'descr': [('time', '<f4'), ('key', '>i2')], 'fortran_order': False, 'shape': (2,), }\n";
    let mut structured = b"\x93NUMPY\x01\x00".to_vec();
    structured.extend((fields.len() as u16).to_le_bytes());
    structured.extend(fields);
    structured.extend([0; 6]);
    structured.extend([0, 0, 128, 63, 0, 1]);
    vec![
        (GestureFormat::Csv, b"# a take\ntime,key,finger\n0,0,\n0.1,,1e-3\n0.2,-0.005,\"0\"\n".to_vec()),
        (GestureFormat::Npy, npy(dir.path(), &["a", "b"], &[1.0, 2.0, 3.0, 4.0])),
        (GestureFormat::Npy, structured),
        (GestureFormat::Wav, wav(dir.path(), Format::I16, 2, &[0.0, 0.5, -0.5, 1.0])),
        (GestureFormat::Wav, wav(dir.path(), Format::F32, 3, &[0.0, 0.5, -0.5])),
        (
            GestureFormat::Midi,
            smf(&[
                0, 0xff, 0x51, 3, 7, 0xa1, 0x20, 0, 0x90, 60, 100, 0x83, 0x60, 62, 90, 10, 60, 0, 10, 0xb0, 1, 64, 0,
                0xe0, 0, 0x50, 0, 0xd0, 33, 5, 0x80, 62, 0,
            ]),
        ),
    ]
}

#[test]
fn the_seeds_of_the_mutations_are_good() {
    for (format, bytes) in seeds() {
        let rate = (format == GestureFormat::Npy && !bytes.windows(4).any(|w| w == b"time")).then_some(3000.0);
        let g = Gesture::read(format, &bytes, &ports(), rate).unwrap_or_else(|e| panic!("{format:?}: {e}"));
        playable(&g);
        // they are small enough to try every prefix
        for end in 0..bytes.len() {
            survives(format, &bytes[..end], rate);
        }
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), rate in any::<bool>()) {
        for format in ALL {
            survives(format, &bytes, (rate && format == GestureFormat::Npy).then_some(100.0));
        }
    }

    #[test]
    fn arbitrary_bytes_behind_a_good_beginning_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        keep in any::<prop::sample::Index>(),
    ) {
        for (format, seed) in seeds() {
            let mut file = seed[..keep.index(seed.len())].to_vec();
            file.extend(&bytes);
            survives(format, &file, (format == GestureFormat::Npy).then_some(3000.0));
        }
    }

    #[test]
    fn mutated_files_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        rate in any::<bool>(),
    ) {
        for (format, mut file) in seeds() {
            for (at, byte) in &flips {
                let at = at.index(file.len());
                file[at] = *byte;
            }
            survives(format, &file, (rate && format == GestureFormat::Npy).then_some(3000.0));
        }
    }

    #[test]
    fn csv_of_any_cells_never_panics(
        rows in prop::collection::vec(
            prop::collection::vec("[-+]?[0-9]{0,3}(\\.[0-9]{0,2})?(e[0-9]{1,3})?|nan|inf|[ \"#;\\t\u{e9}]{0,3}", 1..4),
            0..8,
        ),
    ) {
        let mut text = "time,a,b\n".to_owned();
        for row in rows {
            text.push_str(&row.join(","));
            text.push('\n');
        }
        survives(GestureFormat::Csv, text.as_bytes(), None);
    }

    #[test]
    fn any_midi_messages_in_a_good_frame_play(
        events in prop::collection::vec((0u8..128, 0x80u8..0xf0, 0u8..128, 0u8..128), 1..60),
    ) {
        let mut track = Vec::new();
        for (delta, status, a, b) in &events {
            track.extend([*delta, *status, *a]);
            if !(0xc0..0xe0).contains(status) {
                track.push(*b);
            }
        }
        match Gesture::read(GestureFormat::Midi, &smf(&track), &ports(), None) {
            Ok(g) => {
                playable(&g);
                for t in g.tracks() {
                    for i in 0..200 {
                        let x = t.at(g.duration() * f64::from(i) / 199.0);
                        prop_assert!((-0.005..=0.0).contains(&x), "{} at {i}", x);
                    }
                }
            }
            Err(e) => prop_assert_eq!(e.kind, FileErrorKind::Content),
        }
    }

    #[test]
    fn a_sound_comes_back_as_it_was(
        samples in prop::collection::vec(
            prop_oneof![-1.0..1.0f64, -3.0..3.0f64, Just(f64::NAN), Just(f64::INFINITY)],
            1..100,
        ),
        channels in 1usize..9,
    ) {
        let whole = samples.len() / channels * channels;
        prop_assume!(whole > 0);
        let samples = &samples[..whole];
        let dir = tempfile::tempdir().unwrap();
        for (format, bits) in [(Format::F32, 24), (Format::I24, 23), (Format::I16, 15)] {
            let step = f64::from(-bits).exp2();
            let path = dir.path().join("a.wav");
            let mut out = WavOut::create(&path, 3000.0, channels, format).unwrap();
            out.write(samples).unwrap();
            let reported = out.finish().unwrap();
            prop_assert_eq!(reported.level.clipped, samples.iter().filter(|x| x.is_finite() && x.abs() > 1.0).count() as u64);
            prop_assert_eq!(reported.level.non_finite, samples.iter().filter(|x| !x.is_finite()).count() as u64);
            let g = Gesture::open(&path, &[], None).unwrap();
            prop_assert_eq!(g.tracks().len(), channels);
            for (i, x) in samples.iter().enumerate() {
                let want = if x.is_finite() { x.clamp(-1.0, 1.0) } else { 0.0 };
                let got = g.tracks()[i % channels].at((i / channels) as f64 / 3000.0);
                prop_assert!((got - want).abs() <= step && got.abs() <= 1.0, "{format:?}: {x} came back as {got}");
            }
        }
    }

    #[test]
    fn probes_keep_every_bit(
        values in prop::collection::vec(
            prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL,
            1..60,
        ),
    ) {
        let dir = tempfile::tempdir().unwrap();
        for (name, rate) in [("p.csv", None), ("p.npy", Some(48e3))] {
            let path = dir.path().join(name);
            let mut p = ProbeOut::create(&path, &["x"], 48e3).unwrap();
            p.write(&values).unwrap();
            prop_assert_eq!(p.finish().unwrap(), values.len() as u64);
            let g = Gesture::open(&path, &[], rate).unwrap();
            for (n, want) in values.iter().enumerate() {
                prop_assert_eq!(g.tracks()[0].at(n as f64 / 48e3), *want, "{} sample {}", name, n);
            }
        }
    }
}

#[test]
fn another_library_reads_the_probes() {
    let dir = tempfile::tempdir().unwrap();
    let values: Vec<f64> = (0..30).map(|i| f64::from(i) / 7.0).collect();
    for (names, shape) in [(vec!["a"], vec![30]), (vec!["a", "b", "c"], vec![10, 3])] {
        let bytes = npy(dir.path(), &names, &values);
        assert_eq!((bytes.len() - values.len() * 8) % 64, 0, "data begin at a multiple of 64 bytes");
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!((file.shape(), file.order()), (&shape[..], npyz::Order::C));
        assert_eq!(file.into_vec::<f64>().unwrap(), values);
    }
}

#[test]
fn arrays_of_another_library_are_read() {
    let mut bytes = Vec::new();
    let mut w = npyz::WriteOptions::<f32>::new()
        .default_dtype()
        .shape(&[2, 3])
        .order(npyz::Order::Fortran)
        .writer(&mut bytes)
        .begin_nd()
        .unwrap();
    w.extend([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
    w.finish().unwrap();
    let g = Gesture::read(GestureFormat::Npy, &bytes, &[], Some(1.0)).unwrap();
    let rows: Vec<Vec<f64>> = (0..2).map(|n| g.tracks().iter().map(|t| t.at(f64::from(n))).collect()).collect();
    assert_eq!(rows, [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
}

#[test]
fn a_render_that_stops_leaves_the_old_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("out.wav");
    let good = wav(dir.path(), Format::I16, 1, &[0.25; 10]);
    std::fs::write(&path, &good).unwrap();
    let stopped = std::panic::catch_unwind(|| {
        let mut out = WavOut::create(&path, 48e3, 1, Format::F32).unwrap();
        out.write(&vec![0.5; 100_000]).unwrap();
        std::panic::resume_unwind(Box::new("the model diverged"));
    });
    assert!(stopped.is_err());
    assert_eq!(std::fs::read(&path).unwrap(), good);
    let left: Vec<_> = std::fs::read_dir(&dir).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn errors_name_the_file_as_the_caller_did() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("take.csv");
    let e = Gesture::open(&path, &[], None).unwrap_err();
    assert_eq!(e.kind, FileErrorKind::Io);
    assert!(e.to_string().contains("take.csv`: it cannot be read: no such file"), "{e}");
    std::fs::write(&path, "time,key\n0,0\n0.1,oops\n").unwrap();
    let e = Gesture::open(&path, &[], None).unwrap_err().to_string();
    assert!(e.contains("take.csv`, line 3, column 2 (`key`): `oops` is not a number; "), "{e}");
}
