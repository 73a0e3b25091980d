//! Raw MIDI bytes from kernel devices (`/dev/snd/midiC0D0`), pipes and files.
//!
//! Plain files need neither a library nor headers. Each file has its own thread, because a read from a device blocks.
//! The queue to this process is bounded, so that an endless pipe uses little memory.

use super::Cable;
use crate::error::{FileError, FileErrorKind};
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Bytes read at a time, and pieces that may wait in the queue.
const PIECE: usize = 256;
const WAITING: usize = 16;
/// Pieces played per turn: fewer events than the engine accepts per turn.
const TURN: usize = 4;
/// Time until a pipe is reopened after its writer closed it.
const AGAIN: Duration = Duration::from_millis(50);

enum Came {
    Bytes(Vec<u8>),
    /// The file has ended; the reason in words.
    End(String),
}

/// Open cables.
pub struct Cables {
    names: Vec<String>,
    open: Vec<Cable>,
    came: Receiver<(usize, Came)>,
    messages: Vec<(bool, String)>,
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
                    let what = format!("a thread for {} cannot be started: {e}", path.display());
                    return Err(FileError::new(FileErrorKind::Io, what));
                }
            }
        }
        let open = names.iter().map(|_| Cable::default()).collect();
        Ok(Cables { names, open, came, messages: Vec::new() })
    }

    /// Returns the paths of the open cables.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Passes the bytes received since the last turn to `feed`, up to four pieces.
    pub fn poll(&mut self, mut feed: impl FnMut(&mut Cable, &[u8])) {
        for _ in 0..TURN {
            let Ok((k, came)) = self.came.try_recv() else { return };
            match came {
                Came::Bytes(bytes) => feed(&mut self.open[k], &bytes),
                Came::End(why) => self.messages.push((true, format!("MIDI: {}: {why}", self.names[k]))),
            }
        }
    }

    /// Returns messages for people since the last call, each with true if it is an error.
    pub fn take_messages(&mut self) -> Vec<(bool, String)> {
        std::mem::take(&mut self.messages)
    }
}

/// Returns true for a plain file that begins like a Standard MIDI File. Other files are not opened, since opening a
/// pipe blocks until it has a writer.
pub fn is_standard_file(path: &Path) -> bool {
    let mut head = [0; 4];
    path.is_file() && File::open(path).is_ok_and(|mut f| f.read_exact(&mut head).is_ok()) && head == *b"MThd"
}

/// Returns the raw MIDI devices of this machine.
pub fn devices() -> Vec<PathBuf> {
    let names = std::fs::read_dir("/dev/snd").into_iter().flatten().flatten().map(|e| e.path());
    let is = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("midi"));
    let mut all: Vec<PathBuf> = names.filter(is).collect();
    all.sort();
    all
}

/// Reads until the file ends or the receiver is gone. A pipe is reopened for its next writer.
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
            let _ = end("the file has ended".into());
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
