//! Lists the files of shared memory in `/dev/shm` and below the folder of a site.
//!
//! All users share `/dev/shm`, so a file counts as foreign by its owner, whatever its name.

use super::names::{SHM, parse};
use crate::host::user::uid;
use std::fs::{self, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Lists path and metadata of everything with this prefix, except files that vanish meanwhile.
pub(in crate::host) fn with_prefix(prefix: &str) -> impl Iterator<Item = (PathBuf, Metadata)> {
    let entries = fs::read_dir(SHM).into_iter().flatten().flatten();
    let named = entries.filter(move |e| e.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()));
    named.filter_map(|e| Some((e.path(), fs::symlink_metadata(e.path()).ok()?)))
}

pub(in crate::host) fn is_foreign(about: &Metadata) -> bool {
    about.uid() != uid() || !about.is_file()
}

/// Returns files of other users with this prefix, and what is not a regular file.
pub(in crate::host) fn foreign(prefix: &str) -> Vec<(PathBuf, Metadata)> {
    with_prefix(prefix).filter(|(_, about)| is_foreign(about)).collect()
}

/// Removes the files of this user whose names have these digits.
pub(in crate::host) fn remove_hash(root: &Path, digits: &str) {
    let mut remove = |path: PathBuf| {
        if parse(&name(&path)).is_some_and(|(_, _, hash)| hash == digits) {
            // a file that stays blocks nothing: no process looks for these digits again
            let _ = fs::remove_file(&path);
        }
    };
    each_ours(root, &mut remove);
}

pub(in crate::host) fn each_ours(root: &Path, each: &mut impl FnMut(PathBuf)) {
    let uid = uid();
    walk(Path::new(SHM), 0, &mut |path| {
        if fs::symlink_metadata(&path).is_ok_and(|m| m.uid() == uid) {
            each(path);
        }
    });
    walk(root, 3, each);
}

fn walk(folder: &Path, depth: u32, each: &mut impl FnMut(PathBuf)) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        match entry.file_type() {
            Ok(t) if t.is_dir() && depth > 0 => walk(&entry.path(), depth - 1, each),
            Ok(t) if !t.is_dir() => each(entry.path()),
            _ => {}
        }
    }
}

pub(in crate::host) fn name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}
