//! Files that appear complete or not at all.
//!
//! The bytes go to a hidden file beside the target (`.out.wav.90af….part`), which replaces the target in one step when
//! it is complete. A crash, a full disk or an interrupted command therefore never damages an existing file. The hidden
//! file is not in the temporary directory, because a rename is one step only within one file system. It is removed if
//! it is not completed, except after a kill.
//!
//! Symbolic links keep pointing to their target. A replaced file keeps its read permissions, and other users may never
//! write it. Anything but a plain file (`/dev/null`) is written directly, never replaced.
//!
//! A pipe, a FIFO and standard output receive their bytes at the end, from an unnamed temporary file. Some formats
//! store the length in the header, which must be rewritten at the end, and a pipe cannot seek. A pipe thus receives the
//! same bytes as a file. A header with the greatest possible length, written first, would not be accepted by all
//! readers of WAV.

use crate::error::{FileError, FileErrorKind};
use std::collections::hash_map::RandomState;
use std::fs::{self, File};
use std::hash::{BuildHasher as _, Hasher as _};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

/// Maximum mode of a file, whatever the umask of the process: other users may read it.
const PLAIN: u32 = 0o644;
/// Mode of a file that other users may not read.
const PRIVATE: u32 = 0o600;

/// Creates a file that does not exist yet, with this mode if the system has modes; the umask removes further bits.
///
/// # Errors
/// If the file exists or cannot be created.
pub fn new_file(path: &Path, mode: u32) -> std::io::Result<File> {
    let mut options = File::options();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, mode);
    #[cfg(not(unix))]
    let _ = mode;
    options.open(path)
}

/// Creates a folder, with `recursive` also those above it, into which other users do not write, whatever the umask is.
///
/// # Errors
/// If the folder cannot be created, or exists and is not `recursive`.
pub fn new_dir(path: &Path, recursive: bool) -> std::io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(recursive);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o755);
    builder.create(path)
}

/// Returns the permissions of a file to be replaced, without write permission for other users.
fn permissions(about: &fs::Metadata) -> fs::Permissions {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        fs::Permissions::from_mode(about.permissions().mode() & PLAIN)
    }
    #[cfg(not(unix))]
    about.permissions()
}

/// Bytes sent to a pipe at a time.
const ROOM: usize = 1 << 16;

/// A file being written, put in place when it is complete.
#[derive(Debug)]
pub struct AtomicFile {
    /// Path as given, with symbolic links followed.
    target: PathBuf,
    /// Hidden file until it replaces the target; `None` if the target is written directly.
    part: Option<PathBuf>,
    /// Pipe that receives the bytes of `file` at the end, if the target is one.
    pipe: Option<File>,
    file: File,
}

/// Returns true for paths that mean standard output: `-` and its names in the file system.
pub fn is_stdout(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

/// Returns another handle to standard output. Opening it by name would write from the start of a redirected file.
fn stdout() -> std::io::Result<File> {
    #[cfg(unix)]
    let owned = std::os::fd::AsFd::as_fd(&std::io::stdout()).try_clone_to_owned();
    #[cfg(windows)]
    let owned = std::os::windows::io::AsHandle::as_handle(&std::io::stdout()).try_clone_to_owned();
    // files need an operating system
    #[cfg(not(any(unix, windows)))]
    let owned: std::io::Result<File> = Err(std::io::ErrorKind::Unsupported.into());
    owned.map(File::from)
}

/// Writes a file and replaces an existing one.
///
/// # Errors
/// If the file cannot be written; an existing one stays.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let staged = AtomicFile::create(path)?;
    staged.fill(bytes)?;
    staged.commit()
}

/// Writes a file that does not exist yet.
///
/// # Errors
/// If the file exists, which leaves it unchanged, or cannot be written.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    fill_new(path, bytes, PLAIN)
}

/// Writes a file that does not exist yet and that only this user may read.
///
/// # Errors
/// As [`write_new`].
pub fn write_new_private(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    fill_new(path, bytes, PRIVATE)
}

fn fill_new(path: &Path, bytes: &[u8], mode: u32) -> Result<(), FileError> {
    let there =
        || FileError::new(FileErrorKind::Io, "the file already exists").file(path.display()).fix("choose another name");
    if path.symlink_metadata().is_ok() {
        return Err(there());
    }
    let mut staged = AtomicFile::begin(path, mode)?;
    staged.fill(bytes)?;
    let Some(part) = &staged.part else { return Ok(()) };
    staged.file.sync_all().map_err(|e| staged.fail(&e))?;
    // in one step, a hard link fails if the target exists; not all file systems have hard links
    match fs::hard_link(part, &staged.target) {
        Ok(()) => Ok(()),
        Err(_) if staged.target.symlink_metadata().is_ok() => Err(there()),
        Err(_) => {
            fs::rename(part, &staged.target).map_err(|e| staged.fail(&e))?;
            staged.part = None;
            Ok(())
        }
    }
}

impl AtomicFile {
    /// Begins a file; at a path for which [`is_stdout`] is true, its bytes go to standard output.
    ///
    /// # Errors
    /// If no file can be created there.
    pub fn create(path: &Path) -> Result<AtomicFile, FileError> {
        AtomicFile::begin(path, PLAIN)
    }

    /// Begins a file that only this user may read.
    ///
    /// # Errors
    /// As [`AtomicFile::create`].
    pub fn create_private(path: &Path) -> Result<AtomicFile, FileError> {
        AtomicFile::begin(path, PRIVATE)
    }

    fn begin(path: &Path, mode: u32) -> Result<AtomicFile, FileError> {
        let fail = |e: &std::io::Error| {
            let err = FileError::io(path, "it cannot be written", e);
            if e.kind() == std::io::ErrorKind::NotFound { err.fix("make the directory first") } else { err }
        };
        let through = |pipe: File| {
            let file = tempfile::tempfile().map_err(|e| {
                let e = FileError::io(path, "a temporary file cannot be created for it", &e);
                e.fix("set `TMPDIR` to a folder with free space")
            })?;
            Ok(AtomicFile { target: path.to_owned(), part: None, pipe: Some(pipe), file })
        };
        if is_stdout(path) {
            return through(stdout().map_err(|e| fail(&e))?);
        }
        let target = followed(path).map_err(|e| fail(&e))?;
        match fs::metadata(&target) {
            Ok(m) if m.is_dir() => {
                let e = FileError::new(FileErrorKind::Io, "it is a directory").file(path.display());
                return Err(e.fix("give the name of a file"));
            }
            Ok(m) if !m.is_file() => {
                let mut file = File::options().write(true).open(&target).map_err(|e| fail(&e))?;
                if file.stream_position().is_err() {
                    return through(file);
                }
                return Ok(AtomicFile { target, part: None, pipe: None, file });
            }
            _ => {}
        }
        let rights = fs::metadata(&target).ok().map(|m| permissions(&m));
        let Some(name) = target.file_name() else {
            return Err(FileError::usage("the path does not end in a file name").file(path.display()));
        };
        // random, because process ids repeat, and are the same on other machines
        let random = RandomState::new().build_hasher().finish();
        let part = target.with_file_name(format!(".{}.{random:016x}.part", name.to_string_lossy()));
        let file = new_file(&part, mode).map_err(|e| fail(&e))?;
        if let Some(rights) = rights {
            // a file system without permissions refuses
            let _ = file.set_permissions(rights);
        }
        Ok(AtomicFile { target, part: Some(part), pipe: None, file })
    }

    /// Creates an unnamed file on the same disk, or in the temporary directory for a pipe. It disappears when it is
    /// closed.
    ///
    /// # Errors
    /// If the system refuses it.
    pub fn scratch(&self) -> Result<AtomicFile, FileError> {
        let folder = self.part.as_deref().and_then(Path::parent);
        let here = |p: &Path| if p.as_os_str().is_empty() { PathBuf::from(".") } else { p.to_owned() };
        let file = tempfile::tempfile_in(folder.map_or_else(std::env::temp_dir, here)).map_err(|e| self.fail(&e))?;
        Ok(AtomicFile { target: self.target.clone(), part: None, pipe: None, file })
    }

    fn fail(&self, e: &std::io::Error) -> FileError {
        FileError::io(&self.target, "it cannot be written", e)
    }

    fn fill(&self, bytes: &[u8]) -> Result<(), FileError> {
        (&self.file).write_all(bytes).map_err(|e| self.fail(&e))
    }

    /// Returns another handle to the same file, for a writer to own. For plain files and pipes it can also read the
    /// bytes written.
    ///
    /// # Errors
    /// If the system has no more handles.
    pub fn handle(&self) -> Result<File, FileError> {
        self.file.try_clone().map_err(|e| self.fail(&e))
    }

    /// Returns true for a plain file.
    pub fn is_plain(&self) -> bool {
        self.part.is_some()
    }

    /// Returns true for a pipe: bytes that were sent cannot be changed.
    pub fn is_pipe(&self) -> bool {
        self.pipe.is_some()
    }

    /// Puts the finished file in place, or sends it through its pipe. The caller must have flushed all writes.
    ///
    /// # Errors
    /// If it cannot be put in place; an existing file stays.
    pub fn commit(mut self) -> Result<(), FileError> {
        if let Some(mut pipe) = self.pipe.take() {
            self.send(&mut pipe).map_err(|e| match e.kind() {
                std::io::ErrorKind::BrokenPipe => {
                    FileError::new(FileErrorKind::Left, "the program that reads it closed the pipe")
                        .file(self.target.display())
                }
                _ => self.fail(&e),
            })?;
        }
        if let Some(part) = self.part.take() {
            let done = self.file.sync_all().and_then(|()| fs::rename(&part, &self.target));
            if let Err(e) = done {
                self.part = Some(part);
                return Err(FileError::io(&self.target, "the finished file cannot be moved into place", &e));
            }
        }
        Ok(())
    }

    fn send(&mut self, pipe: &mut File) -> std::io::Result<()> {
        self.file.rewind()?;
        let mut bytes = vec![0; ROOM];
        loop {
            match self.file.read(&mut bytes)? {
                0 => return pipe.flush(),
                n => pipe.write_all(&bytes[..n])?,
            }
        }
    }
}

/// Returns the path that symbolic links lead to, whether it exists or not.
fn followed(path: &Path) -> std::io::Result<PathBuf> {
    let mut target = path.to_owned();
    // the limit of Linux
    for _ in 0..40 {
        if let Ok(there) = fs::canonicalize(&target) {
            return Ok(there);
        }
        let Ok(to) = fs::read_link(&target) else { return Ok(target) };
        target.pop();
        target.push(to);
    }
    Err(std::io::Error::other("its symbolic links form a loop"))
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            let _ = fs::remove_file(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn the_old_file_stays_until_the_new_one_is_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.wav");
        fs::write(&path, "good").unwrap();
        let staged = AtomicFile::create(&path).unwrap();
        staged.handle().unwrap().write_all(b"ha").unwrap();
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 2);
        assert_eq!(fs::read(&path).unwrap(), b"good");
        drop(staged);
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        assert_eq!(fs::read(&path).unwrap(), b"good");
        // two writers at once have different hidden files; the last one to finish wins
        let (a, b) = (AtomicFile::create(&path).unwrap(), AtomicFile::create(&path).unwrap());
        a.handle().unwrap().write_all(b"first").unwrap();
        b.handle().unwrap().write_all(b"second").unwrap();
        b.commit().unwrap();
        a.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
    }

    #[test]
    fn a_new_file_takes_no_place_of_another() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.toml");
        write_new(&path, b"mine").unwrap();
        assert_eq!(write_new(&path, b"yours").unwrap_err().what, "the file already exists");
        assert_eq!(fs::read(&path).unwrap(), b"mine");
        write(&path, b"yours").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"yours");
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn who_may_read_it_stays() {
        use std::os::unix::fs::PermissionsExt as _;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.html");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        write(&path, b"new").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&path), 0o600);
        fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).unwrap();
        write(&path, b"newer").unwrap();
        assert_eq!(mode(&path), 0o644, "other users do not write it");
        let private = dir.path().join("token");
        write_new_private(&private, b"secret").unwrap();
        assert_eq!(mode(&private), 0o600);
    }

    #[test]
    fn refuses_a_directory_and_a_place_that_is_not() {
        let dir = tempfile::tempdir().unwrap();
        assert!(AtomicFile::create(dir.path()).unwrap_err().what.contains("directory"));
        let e = AtomicFile::create(&dir.path().join("no/such/a.wav")).unwrap_err();
        assert_eq!((e.kind, e.fix.as_str()), (FileErrorKind::Io, "make the directory first"));
    }

    #[cfg(unix)]
    #[test]
    fn links_keep_pointing_and_devices_stay() {
        let dir = tempfile::tempdir().unwrap();
        let (real, link) = (dir.path().join("real"), dir.path().join("link"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let s = AtomicFile::create(&link).unwrap();
        s.handle().unwrap().write_all(b"new").unwrap();
        s.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&real).unwrap(), b"new");
        // also to a file that does not exist yet, in another folder, through two links
        let (sub, first, second) = (dir.path().join("sub"), dir.path().join("first"), dir.path().join("sub/second"));
        fs::create_dir(&sub).unwrap();
        std::os::unix::fs::symlink("sub/second", &first).unwrap();
        std::os::unix::fs::symlink("../made", &second).unwrap();
        write(&first, b"made").unwrap();
        assert!([&first, &second].iter().all(|l| fs::symlink_metadata(l).unwrap().is_symlink()));
        assert_eq!(fs::read(dir.path().join("made")).unwrap(), b"made");
        // a cycle is refused and stays
        let circle = dir.path().join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        let e = AtomicFile::create(&circle).unwrap_err().to_string();
        assert!(e.contains("it cannot be written: its symbolic links form a loop"), "{e}");
        assert!(fs::symlink_metadata(&circle).unwrap().is_symlink());
        let null = dir.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null).unwrap();
        let s = AtomicFile::create(&null).unwrap();
        assert!(!s.is_plain() && !s.is_pipe());
        s.commit().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    /// A header that is written last arrives first, also through a FIFO.
    #[cfg(unix)]
    #[test]
    fn a_pipe_gets_the_bytes_of_a_file() {
        let dir = tempfile::tempdir().unwrap();
        let fifo = dir.path().join("fifo");
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let from = fifo.clone();
        let reader = std::thread::spawn(move || fs::read(from).unwrap());
        let staged = AtomicFile::create(&fifo).unwrap();
        let mut file = staged.handle().unwrap();
        file.write_all(&vec![b'x'; 100_000]).unwrap();
        file.rewind().unwrap();
        file.write_all(b"head").unwrap();
        staged.commit().unwrap();
        assert!(reader.join().unwrap() == [&b"head"[..], &vec![b'x'; 100_000 - 4]].concat());
        // a closed pipe gives a different error from a full disk
        let from = fifo.clone();
        let reader = std::thread::spawn(move || drop(File::open(from).unwrap()));
        let staged = AtomicFile::create(&fifo).unwrap();
        reader.join().unwrap();
        staged.handle().unwrap().write_all(b"x").unwrap();
        assert_eq!(staged.commit().unwrap_err().kind, FileErrorKind::Left);
    }
}
