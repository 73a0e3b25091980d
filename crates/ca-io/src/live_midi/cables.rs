//! MIDI as raw bytes: devices of the kernel (`/dev/snd/midiC0D0`), a pipe, a file.
//!
//! Decides for plain files, which need no library and no header, and for a thread each, since a device is read by waiting; how
//! much waits for this process has a bound, so that a pipe without end takes no memory.

use super::Cable;
use crate::error::{FileError, FileErrorKind};
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Bytes that are read at once, and pieces that may wait.
const PIECE: usize = 256;
const WAITING: usize = 16;
/// Pieces that are played in a turn: fewer events than the engine takes in one.
const TURN: usize = 4;
/// A pipe whose writer has gone is opened again after so long.
const AGAIN: Duration = Duration::from_millis(50);

/// From a thread that reads.
enum Came {
    Bytes(Vec<u8>),
    /// it is over, in words
    End(String),
}

/// Cables that are open.
pub struct Cables {
    names: Vec<String>,
    open: Vec<Cable>,
    came: Receiver<(usize, Came)>,
    news: Vec<(bool, String)>,
}

impl Cables {
    /// Opens files, pipes and devices, and reads each on a new thread.
    ///
    /// # Errors
    /// If a thread cannot be started.
    pub fn open(paths: Vec<PathBuf>) -> Result<Cables, FileError> {
        let (tell, came) = sync_channel(WAITING);
        let mut names = Vec::new();
        for path in paths {
            let (k, tell, at) = (names.len(), tell.clone(), path.clone());
            let started = std::thread::Builder::new().name("ca midi".into()).spawn(move || read(&at, k, &tell));
            match started {
                Ok(_) => names.push(path.display().to_string()),
                Err(e) => {
                    let what = format!("no thread for {}: {e}", path.display());
                    return Err(FileError::new(FileErrorKind::Io, what));
                }
            }
        }
        let open = names.iter().map(|_| Cable::default()).collect();
        Ok(Cables { names, open, came, news: Vec::new() })
    }

    /// Paths of those that are open.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// What came since the last turn.
    pub fn turn(&mut self, mut feed: impl FnMut(&mut Cable, &[u8])) {
        for _ in 0..TURN {
            let Ok((k, came)) = self.came.try_recv() else { return };
            match came {
                Came::Bytes(bytes) => feed(&mut self.open[k], &bytes),
                Came::End(why) => self.news.push((true, format!("MIDI: {}: {why}", self.names[k]))),
            }
        }
    }

    /// What people should know since the last call: bad, and in words.
    pub fn news(&mut self) -> Vec<(bool, String)> {
        std::mem::take(&mut self.news)
    }
}

/// True of a plain file that begins as a Standard MIDI File does. Others are not opened, since a pipe would wait for its writer.
pub fn is_standard_file(path: &Path) -> bool {
    let mut head = [0; 4];
    path.is_file() && File::open(path).is_ok_and(|mut f| f.read_exact(&mut head).is_ok()) && head == *b"MThd"
}

/// The raw MIDI devices of this machine.
pub fn devices() -> Vec<PathBuf> {
    let names = std::fs::read_dir("/dev/snd").into_iter().flatten().flatten().map(|e| e.path());
    let is = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("midi"));
    let mut all: Vec<PathBuf> = names.filter(is).collect();
    all.sort();
    all
}

/// Reads until it ends or nobody listens; a pipe again, once somebody writes again.
fn read(path: &Path, k: usize, tell: &SyncSender<(usize, Came)>) {
    let end = |why: String| tell.send((k, Came::End(why)));
    loop {
        let mut file = match File::open(path) {
            Ok(file) => file,
            Err(e) => {
                let _ = end(e.to_string());
                return;
            }
        };
        let mut piece = [0; PIECE];
        loop {
            match file.read(&mut piece) {
                Ok(0) => break,
                Ok(n) => {
                    if tell.send((k, Came::Bytes(piece[..n].to_vec()))).is_err() {
                        return;
                    }
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => {
                    let _ = end(e.to_string());
                    return;
                }
            }
        }
        if !is_pipe(path) {
            let _ = end("is at its end".into());
            return;
        }
        std::thread::sleep(AGAIN);
    }
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    std::fs::metadata(path).is_ok_and(|m| m.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}
