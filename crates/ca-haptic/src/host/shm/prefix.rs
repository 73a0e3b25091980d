//! Claims the prefix of the names of a site: eight random hexadecimal digits in the file `prefix` of its folder.
//!
//! All users share `/dev/shm`, and a file of another user under a name that a process needs would block that process.
//! Other users cannot read the folder, so they do not know the prefix before it is used. From then on they can see it
//! in `/dev/shm`. So a site takes new digits when another user has a file under the old ones and no process uses them.
//!
//! A process that uses the digits has a shared lock on the file, and only a process with an exclusive lock writes new
//! digits. So two processes of one site never have different prefixes. The kernel releases the lock of a killed
//! process. Python does the same (`device.py`).

use super::names::is_hash;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

const FILE: &str = "prefix";
const DIGITS: usize = 8;
/// Longest wait for a process that writes new digits.
const LIMIT: Duration = Duration::from_secs(2);

/// Returns the digits of the site at `root`, and the file whose lock protects them.
///
/// `squatted` returns true if other users have files under these digits. `retire` removes the files that this user has
/// under the old digits, before new ones are written.
///
/// # Errors
/// If the file cannot be read, written or locked.
pub(in crate::host) fn claim(
    root: &Path,
    squatted: impl Fn(&str) -> bool,
    retire: impl Fn(&str),
) -> io::Result<(String, File)> {
    let mut options = OpenOptions::new();
    let file = options.read(true).write(true).create(true).truncate(false).mode(0o600).open(root.join(FILE))?;
    let end = Instant::now() + LIMIT;
    loop {
        share(&file, end)?;
        let old = digits(&file)?;
        if let Some(found) = &old
            && !squatted(found)
        {
            return Ok((found.clone(), file));
        }
        file.unlock()?;
        match file.try_lock() {
            Ok(()) => {
                // another process may have been faster
                if digits(&file)? == old {
                    if let Some(old) = &old {
                        retire(old);
                    }
                    file.write_all_at(random()?.as_bytes(), 0)?;
                    file.set_len(DIGITS as u64)?;
                }
                file.unlock()?;
            }
            Err(TryLockError::WouldBlock) => {
                share(&file, end)?;
                // another process uses the digits
                if let (Some(found), true) = (digits(&file)?, old.is_some()) {
                    return Ok((found, file));
                }
                file.unlock()?;
            }
            Err(TryLockError::Error(e)) => return Err(e),
        }
        if Instant::now() > end {
            return Err(ErrorKind::TimedOut.into());
        }
    }
}

fn share(file: &File, end: Instant) -> io::Result<()> {
    loop {
        match file.try_lock_shared() {
            Ok(()) => return Ok(()),
            Err(TryLockError::Error(e)) => return Err(e),
            Err(TryLockError::WouldBlock) if Instant::now() > end => return Err(ErrorKind::TimedOut.into()),
            Err(TryLockError::WouldBlock) => sleep(Duration::from_millis(1)),
        }
    }
}

/// Reads the digits; `None` if the file does not hold exactly eight of them.
fn digits(file: &File) -> io::Result<Option<String>> {
    let mut bytes = [0; DIGITS + 1];
    let n = file.read_at(&mut bytes, 0)?;
    let text = std::str::from_utf8(&bytes[..n]).unwrap_or_default();
    Ok(is_hash(text).then(|| text.to_owned()))
}

fn random() -> io::Result<String> {
    let mut bytes = [0; DIGITS / 2];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.iter().fold(String::new(), |text, b| text + &format!("{b:02x}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    fn claimed(root: &Path, squatted: &[&str]) -> (String, File, Vec<String>) {
        let retired = RefCell::new(Vec::new());
        let found = claim(root, |d| squatted.contains(&d), |old| retired.borrow_mut().push(old.to_owned()));
        let (digits, file) = found.expect("digits");
        (digits, file, retired.into_inner())
    }

    #[test]
    fn a_place_has_one_prefix_and_another_place_another() {
        let (a, b) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let (first, _held, _) = claimed(a.path(), &[]);
        assert!(first.len() == DIGITS && first.bytes().all(|c| c.is_ascii_hexdigit()), "{first}");
        assert_eq!(claimed(a.path(), &[]).0, first);
        assert_ne!(claimed(b.path(), &[]).0, first);
        let fresh = tempfile::tempdir().expect("a folder");
        let all: Vec<String> = std::thread::scope(|s| {
            let threads: Vec<_> = (0..8).map(|_| s.spawn(|| claimed(fresh.path(), &[]))).collect();
            let all: Vec<_> = threads.into_iter().map(|t| t.join().expect("no panic")).collect();
            all.into_iter().map(|c| c.0).collect()
        });
        assert!(all.windows(2).all(|w| w[0] == w[1]), "{all:?}");
    }

    #[test]
    fn a_prefix_that_is_squatted_is_replaced_once_no_process_uses_it() {
        let dir = tempfile::tempdir().expect("a folder");
        let (first, held, _) = claimed(dir.path(), &[]);
        let (same, held_too, retired) = claimed(dir.path(), &[&first]);
        assert!(same == first && retired.is_empty(), "it is in use");
        drop((held, held_too));
        let (second, _held, retired) = claimed(dir.path(), &[&first]);
        assert!(second != first && retired == [first.as_str()], "{first} {second} {retired:?}");
        assert_eq!(claimed(dir.path(), &[&first]).0, second);
    }

    #[test]
    fn a_file_that_is_damaged_is_written_again() {
        for damaged in ["", "12", "xxxxxxxx", "0123456789"] {
            let dir = tempfile::tempdir().expect("a folder");
            std::fs::write(dir.path().join(FILE), damaged).expect("written");
            let (digits, _held, retired) = claimed(dir.path(), &[]);
            assert!(digits != damaged && retired.is_empty(), "{damaged}");
            assert_eq!(claimed(dir.path(), &[]).0, digits);
        }
    }
}
