//! MCAP files with truncated records or wrong lengths give an error, never a panic.

use ca_haptic::take::Take;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
const CHUNK: u8 = 0x06;
const ATTACHMENT: u8 = 0x09;

fn text(t: &str) -> Vec<u8> {
    [&(t.len() as u32).to_le_bytes(), t.as_bytes()].concat()
}

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[kind], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

/// A chunk without compression and without checksum.
fn chunk(records: &[u8]) -> Vec<u8> {
    let length = (records.len() as u64).to_le_bytes();
    let body = [&[0; 16], &length[..], &[0; 4], &text(""), &length, records].concat();
    record(CHUNK, &body)
}

/// A valid body of every kind of record.
fn bodies() -> Vec<(u8, Vec<u8>)> {
    let map = [&30_u32.to_le_bytes()[..], &text("format"), &text("1"), &text("a"), &text("bcdefg")].concat();
    vec![
        (0x01, [text("ca"), text("x")].concat()),
        (0x02, vec![0; 20]),
        (0x03, [&1_u16.to_le_bytes()[..], &text("S"), &text("json"), &text("{}")].concat()),
        (0x04, [&[1, 0, 0, 0][..], &text("/t"), &text("json"), &map].concat()),
        (0x05, [&[1, 0][..], &[0; 20], b"data"].concat()),
        (
            CHUNK,
            chunk(&record(0x03, &[&1_u16.to_le_bytes()[..], &text("S"), &text("json"), &text("{}")].concat()))[9..]
                .to_vec(),
        ),
        (0x07, [&[1, 0][..], &16_u32.to_le_bytes(), &[0; 16]].concat()),
        (0x08, [&[0; 32][..], &10_u32.to_le_bytes(), &[0; 10], &[0; 8], &text("zstd"), &[0; 16]].concat()),
        (ATTACHMENT, [&[0; 16][..], &text("name"), &text("text"), &4_u64.to_le_bytes(), b"data", &[0; 4]].concat()),
        (0x0a, [&[0; 40][..], &text("name"), &text("text")].concat()),
        (0x0b, [&[0; 42][..], &10_u32.to_le_bytes(), &[0; 10]].concat()),
        (0x0c, [text("other"), map].concat()),
        (0x0d, [&[0; 16][..], &text("name")].concat()),
        (0x0e, vec![0; 17]),
        (0x0f, vec![0; 4]),
        (0x80, b"anything".to_vec()),
    ]
}

/// A file with these bytes after its header.
fn file(path: &Path, records: &[u8]) -> PathBuf {
    let header = record(0x01, &[text("ca"), text("x")].concat());
    let end = [record(0x0f, &[0; 4]), record(0x02, &[0; 20])].concat();
    std::fs::write(path, [&MAGIC[..], &header, records, &end, &MAGIC].concat()).unwrap();
    path.to_owned()
}

/// The error of a file that is not a take.
fn error_text(path: &Path) -> String {
    Take::open(path).expect_err("no take").to_string()
}

#[test]
fn a_record_of_any_kind_may_be_cut_anywhere() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cut.mcap");
    for (kind, body) in bodies() {
        // complete, it is read; the file is then only not a take
        let whole = error_text(&file(&path, &record(kind, &body)));
        assert!(whole.contains("not a take of `ca`") || [0x02, 0x05].contains(&kind), "{kind:#x}: {whole}");
        for end in 0..body.len() {
            let cut = record(kind, &body[..end]);
            // by itself, in a chunk, and in a chunk that ends within it
            let torn = chunk(&record(kind, &body)[..9 + end]);
            for bytes in [&cut, &chunk(&cut), &torn] {
                let what = error_text(&file(&path, bytes));
                assert!(!what.is_empty(), "{kind:#x}, {end}");
            }
        }
    }
}

#[test]
fn an_attachment_without_its_sum_is_named() {
    let made = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/inputs/attachment-without-crc.mcap");
    let what = error_text(&made);
    assert!(what.contains("attachment length (38) exceeds space in record (34)"), "{what}");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let (_, body) = bodies().into_iter().find(|b| b.0 == ATTACHMENT).unwrap();
    for end in 0..body.len() {
        let what = error_text(&file(&path, &record(ATTACHMENT, &body[..end])));
        assert!(what.contains("ttachment length"), "{end}: {what}");
    }
    let mut vast = body.clone();
    vast[32..40].fill(0xff);
    assert!(error_text(&file(&path, &record(ATTACHMENT, &vast))).contains("ttachment length"));
}

#[test]
fn a_record_ends_where_its_chunk_does() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let (_, message) = bodies().into_iter().find(|b| b.0 == 0x05).unwrap();
    let mut records = record(0x80, &message);
    records[1] += 1;
    let what = error_text(&file(&path, &[chunk(&records), record(0x80, b"more")].concat()));
    assert!(what.contains("chunk"), "{what}");
}

proptest! {
    #[test]
    fn arbitrary_records_never_panic(
        drawn in prop::collection::vec(
            (any::<prop::sample::Index>(), 0usize..80, prop::collection::vec((0usize..80, any::<u8>()), 0..4), any::<bool>(), -9i64..9),
            1..5,
        ),
    ) {
        let all = bodies();
        let mut bytes = Vec::new();
        for (which, keep, flips, within, lie) in drawn {
            let (kind, mut body) = all[which.index(all.len())].clone();
            body.truncate(keep);
            for (at, byte) in flips {
                if let Some(b) = body.get_mut(at) {
                    *b = byte;
                }
            }
            let mut one = record(kind, &body);
            let length = (body.len() as u64).saturating_add_signed(lie.min(0).max(lie / 3));
            one[1..9].copy_from_slice(&length.to_le_bytes());
            bytes.extend(if within { chunk(&one) } else { one });
        }
        let dir = tempfile::tempdir().unwrap();
        prop_assert!(Take::open(file(&dir.path().join("a.mcap"), &bytes)).is_err());
    }
}
