//! Defines where the shared memory of a user is.
//!
//! Each user has one folder, `CA_SHM_ROOT` or `/tmp/ca-<uid>`, closed to other users. All names in the folder and in
//! `/dev/shm` begin with one prefix. It contains the version of the frames, the release of iceoryx2 (whose layout
//! changes with each release) and the random digits of the folder (`shm/prefix.rs`). So two versions or two folders
//! never access each other's memory. iceoryx2 reads no configuration file here, because the sizes of its queues are
//! part of the protocol.

use super::error::{HostError, HostErrorKind};
use super::shm::{files, names, prefix};
use super::user::uid;
use iceoryx2::node::NodeView;
use iceoryx2::prelude::{
    CallbackProgression, Config, FileName, Node, NodeBuilder, NodeName, NodeState, Path as IoxPath, ipc_threadsafe,
};
use iceoryx2::prelude::{LogLevel, SemanticString, SignalHandlingMode, set_log_level_from_env_or};
use std::fs::{self, File};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Once};

/// Shared memory between processes. Its ports may be made on one thread and used on another
/// ([`with_timeout`](super::timeout)).
pub(super) type Ipc = ipc_threadsafe::Service;

/// Longest path of the folder \[bytes\]. With the prefix, a number of at most 36 digits and a suffix, it must fit the
/// address of a socket, which has 107 bytes.
pub const LONGEST: usize = 44;

/// Maximum number of symbolic links followed in a path, as in the kernel.
const LINKS: u32 = 40;

/// Sets the log level of iceoryx2 once per process.
static LOGS: Once = Once::new();

/// Folder and prefix of the shared memory that devices and engine of a user share.
#[derive(Clone, Debug)]
pub struct Site {
    root: PathBuf,
    prefix: String,
    /// Lock on the prefix, until the last clone of this value is dropped.
    _claim: Arc<File>,
}

/// Number of killed processes whose files [`Site::remove_dead`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepResult {
    /// Processes whose files were removed.
    pub removed: u32,
    /// Processes whose files could not be removed now.
    pub left: u32,
}

impl Site {
    /// Returns the site of this user: `CA_SHM_ROOT`, or `/tmp/ca-<uid>`. If another user has made that folder, it is
    /// `ca` in `XDG_RUNTIME_DIR`.
    ///
    /// # Errors
    /// If the folder belongs to another user, is a symbolic link, or cannot be made.
    pub fn of_user() -> Result<Site, HostError> {
        let of_env = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let runtime = of_env("XDG_RUNTIME_DIR").map(|d| d.join("ca"));
        match of_env("CA_SHM_ROOT") {
            Some(root) => Site::at(&root),
            None => Site::at(&free(PathBuf::from(format!("/tmp/ca-{}", uid())), runtime)),
        }
    }

    /// Returns the site with the folder `root`, which is made if it does not exist.
    ///
    /// # Errors
    /// As [`Site::of_user`], or if the path is relative, longer than [`LONGEST`] or not UTF-8, another user could
    /// redirect it, or other users can write to the folder.
    pub fn at(root: &Path) -> Result<Site, HostError> {
        let bad =
            |what: &str, fix: &str| HostError::new(HostErrorKind::Site, format!("`{}` {what}", root.display()), fix);
        let fix = "set CA_SHM_ROOT to a short folder of your own, e.g. /tmp/ca-me";
        let text = root.to_str().ok_or_else(|| bad("is not UTF-8", fix))?.trim_end_matches('/');
        if !text.starts_with('/') {
            return Err(bad("is not an absolute path", fix));
        }
        if text.len() > LONGEST {
            return Err(bad(&format!("has {} bytes; at most {LONGEST} are allowed", text.len()), fix));
        }
        let root = PathBuf::from(text);
        let safe = || match unsafe_step(&root) {
            None => Ok(()),
            Some((step, what)) => Err(bad(&format!("passes through `{}`, {what}", step.display()), fix)),
        };
        safe()?;
        if !root.exists() {
            fs::DirBuilder::new()
                .mode(0o700)
                .recursive(true)
                .create(&root)
                .map_err(|e| bad(&format!("cannot be created: {e}"), fix))?;
        }
        // again, because another process may have made a part of the path meanwhile
        safe()?;
        let about = fs::metadata(&root).map_err(|e| bad(&format!("cannot be read: {e}"), fix))?;
        if !about.is_dir() {
            return Err(bad("is not a folder", fix));
        }
        if about.uid() != uid() {
            return Err(bad(&format!("belongs to user {}, who could read and change every frame", about.uid()), fix));
        }
        if about.mode() & 0o022 != 0 {
            return Err(bad("can be written by other users", &format!("run `chmod 700 {}`", root.display())));
        }
        LOGS.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
        let claimed = prefix::claim(
            &root,
            |digits| !files::foreign(&names::prefix(digits)).is_empty(),
            |digits| files::remove_hash(&root, digits),
        );
        let (digits, claim) =
            claimed.map_err(|e| bad(&format!("does not provide a name prefix for shared memory: {e}"), fix))?;
        Ok(Site { root, prefix: names::prefix(&digits), _claim: Arc::new(claim) })
    }

    /// Returns the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the prefix of all names in the folder and in `/dev/shm`.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// Returns the configuration of iceoryx2.
    pub fn config(&self) -> Config {
        let mut config = Config::default();
        // both were checked when the site was made
        if let Ok(root) = IoxPath::new(self.root.as_os_str().as_encoded_bytes()) {
            config.global.set_root_path(&root);
        }
        if let Ok(prefix) = FileName::new(self.prefix.as_bytes()) {
            config.global.prefix = prefix;
        }
        config
    }

    /// Makes a node of iceoryx2, with a name that other processes can report. This removes the files of dead nodes.
    pub(super) fn node(&self, name: &str) -> Result<Node<Ipc>, HostError> {
        let failed =
            |e: &dyn std::fmt::Debug| HostError::system(format!("`{}` cannot be used", self.root.display()), e);
        let name = NodeName::new(name).map_err(|e| failed(&e))?;
        // the program handles Ctrl-C
        NodeBuilder::new()
            .config(&self.config())
            .name(&name)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| failed(&e))
    }

    pub(super) fn nodes(&self, mut each: impl FnMut(NodeState<Ipc>)) -> Result<(), HostError> {
        Node::<Ipc>::list(&self.config(), |state| {
            each(state);
            CallbackProgression::Continue
        })
        .map_err(|e| HostError::system(format!("`{}` cannot be listed", self.root.display()), e))
    }

    /// Removes what killed processes left behind, without the time limit of [`Site::remove_dead`].
    pub(super) fn swept(&self) -> SweepResult {
        let mut swept = SweepResult::default();
        let _ = self.nodes(|state| {
            if let NodeState::Dead(node) = state {
                match node.try_remove_stale_resources() {
                    Ok(()) => swept.removed += 1,
                    Err(_) => swept.left += 1,
                }
            }
        });
        swept
    }

    /// Describes the process of the living node that matches `id`.
    pub(super) fn who(&self, id: impl Fn(&iceoryx2::identifiers::UniqueNodeId) -> bool) -> Option<String> {
        let mut who = None;
        let _ = self.nodes(|state| {
            if let NodeState::Alive(node) = state {
                if let (true, Some(d)) = (id(node.id()), node.details()) {
                    who = Some(format!("process {} (`{}`)", d.process_id().value(), d.executable()));
                }
            }
        });
        who
    }
}

/// Returns the first step of a path by which another user could redirect it, and the reason.
///
/// Such a step is a symbolic link that belongs to neither this user nor root, or a folder in which all users may rename
/// the files of other users.
fn unsafe_step(path: &Path) -> Option<(PathBuf, String)> {
    let mut left: Vec<PathBuf> = path.components().rev().map(|c| PathBuf::from(c.as_os_str())).collect();
    let (mut at, mut links) = (PathBuf::new(), 0);
    while let Some(step) = left.pop() {
        match step.components().next() {
            Some(Component::ParentDir) => {
                at.pop();
                continue;
            }
            Some(Component::CurDir) | None => continue,
            _ => at.push(&step),
        }
        // a missing step is made later
        let Ok(about) = fs::symlink_metadata(&at) else { continue };
        if about.is_symlink() {
            if about.uid() != uid() && about.uid() != 0 {
                return Some((at, format!("a symbolic link owned by user {}", about.uid())));
            }
            links += 1;
            let Some(to) = fs::read_link(&at).ok().filter(|_| links <= LINKS) else {
                return Some((at, "a symbolic link that does not lead to a folder".into()));
            };
            at.pop();
            left.extend(to.components().rev().map(|c| PathBuf::from(c.as_os_str())));
        } else if !left.is_empty() && about.is_dir() && about.mode() & 0o1002 == 0o002 {
            let fix = format!("`chmod +t {}` prevents this", at.display());
            return Some((at, format!("a folder in which every user can replace files ({fix})")));
        }
    }
    None
}

/// Returns `usual`, or `runtime` if another user has made `usual`. A missing `usual` also gives way to an existing
/// `runtime`: the other user may have removed it, and processes that run already use `runtime`.
fn free(usual: PathBuf, runtime: Option<PathBuf>) -> PathBuf {
    let taken = fs::symlink_metadata(&usual).map(|m| m.uid() != uid());
    match (taken, runtime) {
        (Ok(true), Some(runtime)) => runtime,
        (Err(_), Some(runtime)) if runtime.is_dir() => runtime,
        _ => usual,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::chown;

    #[test]
    fn a_folder_that_another_user_made_is_not_waited_for() {
        let here = tempfile::tempdir().unwrap();
        let [usual, runtime] = ["usual", "runtime"].map(|name| here.path().join(name));
        let chosen = || free(usual.clone(), Some(runtime.clone()));
        assert_eq!(chosen(), usual);
        fs::create_dir(&usual).unwrap();
        assert_eq!(chosen(), usual);
        if uid() != 0 || chown(&usual, Some(65_534), None).is_err() {
            return;
        }
        assert_eq!(chosen(), runtime);
        assert_eq!(free(usual.clone(), None), usual);
        // once the other folder is gone, the first process and the next still meet
        fs::create_dir(&runtime).unwrap();
        fs::remove_dir(&usual).unwrap();
        assert_eq!(chosen(), runtime);
    }
}
