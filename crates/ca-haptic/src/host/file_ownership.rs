//! Checks the files in `/dev/shm` that carry our prefix: owner, mode and size.
//!
//! iceoryx2 opens any file with the expected name. A file of another user is ignored: iceoryx2 cannot open most of
//! them, and a step that fails names the file. If iceoryx2 did map such a file, that is an error ([`check_mapped`]), because
//! the other user can change its content. An empty file of this user is left over from a process that ended, and is
//! removed. So is an unfinished service in the folder.
//!
//! iceoryx2 0.10 makes one file, a counter, with mode 0666, which its configuration cannot change. This module makes
//! that file first, with mode 0600, and iceoryx2 opens it. A later change of the mode would be too late: another user
//! may have opened the file before.

use super::error::{HostError, HostErrorKind};
use super::free_memory;
use super::shm::files::{foreign, is_foreign, with_prefix};
use super::shm::names::SHM;
use super::site::Site;
use std::collections::BTreeSet;
use std::fs::{self, Metadata, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time for which a file may be empty, while another process is between the two system calls that make it.
const MAX_UNFINISHED: Duration = Duration::from_secs(1);

/// End of the file name of the node counter in iceoryx2 0.10.0: the SHA-1 of the name of its type, then its own name.
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
/// First 8 bytes of the counter file: the release as a number. A counter and padding follow.
const RELEASE: u64 = 10 << 16;

fn files(site: &Site) -> impl Iterator<Item = (PathBuf, Metadata)> {
    with_prefix(site.prefix()).filter(|(_, about)| !is_foreign(about))
}

/// Adds to a system error the file of another user that may have caused it.
pub(super) fn name_blocking_file(site: &Site, e: HostError) -> HostError {
    match foreign(site.prefix()).first() {
        Some((path, about)) if e.kind == HostErrorKind::System => {
            let what = format!("{}; `{}` of user {} may block it", e.what, path.display(), about.uid());
            let fix = "stop all servers and devices that use this folder, so that the next one uses other file names; \
                       or let that user or root remove the file";
            HostError::new(e.kind, what, fix)
        }
        _ => e,
    }
}

/// Returns an error if this process has mapped a file of another user, from the list `before` or present now.
pub(super) fn check_mapped(site: &Site, before: &[(PathBuf, Metadata)]) -> Result<(), HostError> {
    let now = foreign(site.prefix());
    let foreign: BTreeSet<u64> = before.iter().chain(&now).map(|(_, about)| about.ino()).collect();
    if foreign.is_empty() {
        return Ok(());
    }
    let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let names = format!("{SHM}/{}", site.prefix());
    for line in maps.lines().filter(|l| l.contains(&names)) {
        // address, rights, offset, device, inode, path
        let inode = line.split_whitespace().nth(4).and_then(|n| n.parse().ok());
        if inode.is_some_and(|n| foreign.contains(&n)) {
            let path = &line[line.find(&names).unwrap_or_default()..];
            let what = format!("`{path}` belongs to another user, who could change it at any time");
            let fix = "stop all servers and devices that use this folder, so that the next one uses other file names";
            return Err(HostError::new(HostErrorKind::Site, what, fix));
        }
    }
    Ok(())
}

fn failed(path: &Path, what: &str, e: &io::Error) -> HostError {
    let text = format!("`{}` {what}: {e}", path.display());
    HostError::new(HostErrorKind::Site, text, "see `ca shm list`, or set CA_SHM_ROOT to another folder")
}

/// Closes the files of this user to other users, removes those that no process can use, and makes the counter.
pub(super) fn check(site: &Site) -> Result<(), HostError> {
    if !Path::new(SHM).is_dir() {
        return Ok(());
    }
    let end = Instant::now() + MAX_UNFINISHED;
    loop {
        let unfinished_files = close_to_others(site)?;
        if unfinished_files.is_empty() {
            break;
        }
        if Instant::now() > end {
            for path in unfinished_files {
                match fs::remove_file(&path) {
                    Err(e) if e.kind() != ErrorKind::NotFound => {
                        return Err(failed(&path, "is empty and cannot be removed", &e));
                    }
                    _ => {}
                }
            }
            break;
        }
        sleep(Duration::from_millis(2));
    }
    counter(site)
}

/// Sets modes to 0600, and returns empty files and unfinished services.
fn close_to_others(site: &Site) -> Result<Vec<PathBuf>, HostError> {
    let mut unfinished_files = Vec::new();
    for (path, about) in files(site) {
        if about.len() == 0 {
            unfinished_files.push(path);
        } else if about.mode() & 0o077 != 0 && !is_counter(site, &path) {
            match fs::set_permissions(&path, Permissions::from_mode(0o600)) {
                Err(e) if e.kind() != ErrorKind::NotFound => {
                    return Err(failed(&path, "is open to other users, and its mode cannot be changed", &e));
                }
                _ => {}
            }
        }
    }
    unfinished_files.extend(unfinished(site));
    Ok(unfinished_files)
}

/// Returns services that are not finished: they are writable until then, and no other process can open them.
fn unfinished(site: &Site) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(site.root().join("services")).into_iter().flatten().flatten();
    entries.filter(|e| e.metadata().is_ok_and(|m| m.is_file() && m.mode() & 0o200 != 0)).map(|e| e.path())
}

fn is_counter(site: &Site, path: &Path) -> bool {
    path == counter_of(site)
}

fn counter_of(site: &Site) -> PathBuf {
    Path::new(SHM).join(format!("{}{COUNTER}", site.prefix()))
}

/// Makes the counter, and replaces one that other users may have opened. Processes read it only to make a node.
fn counter(site: &Site) -> Result<(), HostError> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let path = counter_of(site);
    let valid = |bytes: &[u8]| bytes.len() == 16 && bytes[..8] == RELEASE.to_le_bytes();
    if let Ok(about) = fs::symlink_metadata(&path) {
        let closed = !is_foreign(&about) && about.mode() & 0o777 == 0o600;
        if closed && fs::read(&path).is_ok_and(|bytes| valid(&bytes)) {
            return Ok(());
        }
    }
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&RELEASE.to_le_bytes());
    let count = COUNT.fetch_add(1, Relaxed);
    let new = Path::new(SHM).join(format!("{}{}-{count}.new", site.prefix(), std::process::id()));
    let made = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&new);
    let made = made.and_then(|mut f| f.write_all(&bytes)).and_then(|()| fs::rename(&new, &path));
    made.map_err(|e| {
        let _ = fs::remove_file(&new);
        failed(&path, "cannot be created", &e)
    })
}

/// Allocates the memory of all files now, so that no process gets a SIGBUS when `/dev/shm` is full later.
pub(super) fn allocate(site: &Site) -> Result<(), HostError> {
    for (path, about) in files(site) {
        // a block is 512 bytes on any file system
        if about.blocks() * 512 >= about.len() || about.mode() & 0o600 != 0o600 {
            continue;
        }
        let Ok(file) = OpenOptions::new().write(true).open(&path) else { continue };
        free_memory::allocate(&file, about.len()).map_err(|e| failed(&path, "does not fit into memory", &e))?;
    }
    Ok(())
}
