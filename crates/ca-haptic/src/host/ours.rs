//! What lies in `/dev/shm` under names of ours: whose it is, who may open it, and whether it is whole.
//!
//! Decides to look before iceoryx2 opens anything, since it takes any file with the right name: one of another user could
//! hold it up for ever or give it memory that the other user writes. A file of another user is an error. A file of ours
//! without a byte in it has no maker any more, or somebody cut it, and nobody can use it: it is removed. So is a service in
//! the folder of the place that was begun and not finished, whose maker was killed while it started. The one file that
//! iceoryx2 0.10 makes for everybody (a counter, mode 0666; no option of its configuration changes that) is made here
//! first, with mode 0600, and iceoryx2 opens what it finds. A change of the mode afterwards would be too late: whoever
//! opened the file before keeps it open.

use super::error::{HostError, HostErrorKind};
use super::site::{SHM, Site, uid};
use std::fs::{self, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How long a file may be without a byte in it: its maker is between two calls of the system.
const UNMADE: Duration = Duration::from_secs(1);

/// The counter of nodes in iceoryx2 0.10.0: the end of its name (the SHA-1 of the name of its type, then its own), and its
/// bytes: the release as a number, a counter, padding.
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
const RELEASE: u64 = 10 << 16;

/// Files under names of ours.
fn files(site: &Site) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(SHM) else { return Vec::new() };
    let ours = |e: &fs::DirEntry| e.file_name().as_encoded_bytes().starts_with(site.prefix().as_bytes());
    entries.flatten().filter(ours).map(|e| e.path()).collect()
}

fn failed(path: &Path, what: &str, e: &io::Error) -> HostError {
    let text = format!("`{}` {what}: {e}", path.display());
    HostError::new(HostErrorKind::Site, text, "see `ca shm list`, or set another CA_SHM_ROOT")
}

/// An error where a file under a name of ours is not ours; closes ours to others, and removes what nobody can use.
pub(super) fn check(site: &Site) -> Result<(), HostError> {
    if !Path::new(SHM).is_dir() {
        return Ok(());
    }
    let end = Instant::now() + UNMADE;
    loop {
        let unmade = look(site)?;
        if unmade.is_empty() {
            break;
        }
        if Instant::now() > end {
            for path in unmade {
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

/// Files that are still empty.
fn look(site: &Site) -> Result<Vec<PathBuf>, HostError> {
    let mut unmade = Vec::new();
    for path in files(site) {
        // one that went away meanwhile is no obstacle
        let Ok(about) = fs::symlink_metadata(&path) else { continue };
        if about.uid() != uid() || !about.is_file() {
            let whose = if about.is_file() { "belongs to" } else { "is no file, of" };
            let what = format!("`{}` is under a name of this place and {whose} user {}", path.display(), about.uid());
            let fix = "remove it (that user or root can), or set another CA_SHM_ROOT";
            return Err(HostError::new(HostErrorKind::Site, what, fix));
        }
        if about.len() == 0 {
            unmade.push(path);
        } else if about.mode() & 0o077 != 0 && !is_counter(site, &path) {
            match fs::set_permissions(&path, Permissions::from_mode(0o600)) {
                Err(e) if e.kind() != ErrorKind::NotFound => {
                    return Err(failed(&path, "is open to other users and cannot be closed", &e));
                }
                _ => {}
            }
        }
    }
    unmade.extend(half_made(site));
    Ok(unmade)
}

/// Services whose maker has not finished them: it may write there until then, and nobody else can open them.
fn half_made(site: &Site) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(site.root().join("services")).into_iter().flatten().flatten();
    entries.filter(|e| e.metadata().is_ok_and(|m| m.is_file() && m.mode() & 0o200 != 0)).map(|e| e.path())
}

fn is_counter(site: &Site, path: &Path) -> bool {
    path == counter_of(site)
}

fn counter_of(site: &Site) -> PathBuf {
    Path::new(SHM).join(format!("{}{COUNTER}", site.prefix()))
}

/// Makes the counter, or makes it anew where others may have opened it. Whoever holds the old one holds nothing that
/// matters: a process looks into it only while it makes a node.
fn counter(site: &Site) -> Result<(), HostError> {
    static TURN: AtomicU32 = AtomicU32::new(0);
    let path = counter_of(site);
    let whole = |bytes: &[u8]| bytes.len() == 16 && bytes[..8] == RELEASE.to_le_bytes();
    if let Ok(about) = fs::symlink_metadata(&path) {
        let closed = about.mode() & 0o777 == 0o600;
        if closed && fs::read(&path).is_ok_and(|bytes| whole(&bytes)) {
            return Ok(());
        }
    }
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&RELEASE.to_le_bytes());
    let turn = TURN.fetch_add(1, Relaxed);
    let fresh = Path::new(SHM).join(format!("{}{}-{turn}.new", site.prefix(), std::process::id()));
    let made = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&fresh);
    let made = made.and_then(|mut f| f.write_all(&bytes)).and_then(|()| fs::rename(&fresh, &path));
    made.map_err(|e| {
        let _ = fs::remove_file(&fresh);
        failed(&path, "cannot be made", &e)
    })
}

/// Takes the memory of all our files now, so that a `/dev/shm` that others fill later ends nobody with a SIGBUS.
pub(super) fn reserve(site: &Site) -> Result<(), HostError> {
    for path in files(site) {
        let Ok(about) = fs::symlink_metadata(&path) else { continue };
        // blocks are of 512 bytes, whatever the file system
        if about.blocks() * 512 >= about.len() || !about.is_file() || about.mode() & 0o600 != 0o600 {
            continue;
        }
        let Ok(file) = OpenOptions::new().write(true).open(&path) else { continue };
        super::room::take(&file, about.len()).map_err(|e| failed(&path, "has no room", &e))?;
    }
    Ok(())
}
