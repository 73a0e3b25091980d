//! A file that appears whole or not at all.
//!
//! Decides that a render is written into a hidden sibling (`.out.wav.90af….part`) and takes the place of the old file
//! in one step when it is finished, so that a crash, a full disk or an interrupted command never leaves half a file
//! over a good one. A sibling rather than a file in the temporary directory: only within one file system is renaming
//! one step. What is not finished removes itself; after a kill the sibling stays and says by its name what it is.
//! A symbolic link keeps pointing, a file keeps who may read it; what is not a plain file (`/dev/null`) is written
//! straight, never replaced.

use crate::error::{FileError, FileErrorKind};
use std::collections::hash_map::RandomState;
use std::fs::{self, File};
use std::hash::{BuildHasher as _, Hasher as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Where the bytes go until they are all there.
#[derive(Debug)]
pub struct AtomicFile {
    /// what the caller asked for, with symbolic links followed
    target: PathBuf,
    /// the sibling, until it has become the target; `None` where the target is written straight
    part: Option<PathBuf>,
    file: File,
}

/// Writes a file, in place of one that is there.
///
/// # Errors
/// Where it cannot be written; what was there stays.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let staged = AtomicFile::create(path)?;
    staged.fill(bytes)?;
    staged.commit()
}

/// Writes a file where there is none.
///
/// # Errors
/// Where there is one, which stays, and where it cannot be written.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let there = || FileError::new(FileErrorKind::Io, "it exists").file(path.display()).fix("choose another name");
    if path.symlink_metadata().is_ok() {
        return Err(there());
    }
    let mut staged = AtomicFile::create(path)?;
    staged.fill(bytes)?;
    let Some(part) = &staged.part else { return Ok(()) };
    staged.file.sync_all().map_err(|e| staged.fail(&e))?;
    // a link takes no other file's place, in one step; not all file systems have links
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
    /// Begins a file.
    ///
    /// # Errors
    /// Where no file can be there.
    pub fn create(path: &Path) -> Result<AtomicFile, FileError> {
        let fail = |e: &std::io::Error| {
            let err = FileError::io(path, "it cannot be written", e);
            if e.kind() == std::io::ErrorKind::NotFound { err.fix("make the directory first") } else { err }
        };
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        match fs::metadata(&target) {
            Ok(m) if m.is_dir() => {
                let e = FileError::new(FileErrorKind::Io, "it is a directory").file(path.display());
                return Err(e.fix("give the name of a file"));
            }
            Ok(m) if !m.is_file() => {
                let file = File::options().write(true).open(&target).map_err(|e| fail(&e))?;
                return Ok(AtomicFile { target, part: None, file });
            }
            _ => {}
        }
        let rights = fs::metadata(&target).ok().map(|m| m.permissions());
        let Some(name) = target.file_name() else {
            return Err(FileError::usage("it has no name").file(path.display()));
        };
        // random: numbers of processes come back, and are the same on other machines
        let random = RandomState::new().build_hasher().finish();
        let part = target.with_file_name(format!(".{}.{random:016x}.part", name.to_string_lossy()));
        let file = File::create_new(&part).map_err(|e| fail(&e))?;
        if let Some(rights) = rights {
            // a file system without rights has none to keep
            let _ = file.set_permissions(rights);
        }
        Ok(AtomicFile { target, part: Some(part), file })
    }

    fn fail(&self, e: &std::io::Error) -> FileError {
        FileError::io(&self.target, "it cannot be written", e)
    }

    fn fill(&self, bytes: &[u8]) -> Result<(), FileError> {
        (&self.file).write_all(bytes).map_err(|e| self.fail(&e))
    }

    /// Another handle to the same file, for a writer to own.
    ///
    /// # Errors
    /// Where the system has no more of them.
    pub fn handle(&self) -> Result<File, FileError> {
        self.file.try_clone().map_err(|e| self.fail(&e))
    }

    /// Whether the target is a plain file, in which one can go back.
    pub fn is_plain(&self) -> bool {
        self.part.is_some()
    }

    /// Puts the finished file in its place. All that was written must have been flushed.
    ///
    /// # Errors
    /// Where it cannot be put there; what was there stays.
    pub fn commit(mut self) -> Result<(), FileError> {
        if let Some(part) = self.part.take() {
            let done = self.file.sync_all().and_then(|()| fs::rename(&part, &self.target));
            if let Err(e) = done {
                self.part = Some(part);
                return Err(FileError::io(&self.target, "it cannot be put in its place", &e));
            }
        }
        Ok(())
    }
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
        // two at once do not share a sibling, the last one to finish wins
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
        assert_eq!(write_new(&path, b"yours").unwrap_err().what, "it exists");
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
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
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
        let null = dir.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null).unwrap();
        let s = AtomicFile::create(&null).unwrap();
        assert!(!s.is_plain());
        s.commit().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
