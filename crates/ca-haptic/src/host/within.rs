//! Sets a time limit on what iceoryx2 opens, lists or sweeps.
//!
//! iceoryx2 can wait without a limit: version 0.10 waits forever for a file of size zero. So each such step runs on a
//! separate thread, and the caller waits for that thread up to the limit. The ports are therefore of the kind that may
//! change threads; their locks are never contended. A thread that hangs is left behind, asleep most of the time.

use super::error::{HostError, HostErrorKind};
use super::shm::files;
use super::site::{Site, Swept};
use super::{ours, room};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Time limit for opening services. Each of them may wait a second for a process that is just starting or ending.
pub(super) const LIMIT: Duration = Duration::from_secs(10);

const SWEEP: Duration = Duration::from_secs(2);
/// Stack of the thread \[bytes\]. It is small, because a server with locked memory allocates all of it at each sweep.
const STACK: usize = 512 << 10;

/// Runs `act` on a site, after checking its files ([`ours`]) and that `need` bytes are free.
pub(super) fn within<T: Send + 'static>(
    site: &Site,
    need: u64,
    limit: Duration,
    act: impl FnOnce(&Site) -> Result<T, HostError> + Send + 'static,
) -> Result<T, HostError> {
    ours::check(site)?;
    room::check(need)?;
    let foreign = files::foreign(site.prefix());
    let made = limited(site, limit, act).map_err(|e| ours::blamed(site, e))?;
    ours::unmixed(site, &foreign)?;
    // files made by `act`
    ours::check(site)?;
    ours::reserve(site)?;
    Ok(made)
}

impl Site {
    /// Removes what killed processes left behind, so that their services are free again. Call it once to ten times a
    /// second, on a thread that is not real-time: it takes some milliseconds, or a fraction of one if there is nothing
    /// to remove.
    pub fn sweep(&self) -> Swept {
        // the next sweep tries again, and opening a service reports the reason
        within(self, 0, SWEEP, |site| Ok(site.swept())).unwrap_or_default()
    }
}

fn limited<T: Send + 'static>(
    site: &Site,
    limit: Duration,
    act: impl FnOnce(&Site) -> Result<T, HostError> + Send + 'static,
) -> Result<T, HostError> {
    let (tell, reported) = channel();
    let here = site.clone();
    std::thread::Builder::new()
        .name("ca opens".into())
        .stack_size(STACK)
        .spawn(move || {
            // after the limit, the receiver no longer exists
            let _ = tell.send(act(&here));
        })
        .map_err(|e| HostError::system("cannot start a thread", e))?;
    reported.recv_timeout(limit).unwrap_or_else(|e| {
        let root = site.root().display();
        let what = match e {
            RecvTimeoutError::Timeout => format!("shared memory at `{root}` does not open within {limit:?}"),
            RecvTimeoutError::Disconnected => format!("iceoryx2 failed to open the shared memory at `{root}`"),
        };
        let fix = "see `ca shm list`; remove the files of ended processes with `ca shm clean`, or set CA_SHM_ROOT to another \
                   folder";
        Err(HostError::new(HostErrorKind::System, what, fix))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn what_iceoryx2_waits_for_without_end_is_an_error() {
        let dir = tempfile::Builder::new().prefix("caw").tempdir_in("/tmp").expect("a folder");
        let site = Site::at(dir.path()).expect("a place");
        limited(&site, LIMIT, |site| site.node("one")).expect("it opens");
        // an empty counter, as another process could leave it after `ours::check`
        let name = std::fs::read_dir("/dev/shm")
            .expect("shared memory")
            .flatten()
            .find(|e| e.file_name().to_string_lossy().starts_with(site.prefix()))
            .expect("the counter of iceoryx2")
            .file_name();
        let path = Path::new("/dev/shm").join(name);
        std::fs::write(&path, []).expect("it is cut");
        let e = limited(&site, Duration::from_millis(300), |site| site.node("two")).expect_err("it hangs");
        assert!(e.kind == HostErrorKind::System && e.what.contains("300ms"), "{e}");
        // `ours::check` repairs it
        within(&site, 0, LIMIT, |site| site.node("three")).expect("it opens");
        crate::host::stale_shm::clean(&site);
    }
}
