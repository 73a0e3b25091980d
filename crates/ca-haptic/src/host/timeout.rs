//! Sets a time limit on what iceoryx2 opens, lists or removes.
//!
//! iceoryx2 can wait without a limit: version 0.10 waits forever for a file of size zero. So each such step runs on a
//! separate thread, and the caller waits for that thread up to the limit. The ports are therefore of the kind that may
//! change threads; their locks are never contended. A thread that hangs is left behind, asleep most of the time.

use super::error::{HostError, HostErrorKind};
use super::shm::files;
use super::site::{Site, SweepResult};
use super::{file_ownership, free_memory};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Time limit for opening services. Each of them may wait a second for a process that is just starting or ending.
pub(super) const LIMIT: Duration = Duration::from_secs(10);

const SWEEP: Duration = Duration::from_secs(2);
/// Stack of the thread \[bytes\]. It is small, because a server with locked memory allocates all of it at each sweep.
const STACK: usize = 512 << 10;

/// Runs `open` on a site, after checking its files ([`file_ownership`]) and that `need` bytes are free.
pub(super) fn with_timeout<T: Send + 'static>(
    site: &Site,
    need: u64,
    limit: Duration,
    open: impl FnOnce(&Site) -> Result<T, HostError> + Send + 'static,
) -> Result<T, HostError> {
    file_ownership::check(site)?;
    free_memory::check(need)?;
    let foreign = files::foreign(site.prefix());
    let opened = on_thread(site, limit, open).map_err(|e| file_ownership::name_blocking_file(site, e))?;
    file_ownership::check_mapped(site, &foreign)?;
    // files opened by `open`
    file_ownership::check(site)?;
    file_ownership::allocate(site)?;
    Ok(opened)
}

impl Site {
    /// Removes what killed processes left behind, so that their services are free again. Call it once to ten times a
    /// second, on a thread that is not real-time: it takes some milliseconds, or a fraction of one if there is nothing
    /// to remove.
    pub fn remove_dead(&self) -> SweepResult {
        // the next sweep tries again, and opening a service reports the reason
        with_timeout(self, 0, SWEEP, |site| Ok(site.swept())).unwrap_or_default()
    }
}

fn on_thread<T: Send + 'static>(
    site: &Site,
    limit: Duration,
    open: impl FnOnce(&Site) -> Result<T, HostError> + Send + 'static,
) -> Result<T, HostError> {
    let (send, reported) = channel();
    let clone = site.clone();
    std::thread::Builder::new()
        .name("ca opens".into())
        .stack_size(STACK)
        .spawn(move || {
            // after the limit, the receiver no longer exists
            let _ = send.send(open(&clone));
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
        on_thread(&site, LIMIT, |site| site.node("one")).expect("it opens");
        // an empty counter, as another process could leave it after `file_ownership::check`
        let name = std::fs::read_dir("/dev/shm")
            .expect("shared memory")
            .flatten()
            .find(|e| e.file_name().to_string_lossy().starts_with(site.prefix()))
            .expect("the counter of iceoryx2")
            .file_name();
        let path = Path::new("/dev/shm").join(name);
        std::fs::write(&path, []).expect("it is cut");
        let e = on_thread(&site, Duration::from_millis(300), |site| site.node("two")).expect_err("it hangs");
        assert!(e.kind == HostErrorKind::System && e.what.contains("300ms"), "{e}");
        // `file_ownership::check` repairs it
        with_timeout(&site, 0, LIMIT, |site| site.node("three")).expect("it opens");
        crate::host::stale_shm::clean(&site);
    }
}
