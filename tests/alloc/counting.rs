//! Counting: an allocator that counts, for the tests of what must not allocate and for the bench of large models.
//!
//! Decides for counts of the thread that asks: tests run beside each other, and what one allocates is none of another's.
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
    // a thread that is ending has no counter any more
    let _ = CALLS.try_with(|c| c.set(c.get() + 1));
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + bytes);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(live.get())));
    });
}

// SAFETY: every call is passed on to the system's allocator as it came; counting touches a `Cell` that is initialised
// in a constant and has no destructor, so it allocates nothing itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller keeps the contract of `alloc`, which is that of `System`.
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

/// What a call took of the allocator, on this thread.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "the tests ask for less than the bench")]
pub struct Taken {
    /// how often it was called, freeing included
    pub calls: u64,
    /// the most bytes at one time
    pub peak: u64,
    /// bytes that are still there
    pub kept: u64,
}

/// What `f` gives, and what it took.
pub fn taken<T>(f: impl FnOnce() -> T) -> (T, Taken) {
    let (calls, live) = (CALLS.with(Cell::get), LIVE.with(Cell::get));
    PEAK.with(|p| p.set(live));
    let done = f();
    let more = |now: i64| (now - live).max(0) as u64;
    let taken = Taken {
        calls: CALLS.with(Cell::get) - calls,
        peak: more(PEAK.with(Cell::get)),
        kept: more(LIVE.with(Cell::get)),
    };
    (done, taken)
}

/// How often the allocator was called by `f`, freeing included.
#[allow(dead_code, reason = "the bench asks for all of it")]
pub fn calls(f: impl FnOnce()) -> u64 {
    taken(f).1.calls
}

/// The most that `f` has at one time \[bytes\].
#[allow(dead_code, reason = "the bench asks for all of it")]
pub fn most(f: impl FnOnce()) -> u64 {
    taken(f).1.peak
}
