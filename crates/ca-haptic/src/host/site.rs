//! Where the shared memory of a user lives.
//!
//! Each user has one folder, `CA_SHM_ROOT` or `/tmp/ca-<uid>`, closed to other users. All names in the folder and in
//! `/dev/shm` begin with one prefix. It has the version of our frames, the release of iceoryx2 (its layout changes with
//! each) and the random digits of the folder (`shm/prefix.rs`), so two versions or two folders never touch each
//! other's memory. iceoryx2 reads no configuration file here, because the sizes of its queues are part of the protocol.

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

/// Shared memory between processes, with ports that are made on one thread and used on another
/// ([`within`](super::within)).
pub(super) type Ipc = ipc_threadsafe::Service;

/// Longest name of the folder \[bytes\]: with the prefix, a number of at most 36 digits and a suffix it must fit the
/// address of a socket, 107 bytes.
pub const LONGEST: usize = 44;

/// Links that are followed on the way to a folder, as in the kernel.
const LINKS: u32 = 40;

/// The library's own log is set once a process.
static LOGS: Once = Once::new();

/// Where devices and engine of a user meet.
#[derive(Clone, Debug)]
pub struct Site {
    root: PathBuf,
    prefix: String,
    /// protects the prefix for as long as a clone of this value lives
    _claim: Arc<File>,
}

/// Dead processes whose remains were found by [`Site::sweep`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Swept {
    /// remains that were removed
    pub removed: u32,
    /// remains that could not be removed now
    pub left: u32,
}

impl Site {
    /// The place of this user: `CA_SHM_ROOT`, or `/tmp/ca-<uid>`. If another user has made that folder, it is `ca` in
    /// `XDG_RUNTIME_DIR`.
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

    /// A place of one's own, made if it is not there.
    ///
    /// # Errors
    /// As [`Site::of_user`], or where the path is too long.
    pub fn at(root: &Path) -> Result<Site, HostError> {
        let bad =
            |what: &str, fix: &str| HostError::new(HostErrorKind::Site, format!("`{}` {what}", root.display()), fix);
        let fix = "set CA_SHM_ROOT to a short folder of your own, e.g. /tmp/ca-me";
        let text = root.to_str().ok_or_else(|| bad("is not UTF-8", fix))?.trim_end_matches('/');
        if !text.starts_with('/') {
            return Err(bad("is no absolute path", fix));
        }
        if text.len() > LONGEST {
            return Err(bad(&format!("has {} bytes; shared memory wants at most {LONGEST}", text.len()), fix));
        }
        let root = PathBuf::from(text);
        let safe = || match unsafe_step(&root) {
            None => Ok(()),
            Some((step, what)) => Err(bad(&format!("goes by way of `{}`, {what}", step.display()), fix)),
        };
        safe()?;
        if !root.exists() {
            fs::DirBuilder::new()
                .mode(0o700)
                .recursive(true)
                .create(&root)
                .map_err(|e| bad(&format!("cannot be made: {e}"), fix))?;
        }
        // again: somebody may have been faster
        safe()?;
        let about = fs::metadata(&root).map_err(|e| bad(&format!("cannot be looked at: {e}"), fix))?;
        if !about.is_dir() {
            return Err(bad("is no folder", fix));
        }
        if about.uid() != uid() {
            return Err(bad(&format!("belongs to user {}, who could read and change every frame", about.uid()), fix));
        }
        if about.mode() & 0o022 != 0 {
            return Err(bad("can be written by other users", "close it: `chmod 700`"));
        }
        LOGS.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
        let claimed = prefix::claim(
            &root,
            |digits| !files::foreign(&names::prefix(digits)).is_empty(),
            |digits| files::remove_hash(&root, digits),
        );
        let (digits, claim) =
            claimed.map_err(|e| bad(&format!("does not give a prefix for shared memory: {e}"), fix))?;
        Ok(Site { root, prefix: names::prefix(&digits), _claim: Arc::new(claim) })
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What all names of ours begin with, in the folder and in `/dev/shm`.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// For iceoryx2.
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

    /// A node of iceoryx2, named so that others can say who it is. Making one removes what dead ones left.
    pub(super) fn node(&self, name: &str) -> Result<Node<Ipc>, HostError> {
        let failed =
            |e: &dyn std::fmt::Debug| HostError::system(format!("`{}` cannot be used", self.root.display()), e);
        let name = NodeName::new(name).map_err(|e| failed(&e))?;
        // Ctrl-C is the program's
        NodeBuilder::new()
            .config(&self.config())
            .name(&name)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| failed(&e))
    }

    /// Every node: its name, its process, whether it lives.
    pub(super) fn nodes(&self, mut each: impl FnMut(NodeState<Ipc>)) -> Result<(), HostError> {
        Node::<Ipc>::list(&self.config(), |state| {
            each(state);
            CallbackProgression::Continue
        })
        .map_err(|e| HostError::system(format!("`{}` cannot be listed", self.root.display()), e))
    }

    /// Removes what killed processes left behind, without a limit of time: [`Site::sweep`] has one.
    pub(super) fn swept(&self) -> Swept {
        let mut swept = Swept::default();
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

    /// The process and the name of a living node.
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

/// The first step on the way to a folder by which another user could lead us elsewhere, and why: a symbolic link that
/// is neither ours nor root's, a folder in which everybody can rename what is not theirs.
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
        // what is not there yet, we make
        let Ok(about) = fs::symlink_metadata(&at) else { continue };
        if about.is_symlink() {
            if about.uid() != uid() && about.uid() != 0 {
                return Some((at, format!("a symbolic link of user {}", about.uid())));
            }
            links += 1;
            let Some(to) = fs::read_link(&at).ok().filter(|_| links <= LINKS) else {
                return Some((at, "a symbolic link that leads nowhere".into()));
            };
            at.pop();
            left.extend(to.components().rev().map(|c| PathBuf::from(c.as_os_str())));
        } else if !left.is_empty() && about.is_dir() && about.mode() & 0o1002 == 0o002 {
            return Some((at, "in which everybody can put another in its place (`chmod +t` prevents it)".into()));
        }
    }
    None
}

/// The first folder that other users leave to this one: `usual`, unless one of them has made it, or `runtime`. A process that
/// starts after the other user has removed it follows those that run already.
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
