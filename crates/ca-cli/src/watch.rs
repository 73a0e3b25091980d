//! A file that somebody edits.
//!
//! Decides that it is looked at a few times a second, by when it was written and how long it is: that is portable, holds for
//! editors that write a new file in place of the old and for disks of other machines, and needs no library.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Between two looks: half of what is taken for finished.
pub const LOOK: Duration = Duration::from_millis(60);

/// How long a file is missed before it is gone.
const GONE: Duration = Duration::from_secs(1);

/// When a file was written, and how long it is.
type Stamp = (SystemTime, u64);

/// One file.
pub struct Watch {
    path: PathBuf,
    /// as it was read, and as it was last seen
    read: Option<Stamp>,
    seen: Option<Stamp>,
    looked: Instant,
    /// when it was there, and whether it is known that it is not any more
    there: Instant,
    missed: bool,
}

/// `None` of what is no file: a pipe would be waited for.
fn stamp(path: &Path) -> Option<Stamp> {
    let m = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    Some((m.modified().ok()?, m.len()))
}

impl Watch {
    /// The file that a word for a model means; `None` where it means a bundled one.
    pub fn of(model: &str) -> Option<Watch> {
        let path = PathBuf::from(model);
        let read = stamp(&path)?;
        let now = Instant::now();
        Some(Watch { path, read: Some(read), seen: Some(read), looked: now, there: now, missed: false })
    }

    /// Whether it was written since it was read, and is as it was at the last look; it counts as read then. To be asked again and
    /// again.
    pub fn is_new(&mut self) -> bool {
        let now = Instant::now();
        if now < self.looked + LOOK {
            return false;
        }
        self.looked = now;
        let stamp = stamp(&self.path);
        let new = stamp.is_some() && stamp == self.seen && stamp != self.read;
        if new {
            self.read = stamp;
        }
        self.seen = stamp;
        if stamp.is_some() {
            (self.there, self.missed) = (now, false);
        }
        new
    }

    /// Whether it has not been there for a while; once each time. Editors that write a new file may remove the old one before.
    pub fn is_gone(&mut self) -> bool {
        let gone = !self.missed && self.looked > self.there + GONE;
        self.missed |= gone;
        gone
    }
}
