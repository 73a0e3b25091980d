//! Lists the files of a site in its folder and in `/dev/shm` with the processes that use them, and removes stale files.
//!
//! A file is in use while `/proc` shows a process that has it mapped or open. This holds for files of all versions; the
//! records in the files can be read only by the version that wrote them. Files form groups, one for each version
//! (prefix). In a group in use, iceoryx2 removes the files of dead processes, and no other file is removed. In any other
//! group, each file is removed. Files of other users are ignored.

use super::error::{HostError, HostErrorKind};
use super::shm::files::{each_ours, name};
use super::shm::names::{IOX, parse, stamp};
use super::site::Site;
use super::user::uid;
use crate::frame::{VERSION, fnv};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

/// All files of one version.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Group {
    /// Common beginning of the file names.
    pub prefix: String,
    /// Version of the frames.
    pub frames: String,
    /// Release of iceoryx2.
    pub iox: String,
    /// True if this build uses these names.
    pub current: bool,
    /// Processes that use the files: id and name.
    pub alive: Vec<(u32, String)>,
    /// Path and size \[bytes\] of each file.
    pub files: Vec<(PathBuf, u64)>,
}

impl Group {
    /// Returns the total size of the files \[bytes\].
    pub fn bytes(&self) -> u64 {
        self.files.iter().map(|f| f.1).sum()
    }
}

/// Result of [`clean`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CleanResult {
    /// Path and size \[bytes\] of each removed file.
    pub removed: Vec<(PathBuf, u64)>,
    /// Path of each file that could not be removed, and the reason.
    pub failed: Vec<(PathBuf, String)>,
    /// Groups in use; only their dead files were removed.
    pub in_use: Vec<Group>,
}

/// Returns the prefix of a file of this site, in any version. Older releases used a hash of the folder as digits.
fn prefix_of(site: &Site, name: &str) -> Option<String> {
    let (frames, iox, hash) = parse(name)?;
    let digits = site.prefix().strip_prefix(&stamp())?.strip_suffix('_')?;
    let before = || format!("{:08x}", fnv(site.root().as_os_str().as_encoded_bytes()) as u32);
    (hash == digits || hash == before()).then(|| format!("ca{frames}-{iox}-{hash}_"))
}

/// Lists all files of this site, one group for each version.
pub fn list(site: &Site) -> Vec<Group> {
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    let mut add = |path: PathBuf| {
        if let Some(prefix) = prefix_of(site, &name(&path)) {
            let bytes = fs::symlink_metadata(&path).map_or(0, |m| m.len());
            groups.entry(prefix).or_default().files.push((path, bytes));
        }
    };
    each_ours(site.root(), &mut add);
    let users = users(&groups.values().flat_map(|g| g.files.iter().map(|f| f.0.clone())).collect());
    let mut list = Vec::new();
    for (prefix, mut group) in groups {
        let (frames, iox, _) = parse(&prefix).unwrap_or_default();
        (group.frames, group.iox) = (frames.into(), iox.into());
        group.current = prefix == site.prefix();
        group.files.sort();
        let alive: BTreeSet<_> = group.files.iter().filter_map(|f| users.get(&f.0)).flatten().cloned().collect();
        group.alive = alive.into_iter().collect();
        group.prefix = prefix;
        list.push(group);
    }
    list
}

/// Returns the processes of this user that have each file mapped or open.
fn users(files: &BTreeSet<PathBuf>) -> BTreeMap<PathBuf, Vec<(u32, String)>> {
    let mut users: BTreeMap<PathBuf, Vec<(u32, String)>> = BTreeMap::new();
    let Ok(processes) = fs::read_dir("/proc") else { return users };
    for process in processes.flatten() {
        let Some(id) = process.file_name().to_str().and_then(|n| n.parse::<u32>().ok()) else { continue };
        let mut uses = BTreeSet::new();
        if let Ok(maps) = fs::read_to_string(process.path().join("maps")) {
            for path in maps.lines().filter_map(|l| l.find('/').map(|at| PathBuf::from(&l[at..]))) {
                if files.contains(&path) {
                    uses.insert(path);
                }
            }
        }
        if let Ok(open) = fs::read_dir(process.path().join("fd")) {
            for path in open.flatten().filter_map(|f| fs::read_link(f.path()).ok()) {
                if files.contains(&path) {
                    uses.insert(path);
                }
            }
        }
        if !uses.is_empty() {
            let name = fs::read_to_string(process.path().join("comm")).unwrap_or_default();
            for path in uses {
                users.entry(path).or_default().push((id, name.trim().into()));
            }
        }
    }
    users
}

/// Removes the files that no process uses.
pub fn clean(site: &Site) -> CleanResult {
    let mut cleaned = CleanResult::default();
    let before: Vec<_> = list(site).into_iter().flat_map(|g| g.files).collect();
    // iceoryx2 can remove dead files in a group that is in use
    site.remove_dead();
    for group in list(site) {
        if !group.alive.is_empty() {
            cleaned.in_use.push(group);
            continue;
        }
        for (path, _) in group.files {
            if let Err(e) = fs::remove_file(&path)
                && e.kind() != std::io::ErrorKind::NotFound
            {
                cleaned.failed.push((path, e.to_string()));
            }
        }
    }
    // folders of nodes, if empty
    if let Ok(nodes) = fs::read_dir(site.root().join("nodes")) {
        for node in nodes.flatten() {
            let _ = fs::remove_dir(node.path());
        }
    }
    cleaned.removed = before.into_iter().filter(|f| fs::symlink_metadata(&f.0).is_err()).collect();
    cleaned
}

/// Returns an error if processes of another version run at this site: they would ignore each other silently.
pub(super) fn strangers(site: &Site) -> Result<(), HostError> {
    let mut other = false;
    each_ours(site.root(), &mut |path| {
        other |= prefix_of(site, &name(&path)).is_some_and(|p| p != site.prefix());
    });
    if !other {
        return Ok(());
    }
    let Some(group) = list(site).into_iter().find(|g| !g.current && !g.alive.is_empty()) else { return Ok(()) };
    let me = uid();
    let who = group.alive.iter().map(|(id, name)| format!("{id} (`{name}`)")).collect::<Vec<_>>().join(", ");
    let what = format!(
        "process {who} at `{}` uses frame version {} and iceoryx2 {}; this process uses {VERSION} and {}",
        site.root().display(),
        group.frames,
        group.iox,
        IOX,
    );
    let fix = format!("use the same release of ca for both, or separate them with `CA_SHM_ROOT=/tmp/ca-{me}-b`");
    Err(HostError::new(HostErrorKind::Version, what, fix))
}
