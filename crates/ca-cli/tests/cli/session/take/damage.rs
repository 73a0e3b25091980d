//! Tests damaged, forged and foreign takes: they give a difference with both values or a clear error, never a panic.

use super::performer::{DUO, Performer, catalog, duo};
use super::replay;
use crate::sandbox::Sandbox;
use ca_haptic::take::{End, Replay, Take, TakeWriter};
use ca_io::FileErrorKind;
use mcap::records::Record;
use std::fs;
use std::path::Path;

/// Copies a take and changes the `nth` message of a topic.
fn forge(from: &Path, to: &Path, topic: &str, nth: usize, change: impl Fn(&mut Vec<u8>)) {
    let bytes = fs::read(from).unwrap();
    let mut out = mcap::Writer::new(std::io::BufWriter::new(fs::File::create(to).unwrap())).unwrap();
    for record in mcap::read::LinearReader::new(&bytes).unwrap() {
        match record.unwrap() {
            Record::Attachment { header, data, .. } => out
                .attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })
                .unwrap(),
            Record::Metadata(m) => out.write_metadata(&m).unwrap(),
            _ => {}
        }
    }
    let mut seen = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let mut message = message.unwrap();
        if message.channel.topic == topic {
            if seen == nth {
                change(message.data.to_mut());
            }
            seen += 1;
        }
        out.write(&message).unwrap();
    }
    assert!(seen > nth);
    out.finish().unwrap();
}

/// A take truncated before the end of the first chunk of frames.
#[test]
fn a_take_with_nothing_to_compare_is_not_identical() {
    let (dir, sandbox) = (tempfile::tempdir().unwrap(), Sandbox::new());
    let good = dir.path().join("good.mcap");
    duo(&good, 1600);
    let bytes = fs::read(&good).unwrap();
    let cut = dir.path().join("cut.mcap");
    let nothing = (1..20).map(|k| bytes.len() * k / 20).find(|n| {
        fs::write(&cut, &bytes[..*n]).unwrap();
        Take::open(&cut).is_ok_and(|t| t.events().is_ok_and(|e| e.count() == 0))
    });
    assert!(nothing.is_some(), "no such beginning of {} bytes", bytes.len());
    let r = sandbox.ca(&["replay", cut.to_str().unwrap(), "--verify"]).is(1);
    assert!(r.out.contains("nothing was compared"), "{}\n{}", r.out, r.err);
}

#[test]
fn the_first_difference_is_found_with_both_values() {
    let dir = tempfile::tempdir().unwrap();
    let (good, bad) = (dir.path().join("good.mcap"), dir.path().join("bad.mcap"));
    duo(&good, 1600);
    assert!(replay(&good).is_identical());

    // a false force: frame 1200 of the second device, second key, 0.1 N
    let at = 4 + 112 + 4;
    forge(&good, &bad, "/device/right/out", 1199, |data| {
        data[at..at + 4].copy_from_slice(&0.1f32.to_le_bytes());
    });
    let d = replay(&bad).difference.expect("a difference");
    assert!(d.what.contains("force at degree of freedom 1") && d.what.contains("`right`"), "{d}");
    assert_eq!((d.was.as_str(), d.tick), ("1e-1 N", 1199 * 16 + 1), "{d}");

    // a hand position changed by 1 nm: a later force or sample must differ
    let x = 4 + 112;
    forge(&good, &bad, "/device/left/in", 1150, |data| {
        let old = f64::from_le_bytes(data[x..x + 8].try_into().unwrap());
        data[x..x + 8].copy_from_slice(&(old + 1e-9).to_le_bytes());
    });
    let v = replay(&bad);
    let d = v.difference.clone().expect("a difference");
    assert!(v.frames >= 1150 && v.frames < 1170, "{v:?}");
    assert!(d.was != d.is, "{d}");

    forge(&good, &bad, "/sound", 10, |data| *data.last_mut().unwrap() ^= 1);
    let d = replay(&bad).difference.expect("a difference");
    assert!(d.what.contains("sound of channel 1"), "{d}");

    forge(&good, &bad, "/hash", 2, |data| data[12] ^= 1);
    let d = replay(&bad).difference.expect("a difference");
    assert!(d.what.contains("hash"), "{d}");

    // a message cut short, and one that is not CDR
    for change in [|d: &mut Vec<u8>| d.truncate(40), |d: &mut Vec<u8>| d[0] = 7] {
        forge(&good, &bad, "/change", 0, change);
        let take = Take::open(&bad).unwrap();
        let run = Replay::new(&take, &catalog()).unwrap().run(&take, &mut |_| (), &mut |_| Ok(()));
        let e = run.unwrap_err();
        assert!(e.to_string().contains("`/change`"), "{e}");
    }
}

#[test]
fn a_take_cut_anywhere_reads_up_to_there() {
    let dir = tempfile::tempdir().unwrap();
    let (good, bad) = (dir.path().join("good.mcap"), dir.path().join("bad.mcap"));
    // chunks throughout the file
    let mut p = Performer::new(DUO, &good);
    p.frames(900);
    p.finish();
    let bytes = fs::read(&good).unwrap();
    let mut longest = 0;
    for part in 0..40 {
        fs::write(&bad, &bytes[..bytes.len() * part / 40]).unwrap();
        match Take::open(&bad) {
            Ok(take) => {
                let v = replay(&bad);
                assert!(v.difference.is_none(), "{v:?}");
                assert!(v.frames >= longest, "more of the file is more of the take");
                longest = v.frames;
                let s = take.summary().unwrap();
                assert!(matches!(s.end, End::Cut(..)) || s.seconds > 0.29, "{:?}", s.end);
            }
            Err(e) => assert_eq!(e.kind, FileErrorKind::Format, "{e}"),
        }
    }
    assert!(longest >= 880, "{longest} of 900");
    // wrong bytes in the middle, up to the end of the data; a replay does not read the index after it
    let data = mcap::Summary::read(&bytes).unwrap().expect("a summary").chunk_indexes;
    let data = data.iter().map(|c| (c.chunk_start_offset + c.chunk_length) as usize).max().expect("chunks");
    let mut caught = 0;
    for place in (2000..bytes.len()).step_by(bytes.len() / 97) {
        let mut wrong = bytes.clone();
        wrong[place] ^= 0x55;
        fs::write(&bad, &wrong).unwrap();
        if let Ok(take) = Take::open(&bad) {
            let Ok(mut r) = Replay::new(&take, &catalog()) else { continue };
            let v = r.run(&take, &mut |_| (), &mut |_| Ok(()));
            // chunks are checked as a whole, so wrong data is never used
            assert!(v.as_ref().is_ok_and(|v| v.difference.is_none()), "byte {place}: {v:?}");
            // a replay with missing data is not called identical
            let v = v.unwrap();
            assert!(place >= data || (v.damaged && !v.is_identical()), "byte {place} of {data}: {v:?}");
            caught += usize::from(v.damaged);
        }
    }
    assert!(caught > 60, "{caught}");
}

#[test]
fn a_part_that_is_damaged_is_no_identical_replay() {
    let sandbox = Sandbox::new();
    duo(&sandbox.path("take.mcap"), 1600);
    let good = fs::read(sandbox.path("take.mcap")).unwrap();
    let chunks = mcap::Summary::read(&good).unwrap().expect("a summary").chunk_indexes;
    let middle = &chunks[chunks.len() / 2];
    let at = middle.chunk_start_offset as usize;
    // damages the kind, the length and the bytes of a chunk
    for (name, place) in [("kind", at), ("length", at + 3), ("bytes", at + middle.chunk_length as usize / 2)] {
        let mut bad = good.clone();
        bad[place] ^= 0x55;
        fs::write(sandbox.path("bad.mcap"), &bad).unwrap();
        sandbox.ca(&["replay", "bad.mcap", "--verify"]).is(1).says(&["damaged", "records are missing there"]);
        let j = sandbox.ca(&["replay", "bad.mcap", "--json"]).is(3).json();
        assert_eq!(
            (&j["identical"], &j["damaged"], &j["difference"]),
            (&false.into(), &true.into(), &().into()),
            "{name}"
        );
        sandbox.ca(&["log", "info", "bad.mcap"]).is(3).says(&["damaged"]);
        sandbox.ca(&["log", "recover", "bad.mcap", "--force"]).is(3).says(&["damaged"]);
        // the recovered file contains the take before the damage
        sandbox.ca(&["replay", "bad.recovered.mcap", "--verify"]).is(0).says(&["identical"]);
        fs::write(sandbox.path("both.mcap"), &bad[..bad.len() - 2000]).unwrap();
        if name != "length" {
            sandbox.ca(&["replay", "both.mcap", "--verify"]).is(1).says(&["damaged"]);
        }
    }
    sandbox.ca(&["replay", "take.mcap", "--verify"]).is(0);
}

#[test]
fn an_attachment_that_is_too_short_is_an_error() {
    let sandbox = Sandbox::new();
    let path = "../../tests/data/inputs/attachment-without-crc.mcap";
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(path), sandbox.path("a.mcap")).unwrap();
    for args in
        [&["log", "info", "a.mcap"][..], &["replay", "a.mcap"], &["log", "export", "a.mcap", "sound", "-o", "s.wav"]]
    {
        sandbox.ca(args).is(1).says(&["attachment length (38) exceeds space in record (34)"]);
    }
    // a take with a damaged attachment
    duo(&sandbox.path("take.mcap"), 16);
    let mut bad = fs::read(sandbox.path("take.mcap")).unwrap();
    let mut at = mcap::MAGIC.len();
    while bad[at] != mcap::records::op::ATTACHMENT {
        at += 9 + u64::from_le_bytes(bad[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    let length = u64::from_le_bytes(bad[at + 1..at + 9].try_into().unwrap());
    bad[at + 1..at + 9].copy_from_slice(&(length - 4).to_le_bytes());
    bad.drain(at + 9 + length as usize - 4..at + 9 + length as usize);
    fs::write(sandbox.path("bad.mcap"), &bad).unwrap();
    sandbox.ca(&["log", "info", "bad.mcap"]).is(1).says(&["attachment length"]);
    sandbox.ca(&["log", "recover", "bad.mcap"]).is(3).says(&["damaged", "attachment length"]);
}

#[test]
fn what_is_no_take_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.mcap");
    for text in [&b""[..], b"hello", b"RIFF0000WAVEfmt "] {
        fs::write(&path, text).unwrap();
        let e = Take::open(&path).unwrap_err();
        assert_eq!(e.kind, FileErrorKind::Format);
        assert!(e.to_string().contains("not an MCAP file"), "{e}");
    }
    let mut out = mcap::Writer::new(std::io::BufWriter::new(fs::File::create(&path).unwrap())).unwrap();
    out.finish().unwrap();
    drop(out);
    let e = Take::open(&path).unwrap_err();
    assert!(e.to_string().contains("not a take of `ca`"), "{e}");
    let mut out = mcap::Writer::new(std::io::BufWriter::new(fs::File::create(&path).unwrap())).unwrap();
    let metadata = [("format", "99"), ("host.ca", "7.0")].map(|(k, v)| (k.to_owned(), v.to_owned())).into();
    out.write_metadata(&mcap::records::Metadata { name: "ca.take".into(), metadata }).unwrap();
    out.finish().unwrap();
    drop(out);
    let e = Take::open(&path).unwrap_err();
    assert_eq!(e.kind, FileErrorKind::Unsupported);
    assert!(e.to_string().contains("`ca` 7.0"), "{e}");
    assert_eq!(Take::open(dir.path().join("no.mcap")).unwrap_err().kind, FileErrorKind::Io);

    duo(&dir.path().join("mine.mcap"), 1);
    let take = Take::open(dir.path().join("mine.mcap")).unwrap();
    let scene = take.header.scene(&catalog()).unwrap();
    let e = TakeWriter::create(dir.path().join("mine.mcap"), &take.header, &scene).err().unwrap();
    assert!(e.to_string().contains("never overwritten"), "{e}");
    let e = TakeWriter::create(dir.path().join("no/such.mcap"), &take.header, &scene).err().unwrap();
    assert!(e.to_string().contains("make the directory first"), "{e}");
}
