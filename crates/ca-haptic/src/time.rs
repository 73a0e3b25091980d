//! Clock with which forces and frames are stamped.

#[cfg(feature = "system")]
pub use crate::rt::now_ns;

#[cfg(not(feature = "system"))]
pub use caller::{now_ns, set_now_ns};

#[cfg(not(feature = "system"))]
mod caller {
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    static NOW: AtomicU64 = AtomicU64::new(0);

    /// Returns the time that the caller set last \[ns\].
    pub fn now_ns() -> u64 {
        NOW.load(Relaxed)
    }

    /// Sets the time \[ns\]; an earlier one than the last is ignored.
    pub fn set_now_ns(ns: u64) {
        NOW.fetch_max(ns, Relaxed);
    }
}
