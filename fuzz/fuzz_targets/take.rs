//! Arbitrary bytes as a take: open it, go through all of it, and save what is whole of it. The first byte asks for the bytes to be put
//! into a chunk, behind a good beginning.
//!
//! `cargo +nightly fuzz run take`, from the root of the repository. The folder `tests/data/takes` makes good seeds.
#![no_main]

use ca_haptic::take::{Take, recover};
use libfuzzer_sys::fuzz_target;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

fuzz_target!(|data: &[u8]| {
    let Some((first, rest)) = data.split_first() else { return };
    let length = (rest.len() as u64).to_le_bytes();
    let bytes = if first & 1 == 0 {
        data.to_vec()
    } else {
        let body = [&[0; 16], &length[..], &[0; 8], &length, rest].concat();
        [MAGIC, &[6], &(body.len() as u64).to_le_bytes(), &body].concat()
    };
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
    std::fs::write(&from, bytes).unwrap();
    if let Ok(take) = Take::open(&from) {
        let _ = take.summary();
        if let Ok(events) = take.events() {
            let _ = events.take_while(Result::is_ok).count();
        }
    }
    if recover(&from, &to).is_ok() {
        recover(&to, folder.path().join("c.mcap")).unwrap();
    }
});
