//! What lies in the folder and in `/dev/shm` under names of ours, and who still uses it.
//!
//! A file is alive while a living process has it mapped or open, as the system says, in any version; no version can read
//! the books of another. Files are judged in groups, one for each version (prefix). In a group with living members, only
//! iceoryx2 removes what it knows to be dead; in a group without any, each file is removed. Files of other users are
//! ignored.

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
    /// what their names begin with
    pub prefix: String,
    /// version of the frames
    pub frames: String,
    /// release of iceoryx2
    pub iox: String,
    /// true where these are the names this build uses
    pub ours: bool,
    /// living processes that use them: id and name
    pub alive: Vec<(u32, String)>,
    /// the files, with their size \[bytes\]
    pub files: Vec<(PathBuf, u64)>,
}

impl Group {
    /// Size of all files \[bytes\].
    pub fn bytes(&self) -> u64 {
        self.files.iter().map(|f| f.1).sum()
    }
}

/// What was removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cleaned {
    /// the files that are gone, with their size \[bytes\]
    pub removed: Vec<(PathBuf, u64)>,
    /// what could not be removed, and why
    pub failed: Vec<(PathBuf, String)>,
    /// groups that living processes use, and which were left alone but for their dead members
    pub kept: Vec<Group>,
}

/// The prefix of a file of this place, in any version. Releases before the random digits took a hash of the folder.
fn prefix_of(site: &Site, name: &str) -> Option<String> {
    let (frames, iox, hash) = parse(name)?;
    let digits = site.prefix().strip_prefix(&stamp())?.strip_suffix('_')?;
    let before = || format!("{:08x}", fnv(site.root().as_os_str().as_encoded_bytes()) as u32);
    (hash == digits || hash == before()).then(|| format!("ca{frames}-{iox}-{hash}_"))
}

/// Everything of this place, one group a version.
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
        group.ours = prefix == site.prefix();
        group.files.sort();
        let alive: BTreeSet<_> = group.files.iter().filter_map(|f| users.get(&f.0)).flatten().cloned().collect();
        group.alive = alive.into_iter().collect();
        group.prefix = prefix;
        list.push(group);
    }
    list
}

/// Who has which of these files mapped or open, of the processes of this user.
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

/// Removes what no living process uses.
pub fn clean(site: &Site) -> Cleaned {
    let mut cleaned = Cleaned::default();
    let before: Vec<_> = list(site).into_iter().flat_map(|g| g.files).collect();
    // iceoryx2 knows which of its own are dead, also while others live
    site.sweep();
    for group in list(site) {
        if !group.alive.is_empty() {
            cleaned.kept.push(group);
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
    // folders of nodes, where nothing is in them any more
    if let Ok(nodes) = fs::read_dir(site.root().join("nodes")) {
        for node in nodes.flatten() {
            let _ = fs::remove_dir(node.path());
        }
    }
    cleaned.removed = before.into_iter().filter(|f| fs::symlink_metadata(&f.0).is_err()).collect();
    cleaned
}

/// An error where living processes of another version are at this place: they would never meet, and nobody would know
/// why.
pub(super) fn strangers(site: &Site) -> Result<(), HostError> {
    let mut other = false;
    each_ours(site.root(), &mut |path| {
        other |= prefix_of(site, &name(&path)).is_some_and(|p| p != site.prefix());
    });
    if !other {
        return Ok(());
    }
    let Some(group) = list(site).into_iter().find(|g| !g.ours && !g.alive.is_empty()) else { return Ok(()) };
    let me = uid();
    let who = group.alive.iter().map(|(id, name)| format!("{id} (`{name}`)")).collect::<Vec<_>>().join(", ");
    let what = format!(
        "process {who} at `{}` speaks frames {} over iceoryx2 {}; this is frames {VERSION} over iceoryx2 {}",
        site.root().display(),
        group.frames,
        group.iox,
        IOX,
    );
    let fix = format!("run both sides from one release of ca, or apart with CA_SHM_ROOT=/tmp/ca-{me}-b");
    Err(HostError::new(HostErrorKind::Version, what, fix))
}
