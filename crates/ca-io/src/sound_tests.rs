//! Tests of [`super`].

use super::*;
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
    out.limit = 1000;
    while out.write(&[0.25, -0.5].repeat(100)).is_ok() {}
    // half a frame more, as a disk leaves it
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
            assert_eq!(u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize, bytes.len() - 8);
            assert_eq!(usize::from(u16::from_le_bytes([bytes[22], bytes[23]])), channels);
            if channels > 2 {
                assert_eq!(bytes[20..22], [0xfe, 0xff], "WAVEFORMATEXTENSIBLE");
                assert_eq!(bytes[40..44], [0; 4], "no loudspeakers");
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
    out.limit = 2;
    out.write(&[0.0; 4]).unwrap();
    let e = out.write(&[0.0; 2]).unwrap_err();
    assert_eq!((e.kind, out.so_far().frames), (FileErrorKind::Full, 2));
    drop(out);
    assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0, "an unfinished file leaves nothing");
}

#[test]
fn four_gib_is_the_limit_of_the_header() {
    let dir = tempfile::tempdir().unwrap();
    let out = WavOut::create(dir.path().join("a.wav"), 48e3, 64, Format::F32).unwrap();
    let bytes = out.limit * 64 * 4;
    assert!(bytes + 68 < 1 << 32 && bytes > (1 << 32) - 1000);
}
