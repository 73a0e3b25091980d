//! Checks the files in `/dev/shm` that carry our prefix: owner, mode and size.
//!
//! iceoryx2 opens any file with the right name. A file of another user is ignored: iceoryx2 cannot open most of them, and a
//! step that fails names the file. If iceoryx2 did map such a file, whose content the other user can change, that is an
//! error ([`unmixed`]). An empty file of this user has lost its maker: it is removed, and so is a service in the folder
//! that was begun and not finished. The one file that iceoryx2 0.10 makes with mode 0666 (a counter; its configuration
//! cannot change that) is made here first, with mode 0600, and iceoryx2 opens what it finds. A later change of the mode
//! would be too late: another user may have opened the file before.

use super::error::{HostError, HostErrorKind};
use super::room;
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

/// How long a file may be without a byte in it: its maker is between two calls of the system.
const UNMADE: Duration = Duration::from_secs(1);

/// The counter of nodes in iceoryx2 0.10.0: the end of its name (the SHA-1 of the name of its type, then its own), and its
/// bytes: the release as a number, a counter, padding.
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
const RELEASE: u64 = 10 << 16;

/// Files of this user with our prefix.
fn files(site: &Site) -> impl Iterator<Item = (PathBuf, Metadata)> {
    with_prefix(site.prefix()).filter(|(_, about)| !is_foreign(about))
}

/// A failure of the system, which a file of another user may have caused: names that file.
pub(super) fn blamed(site: &Site, e: HostError) -> HostError {
    match foreign(site.prefix()).first() {
        Some((path, about)) if e.kind == HostErrorKind::System => {
            let what = format!("{}; `{}` of user {} may block it", e.what, path.display(), about.uid());
            let fix = "end all servers and devices of this place, which then takes other names; \
                       or remove that file (its user or root can)";
            HostError::new(e.kind, what, fix)
        }
        _ => e,
    }
}

/// An error where this process has mapped one of these files, or one that is there now, of another user.
pub(super) fn unmixed(site: &Site, before: &[(PathBuf, Metadata)]) -> Result<(), HostError> {
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
            let what = format!("`{path}` belongs to another user and could change under us");
            let fix = "end all servers and devices of this place, which then takes other names";
            return Err(HostError::new(HostErrorKind::Site, what, fix));
        }
    }
    Ok(())
}

fn failed(path: &Path, what: &str, e: &io::Error) -> HostError {
    let text = format!("`{}` {what}: {e}", path.display());
    HostError::new(HostErrorKind::Site, text, "see `ca shm list`, or set another CA_SHM_ROOT")
}

/// Closes our files to other users, removes those that no process can use, and makes the counter.
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
    for (path, about) in files(site) {
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
        let closed = !is_foreign(&about) && about.mode() & 0o777 == 0o600;
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
    for (path, about) in files(site) {
        // blocks are of 512 bytes, whatever the file system
        if about.blocks() * 512 >= about.len() || about.mode() & 0o600 != 0o600 {
            continue;
        }
        let Ok(file) = OpenOptions::new().write(true).open(&path) else { continue };
        room::take(&file, about.len()).map_err(|e| failed(&path, "has no room", &e))?;
    }
    Ok(())
}
