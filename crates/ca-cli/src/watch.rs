//! A file that somebody edits.
//!
//! Decides that it is looked at a few times a second, by when it was written and how long it is: that is portable, holds for
//! editors that write a new file in place of the old and for disks of other machines, and needs no library.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Between two looks: half of what is taken for finished.
pub const LOOK: Duration = Duration::from_millis(60);

/// When a file was written, and how long it is.
type Stamp = (SystemTime, u64);

/// One file.
pub struct Watch {
    path: PathBuf,
    /// as it was read, and as it was last seen
    read: Option<Stamp>,
    seen: Option<Stamp>,
    looked: Instant,
}

fn stamp(path: &Path) -> Option<Stamp> {
    let m = std::fs::metadata(path).ok()?;
    Some((m.modified().ok()?, m.len()))
}

impl Watch {
    /// The file that a word for a model means; `None` where it means a bundled one.
    pub fn of(model: &str) -> Option<Watch> {
        let path = PathBuf::from(model);
        let read = stamp(&path).filter(|_| path.is_file())?;
        Some(Watch { path, read: Some(read), seen: Some(read), looked: Instant::now() })
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
        new
    }
}
