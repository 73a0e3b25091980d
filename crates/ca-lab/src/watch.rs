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

/// A file as it was read, and as it was last seen.
struct Watched {
    path: PathBuf,
    read: Option<Stamp>,
    seen: Option<Stamp>,
}

impl Watched {
    fn new(path: PathBuf) -> Watched {
        let read = stamp(&path);
        Watched { path, read, seen: read }
    }

    /// Whether it is as at the last look, and other than it was read; it counts as read then. One without a byte is being
    /// written.
    fn look(&mut self) -> bool {
        let stamp = stamp(&self.path);
        let new = stamp.is_some_and(|(_, bytes)| bytes > 0) && stamp == self.seen && stamp != self.read;
        if new {
            self.read = stamp;
        }
        self.seen = stamp;
        new
    }
}

/// One file, and those it takes parts from.
pub struct Watch {
    file: Watched,
    beside: Vec<Watched>,
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
        let file = Watched::new(PathBuf::from(model));
        file.read?;
        let now = Instant::now();
        Some(Watch { file, beside: Vec::new(), looked: now, there: now, missed: false })
    }

    /// Looks at these files too, named from the folder of the model; those that it looked at before are as they were read then.
    pub fn also(&mut self, names: &[String]) {
        let folder = self.file.path.parent().unwrap_or(Path::new("")).to_owned();
        let mut before = std::mem::take(&mut self.beside);
        for path in names.iter().map(|n| folder.join(n)) {
            let known = before.iter().position(|s| s.path == path);
            self.beside.push(known.map_or_else(|| Watched::new(path), |i| before.swap_remove(i)));
        }
    }

    /// Whether it or a file beside was written since it was read, and is as it was at the last look; it counts as read then. To
    /// be asked again and again.
    pub fn is_new(&mut self) -> bool {
        let now = Instant::now();
        if now < self.looked + LOOK {
            return false;
        }
        self.looked = now;
        let mut new = self.file.look();
        for file in &mut self.beside {
            new |= file.look();
        }
        if self.file.seen.is_some() {
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
