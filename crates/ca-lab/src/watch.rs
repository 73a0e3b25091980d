//! Detects changes of a file that is being edited.
//!
//! It polls the modification time and the length. This is portable, works with editors that replace the file and with
//! network disks, and needs no library.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Poll interval; a change counts once two polls see the same file.
pub const LOOK: Duration = Duration::from_millis(60);

/// Time for which a file must be missing to be gone.
const GONE: Duration = Duration::from_secs(1);

/// Modification time and length.
type Stamp = (SystemTime, u64);

/// File as it was read, and as it was last seen.
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

    /// Returns whether the file is unchanged since the last poll but not since it was read, and marks it as read then.
    /// An empty file is still being written.
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

/// A model file, and the files it takes parts from.
pub struct Watch {
    file: Watched,
    beside: Vec<Watched>,
    looked: Instant,
    /// When the file was last seen, and whether its absence has been reported.
    there: Instant,
    missed: bool,
}

/// Returns `None` for anything but a regular file: reading a pipe would block.
fn stamp(path: &Path) -> Option<Stamp> {
    let m = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    Some((m.modified().ok()?, m.len()))
}

impl Watch {
    /// Watches the file that a word for a model means; `None` where it means a bundled model.
    pub fn of(model: &str) -> Option<Watch> {
        let file = Watched::new(PathBuf::from(model));
        file.read?;
        let now = Instant::now();
        Some(Watch { file, beside: Vec::new(), looked: now, there: now, missed: false })
    }

    /// Watches these files too, by paths from the folder of the model. Files that were watched before keep their state.
    pub fn also(&mut self, names: &[String]) {
        let folder = self.file.path.parent().unwrap_or(Path::new("")).to_owned();
        let mut before = std::mem::take(&mut self.beside);
        for path in names.iter().map(|n| folder.join(n)) {
            let known = before.iter().position(|s| s.path == path);
            self.beside.push(known.map_or_else(|| Watched::new(path), |i| before.swap_remove(i)));
        }
    }

    /// Polls the files. Returns whether one was written since it was read and is complete, and marks it as read then.
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

    /// Returns true once when the file has been missing for a while: some editors remove a file before they replace it.
    pub fn is_gone(&mut self) -> bool {
        let gone = !self.missed && self.looked > self.there + GONE;
        self.missed |= gone;
        gone
    }
}
