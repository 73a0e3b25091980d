//! Checks that `/dev/shm` has enough free memory, before files are made there.
//!
//! When `/dev/shm` is full (64 kB in some containers), the system still makes files of any size, and kills the process
//! that writes to them with SIGBUS.

use super::error::{HostError, HostErrorKind};
use super::shm::names::SHM;
use std::fs::File;
use std::io;

/// Largest memory of one side of a device \[bytes\]: queues of frames, its description, and connections to its readers.
pub(super) const DEVICE: u64 = 192 << 10;
/// Largest memory of a process that lists devices \[bytes\].
pub(super) const LISTING: u64 = 64 << 10;

/// Returns an error if `/dev/shm` has fewer than `need` bytes free.
pub(super) fn check(need: u64) -> Result<(), HostError> {
    // without `/dev/shm`, as on other systems, there is nothing to check
    let Some(free) = free() else { return Ok(()) };
    if free >= need {
        return Ok(());
    }
    let what = format!("`{SHM}` has {} kB free, but {} kB are needed", free >> 10, need.div_ceil(1 << 10));
    let fix = "free memory with `ca shm clean`, or enlarge it with `mount -o remount,size=64M /dev/shm` \
               (in a container, `--shm-size 64m`)";
    Err(HostError::new(HostErrorKind::System, what, fix))
}

fn free() -> Option<u64> {
    let about = rustix::fs::statvfs(SHM).ok()?;
    Some(about.f_bavail.saturating_mul(about.f_frsize))
}

#[cfg(target_os = "linux")]
pub(super) fn allocate(file: &File, bytes: u64) -> io::Result<()> {
    Ok(rustix::fs::fallocate(file, rustix::fs::FallocateFlags::empty(), 0, bytes)?)
}

#[cfg(not(target_os = "linux"))]
pub(super) fn allocate(_: &File, _: u64) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::About;
    use crate::host::{DeviceClient, Gateway, Site, stale_shm};
    use std::time::Duration;

    /// Returns the memory of all files of a site \[bytes\], in whole pages.
    fn used(site: &Site) -> u64 {
        let files = stale_shm::list(site).into_iter().flat_map(|g| g.files);
        files.filter(|f| f.0.starts_with(SHM)).map(|f| f.1.next_multiple_of(4096)).sum()
    }

    #[test]
    fn what_is_asked_for_is_enough() {
        let dir = tempfile::Builder::new().prefix("car").tempdir_in("/tmp").expect("a folder");
        let site = Site::at(dir.path()).expect("a place");
        let gateway = Gateway::open(&site, &["a", "b", "c"]).expect("a server");
        let server = used(&site);
        assert!(server <= 3 * DEVICE, "{server}");
        let mut device = DeviceClient::open(&site, About::new("a", 1000, 12)).expect("a device");
        device.send(&mut crate::frame::DeviceFrame::new("a", 12)).expect("sent");
        let both = used(&site);
        assert!(both - server <= DEVICE, "{both} - {server}");
        // connections to other readers
        let readers: Vec<_> =
            (0..3).map(|_| crate::host::gateway::list_devices(&site, Duration::from_millis(1))).collect();
        assert!(readers.iter().all(Result::is_ok) && used(&site) - both <= LISTING);
        drop((gateway, device));
        stale_shm::clean(&site);
    }

    #[test]
    fn more_than_there_is_is_an_error() {
        check(0).expect("nothing is always there");
        let e = check(u64::MAX).expect_err("there is an end");
        assert!(e.what.contains(SHM) && e.fix.contains("shm-size"), "{e}");
    }
}
