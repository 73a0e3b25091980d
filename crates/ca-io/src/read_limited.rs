//! Reads whole files, up to a size limit.
//!
//! A file above the limit is refused by its size. A source without a size (a pipe, `/dev/zero`) is refused once it
//! exceeds the limit. Text is refused at its first NUL, before more is read.

use crate::error::FileError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes read between two checks.
const CHUNK: u64 = 1 << 20;

/// Size limit of one kind of file.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Limit \[MB\].
    pub megabytes: u64,
    /// Advice for a file that exceeds it.
    pub fix: &'static str,
}

impl Limit {
    fn bytes(self) -> u64 {
        self.megabytes * 1_000_000
    }
}

/// Limit of models and of other files written by hand: plans, profiles, calibrations.
pub const MODEL: Limit =
    Limit { megabytes: 256, fix: "name a model file; use generators such as `STRING` and `MESH` for repeated modules" };
/// Limit of gestures.
pub const GESTURE: Limit = Limit { megabytes: 1000, fix: "cut it into parts, or lower its rate" };
/// Limit of bodies from drawing programs.
pub const CLOUD: Limit = Limit { megabytes: 1000, fix: "reduce its number of points" };

/// Reads a text file without decoding it.
///
/// # Errors
/// If the file cannot be read, exceeds the limit, or contains a NUL.
pub fn text(path: &Path, limit: Limit) -> Result<Vec<u8>, FileError> {
    read(path, limit, true)
}

/// Reads a file of any bytes.
///
/// # Errors
/// If the file cannot be read or exceeds the limit.
pub fn bytes(path: &Path, limit: Limit) -> Result<Vec<u8>, FileError> {
    read(path, limit, false)
}

/// Reads text from another source than a file, without decoding it. Messages call the source `name`.
///
/// # Errors
/// As [`text`].
pub fn text_from(from: &mut dyn Read, name: &Path, limit: Limit) -> Result<Vec<u8>, FileError> {
    drain(from, name, limit, true)
}

fn too_large(path: &Path, limit: Limit) -> FileError {
    let what = format!("it is larger than {} MB, the limit for such a file", limit.megabytes);
    FileError::content(what).file(path.display()).fix(limit.fix)
}

fn read(path: &Path, limit: Limit, text: bool) -> Result<Vec<u8>, FileError> {
    let mut file = File::open(path).map_err(|e| FileError::io(path, "it cannot be read", &e))?;
    if file.metadata().is_ok_and(|m| m.is_file() && m.len() > limit.bytes()) {
        return Err(too_large(path, limit));
    }
    drain(&mut file, path, limit, text)
}

fn drain(from: &mut dyn Read, path: &Path, limit: Limit, text: bool) -> Result<Vec<u8>, FileError> {
    let fail = |e: std::io::Error| FileError::io(path, "it cannot be read", &e);
    let mut all = Vec::new();
    loop {
        let before = all.len();
        let n = (&mut *from).take(CHUNK).read_to_end(&mut all).map_err(fail)?;
        if n == 0 {
            return Ok(all);
        }
        if let Some(at) = all[before..].iter().position(|b| text && *b == 0) {
            let e = FileError::format(format!("it is not text: byte {} is NUL", before + at));
            return Err(e.file(path.display()).fix("name a text file, saved as UTF-8"));
        }
        if all.len() as u64 > limit.bytes() {
            return Err(too_large(path, limit));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_read_beyond_its_limit() {
        const SMALL: Limit = Limit { megabytes: 3, fix: "use less" };
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        std::fs::write(&path, vec![b'7'; 3_000_000]).unwrap();
        assert_eq!(text(&path, SMALL).unwrap().len(), 3_000_000);
        std::fs::write(&path, vec![b'7'; 3_000_001]).unwrap();
        let e = bytes(&path, SMALL).unwrap_err().to_string();
        assert!(e.contains("larger than 3 MB") && e.ends_with("; use less"), "{e}");
        // a file of the size it reports, all of it zeros
        File::create(&path).unwrap().set_len(2_000_000).unwrap();
        let e = text(&path, SMALL).unwrap_err().to_string();
        assert!(e.contains("byte 0 is NUL") && e.contains("UTF-8"), "{e}");
        assert_eq!(bytes(&path, SMALL).unwrap().len(), 2_000_000);
    }

    #[cfg(unix)]
    #[test]
    fn what_has_no_end_is_left_at_the_limit() {
        let zero = Path::new("/dev/zero");
        assert!(bytes(zero, Limit { megabytes: 3, fix: "" }).unwrap_err().what.contains("larger than 3 MB"));
        assert!(text(zero, MODEL).unwrap_err().what.contains("NUL"));
    }
}
