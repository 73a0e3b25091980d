//! Counting allocator for the allocation tests and for the bench of large models.
//!
//! It counts per thread, because tests run in parallel and must not count each other's allocations.
#![allow(unsafe_code, reason = "an allocator is one by an unsafe trait")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
    static LIVE: Cell<i64> = const { Cell::new(0) };
    static PEAK: Cell<i64> = const { Cell::new(0) };
}

struct Counting;

fn count(bytes: i64) {
    // a thread that is ending no longer has its counter
    let _ = CALLS.try_with(|c| c.set(c.get() + 1));
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + bytes);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(live.get())));
    });
}

// SAFETY: every call is passed unchanged to the system's allocator. Counting touches only `Cell`s, which have a
// constant initialiser and no destructor, so counting itself allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller upholds the contract of `alloc`, which `System` shares.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: `ptr` came from `System` through `alloc` above, with this layout.
        unsafe { System.dealloc(ptr, layout) }
    }
    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as i64 - layout.size() as i64);
        // SAFETY: `ptr` came from `System` through `alloc` above, with this layout.
        unsafe { System.realloc(ptr, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocator use of one call, on this thread.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "the tests ask for less than the bench")]
pub struct AllocCounts {
    /// Number of allocator calls, freeing included.
    pub calls: u64,
    /// Peak of allocated bytes.
    pub peak: u64,
    /// Bytes still allocated at the end.
    pub kept: u64,
}

/// Runs `f` and returns its result and its allocator use.
pub fn taken<T>(f: impl FnOnce() -> T) -> (T, AllocCounts) {
    let (calls, live) = (CALLS.with(Cell::get), LIVE.with(Cell::get));
    PEAK.with(|p| p.set(live));
    let done = f();
    let more = |now: i64| (now - live).max(0) as u64;
    let taken = AllocCounts {
        calls: CALLS.with(Cell::get) - calls,
        peak: more(PEAK.with(Cell::get)),
        kept: more(LIVE.with(Cell::get)),
    };
    (done, taken)
}

/// Number of allocator calls in `f`, freeing included.
#[allow(dead_code, reason = "the bench asks for all of it")]
pub fn calls(f: impl FnOnce()) -> u64 {
    taken(f).1.calls
}

/// Peak of allocated bytes in `f`.
#[allow(dead_code, reason = "the bench asks for all of it")]
pub fn most(f: impl FnOnce()) -> u64 {
    taken(f).1.peak
}
