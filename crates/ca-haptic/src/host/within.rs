//! A limit of time on whatever iceoryx2 opens, lists or sweeps.
//!
//! Decides to do such steps on a thread of their own and to wait for that thread no longer than a limit: some of iceoryx2's
//! own waits have none (a file of size zero holds up version 0.10 for ever), and no caller of ours may hang with them. So
//! ports are of the kind that may change threads; their locks are never contended. A thread that hangs is left behind,
//! asleep most of the time.

use super::error::{HostError, HostErrorKind};
use super::shm::files;
use super::site::{Site, Swept};
use super::{ours, room};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Longest time in which lines open: somebody who comes or goes may stand in the way of each for a second.
pub(super) const LIMIT: Duration = Duration::from_secs(10);

/// Longest time a sweep may take.
const SWEEP: Duration = Duration::from_secs(2);
/// Memory of the thread's stack \[bytes\]: a server that keeps its memory in RAM pays for all of it, at each sweep.
const STACK: usize = 512 << 10;

/// Does something at a place, once our files there are closed to other users and `need` bytes are free.
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
    // what came while it was opened
    ours::check(site)?;
    ours::reserve(site)?;
    Ok(made)
}

impl Site {
    /// Removes what killed processes left behind, so that their places are free. A fraction of a millisecond when there
    /// is nothing to do, some milliseconds when there is: for a thread that has time, once to ten times a second.
    pub fn sweep(&self) -> Swept {
        // what cannot be swept now may be at the next turn, and whoever opens a line says why not
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
            // one who waits no longer does not want it
            let _ = tell.send(act(&here));
        })
        .map_err(|e| HostError::system("no thread", e))?;
    reported.recv_timeout(limit).unwrap_or_else(|e| {
        let root = site.root().display();
        let what = match e {
            RecvTimeoutError::Timeout => format!("shared memory at `{root}` does not open within {limit:?}"),
            RecvTimeoutError::Disconnected => format!("iceoryx2 gave up on the shared memory at `{root}`"),
        };
        let fix = "see `ca shm list`; `ca shm clean` removes what ended processes have left, another CA_SHM_ROOT is another place";
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
        // an empty counter, as whoever is faster than our look could leave it
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
        // and with our look before it, the place heals
        within(&site, 0, LIMIT, |site| site.node("three")).expect("it opens");
        crate::host::stale_shm::clean(&site);
    }
}
