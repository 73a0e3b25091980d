//! Tests of [`super`].

use super::*;
use crate::FileErrorKind;
use hound::WavReader;

const ODD: [f64; 8] = [0.0, 0.5, -0.5, 1.0, -1.0, 1.5, -7.0, 0.1];

fn render(format: Format, samples: &[f64]) -> (tempfile::TempDir, Written) {
    let dir = tempfile::tempdir().unwrap();
    let mut out = WavOut::create(dir.path().join("a.wav"), 48_000.0, 1, format).unwrap();
    samples.chunks(3).for_each(|c| out.write(c).unwrap());
    let written = out.finish().unwrap();
    (dir, written)
}

#[test]
fn integers_are_exact() {
    for (format, full) in [(Format::I16, 32_768), (Format::I24, 8_388_608)] {
        let (_dir, written) = render(format, &ODD);
        let mut file = WavReader::open(&written.path).unwrap();
        assert_eq!((file.spec().bits_per_sample, file.spec().sample_rate), (format.bits(), 48_000));
        let got: Vec<i32> = file.samples().map(Result::unwrap).collect();
        let tenth = if full == 32_768 { 3277 } else { 838_861 };
        assert_eq!(got, [0, full / 2, -full / 2, full - 1, -full, full - 1, -full, tenth]);
        assert_eq!((written.level.clipped, written.level.non_finite, written.frames), (2, 0, 8));
        assert_eq!(written.level.peak, [7.0]);
        assert!(!written.is_faithful());
    }
    // ties to even
    let (_dir, written) = render(Format::I16, &[0.5 / 32_768.0, 1.5 / 32_768.0, -2.5 / 32_768.0]);
    let got: Vec<i32> = WavReader::open(&written.path).unwrap().samples().map(Result::unwrap).collect();
    assert_eq!(got, [0, 2, -2]);
}

#[test]
fn what_a_disk_took_before_it_was_full_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.wav");
    let create = || WavOut::create(&path, 48_000.0, 2, Format::F32).unwrap();
    let mut out = create();
    out.write(&[0.25, -0.5].repeat(1000)).unwrap();
    // half a frame more, as left by a full disk
    out.flush().unwrap();
    out.file.write_all(&[1, 2, 3, 4]).unwrap();
    let written = out.finish_short().unwrap();
    let got: Vec<f32> = WavReader::open(&path).unwrap().samples().map(Result::unwrap).collect();
    assert_eq!((written.frames, got), (1000, [0.25, -0.5].repeat(1000)));
    std::fs::remove_file(&path).unwrap();
    assert!(create().finish_short().is_err() && !path.exists(), "nothing is no sound");
}

#[test]
fn floats_have_the_same_ceiling() {
    let (_dir, written) = render(Format::F32, &ODD);
    let got: Vec<f32> = WavReader::open(&written.path).unwrap().samples().map(Result::unwrap).collect();
    assert_eq!(got, [0.0, 0.5, -0.5, 1.0, -1.0, 1.0, -1.0, 0.1]);
    assert_eq!(written.level.clipped, 2);
}

#[test]
fn what_has_no_value_is_silence_and_counted_apart() {
    let (_dir, written) = render(Format::F32, &[f64::NAN, 0.25, f64::INFINITY, f64::NEG_INFINITY]);
    let got: Vec<f32> = WavReader::open(&written.path).unwrap().samples().map(Result::unwrap).collect();
    assert_eq!(got, [0.0, 0.25, 0.0, 0.0]);
    assert_eq!((written.level.clipped, written.level.non_finite, written.level.peak[0]), (0, 3, 0.25));
}

#[test]
fn many_channels_have_a_proper_header() {
    let dir = tempfile::tempdir().unwrap();
    for channels in [1, 2, 3, 4, 18, 19, 64, MAX_CHANNELS] {
        for format in [Format::F32, Format::I24, Format::I16] {
            let path = dir.path().join("many.wav");
            let mut out = WavOut::create(&path, 44_100.0, channels, format).unwrap();
            let frame: Vec<f64> = (0..channels).map(|c| c as f64 / 512.0).collect();
            out.write(&frame).unwrap();
            out.write(&frame).unwrap();
            let written = out.finish().unwrap();
            assert_eq!((written.level.peak.as_slice(), written.frames), (&frame[..], 2));
            let bytes = std::fs::read(&path).unwrap();
            assert_eq!((number(&bytes, 4) as usize, bytes.len() % 2), (bytes.len() - 8, 0));
            let format_at = at(&bytes, b"fmt ") + 8;
            assert_eq!(usize::from(u16::from_le_bytes([bytes[format_at + 2], bytes[format_at + 3]])), channels);
            if channels > 2 {
                assert_eq!(bytes[format_at..format_at + 2], [0xfe, 0xff], "WAVEFORMATEXTENSIBLE");
                assert_eq!(bytes[format_at + 20..format_at + 24], [0; 4], "no loudspeakers");
            }
            let mut file = WavReader::new(&bytes[..]).unwrap();
            assert_eq!(usize::from(file.spec().channels), channels);
            let got: Vec<f64> = if format == Format::F32 {
                file.samples::<f32>().map(|s| f64::from(s.unwrap())).collect()
            } else {
                let full = f64::from(format.bits() - 1).exp2();
                file.samples::<i32>().map(|s| f64::from(s.unwrap()) / full).collect()
            };
            assert_eq!(got, [&frame[..], &frame[..]].concat());
        }
    }
}

#[test]
fn refuses_what_a_wav_file_cannot_be() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.wav");
    for (rate, channels) in [(0.0, 1), (44_100.5, 1), (f64::NAN, 1), (2e6, 1), (48e3, 0), (48e3, 257)] {
        let e = WavOut::create(&path, rate, channels, Format::I16).err().unwrap();
        assert_eq!(e.kind, FileErrorKind::Usage, "{rate} {channels}");
    }
    let mut out = WavOut::create(&path, 48e3, 2, Format::I16).unwrap();
    assert_eq!(out.write(&[0.0; 3]).unwrap_err().kind, FileErrorKind::Usage);
    drop(out);
    assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0, "an unfinished file leaves nothing");
}

fn at(file: &[u8], chunk: &[u8]) -> usize {
    file.windows(4).position(|w| w == chunk).unwrap_or_else(|| panic!("{chunk:?}"))
}

fn number(file: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(file[at..at + 4].try_into().unwrap())
}

#[test]
fn samples_of_an_odd_number_of_bytes_are_padded() {
    for (frames, pad) in [(5, 1), (6, 0)] {
        let (_dir, written) = render(Format::I24, &vec![0.5; frames]);
        let bytes = std::fs::read(&written.path).unwrap();
        let data = at(&bytes, b"data");
        assert_eq!((number(&bytes, data + 4) as usize, bytes.len()), (3 * frames, data + 8 + 3 * frames + pad));
        assert_eq!((number(&bytes, 4) as usize, bytes.len() % 2), (bytes.len() - 8, 0));
    }
    // a full disk cannot take the pad byte
    let dir = tempfile::tempdir().unwrap();
    let mut out = WavOut::create(dir.path().join("a.wav"), 48_000.0, 1, Format::I24).unwrap();
    out.write(&[0.5; 5]).unwrap();
    assert_eq!(out.finish_short().unwrap().frames, 4);
}

#[test]
fn floats_say_how_many_frames_there_are() {
    let (_dir, written) = render(Format::F32, &ODD);
    let bytes = std::fs::read(&written.path).unwrap();
    let fact = at(&bytes, b"fact");
    assert_eq!((number(&bytes, fact + 4), number(&bytes, fact + 8)), (4, 8));
    let (_dir, written) = render(Format::I16, &ODD);
    assert!(!std::fs::read(&written.path).unwrap().windows(4).any(|w| w == b"fact"), "integers need none");
}

#[test]
fn a_file_in_memory_is_that_on_disk() {
    let samples = [0.25_f32, -0.5, 1.0, 0.0];
    let dir = tempfile::tempdir().unwrap();
    let mut out = WavOut::create(dir.path().join("a.wav"), 48_000.0, 2, Format::F32).unwrap();
    out.write(&samples.map(f64::from)).unwrap();
    assert_eq!(floats(&samples, 2, 48_000), std::fs::read(out.finish().unwrap().path).unwrap());
}

#[test]
fn beyond_4_gib_the_sizes_have_64_bits() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.wav");
    // the largest file with 32-bit sizes, and the next one
    let header = wav_header::open(Format::F32, 48_000, 2).len() as u64;
    let most = (u64::from(u32::MAX) + 8 - header) / 8;
    for frames in [most, most + 1] {
        let mut out = WavOut::create(&path, 48_000.0, 2, Format::F32).unwrap();
        out.flush().unwrap();
        // a sparse file, which uses no disk space
        out.file.set_len(header + 8 * frames).unwrap();
        out.written.frames = frames;
        out.complete().unwrap();
        let file = File::open(&path).unwrap();
        assert_eq!(file.metadata().unwrap().len(), header + 8 * frames);
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut std::io::Read::take(file, header), &mut bytes).unwrap();
        let (data, fact) = (at(&bytes, b"data"), at(&bytes, b"fact"));
        if frames == most {
            assert_eq!((&bytes[..4], at(&bytes, b"JUNK")), (&b"RIFF"[..], 12));
            assert_eq!(u64::from(number(&bytes, data + 4)), 8 * frames);
            assert_eq!(u64::from(number(&bytes, 4)), header + 8 * frames - 8);
        } else {
            let long = |at| u64::from(number(&bytes, at)) | u64::from(number(&bytes, at + 4)) << 32;
            assert_eq!((&bytes[..4], at(&bytes, b"ds64"), number(&bytes, 16)), (&b"RF64"[..], 12, 28));
            assert_eq!((number(&bytes, 4), number(&bytes, data + 4)), (u32::MAX, u32::MAX));
            assert_eq!([20, 28, 36].map(long), [header + 8 * frames - 8, 8 * frames, frames]);
        }
        assert_eq!(u64::from(number(&bytes, fact + 8)), frames);
    }
}
