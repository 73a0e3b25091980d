//! What very many modules cost to load: processor time and memory a module, read and compiled. The requirement: 10^5 modules
//! of one line in 20 ms and in 100 bytes each, 3·10^5 written one by one in a second and in 200 MB.
//!
//! Decides to count bytes as they are asked of the allocator: what the system lends changes from run to run.
#![allow(missing_docs)]
#![allow(unsafe_code)]

use ca_benches::{by_hand, catalog, string};
use ca_compile::{Options, compile};
use ca_lab::timing::processor;
use ca_model::read::read;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static CALLS: AtomicUsize = AtomicUsize::new(0);

struct Counting;

fn took(bytes: usize) {
    CALLS.fetch_add(1, Ordering::Relaxed);
    let now = LIVE.fetch_add(bytes, Ordering::Relaxed) + bytes;
    PEAK.fetch_max(now, Ordering::Relaxed);
}

// SAFETY: every call is passed on to the system's allocator as it came; counting touches numbers only.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        took(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`, which is that of `System`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: `ptr` came from `System` through `alloc` above, with this layout.
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What a stage took: time, calls of the allocator, bytes at its peak and bytes kept, beside those there were.
struct Stage {
    ms: f64,
    calls: usize,
    peak: usize,
    kept: usize,
}

fn stage<T>(f: impl FnOnce() -> T) -> (T, Stage) {
    let (live, calls, begin) = (LIVE.load(Ordering::Relaxed), CALLS.load(Ordering::Relaxed), processor());
    PEAK.store(live, Ordering::Relaxed);
    let done = f();
    let ms = (processor() - begin).as_secs_f64() * 1e3;
    let more = |now: &AtomicUsize| now.load(Ordering::Relaxed).saturating_sub(live);
    (done, Stage { ms, calls: CALLS.load(Ordering::Relaxed) - calls, peak: more(&PEAK), kept: more(&LIVE) })
}

fn main() {
    // `cargo test --benches` asks whether it runs at all
    let long = std::env::args().any(|a| a == "--bench");
    let (rounds, part) = if long { (5, 1) } else { (1, 1000) };
    let only: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let catalog = catalog();
    println!(
        "{:<30} {:<8} {:>9} {:>10} {:>8} {:>8} {:>8}",
        "model", "stage", "ms", "ns/module", "calls", "peak B", "kept B"
    );
    for (name, text) in [("one line", string(50_000 / part)), ("one by one", by_hand(150_000 / part))] {
        if !only.is_empty() && !only.iter().any(|o| o == name) {
            continue;
        }
        let mut best: Option<([Stage; 2], usize)> = None;
        for _ in 0..rounds {
            let ((model, findings), reading) = stage(|| read(&text, "bench.ca.toml", &catalog));
            assert!(!findings.has_errors(), "{findings}");
            let (scene, compiling) =
                stage(|| compile(&model, &catalog, &Options::default()).expect("the bench compiles").scene);
            let modules = scene.mats() + scene.lias();
            if best.as_ref().is_none_or(|(b, _)| b[0].ms + b[1].ms > reading.ms + compiling.ms) {
                best = Some(([reading, compiling], modules));
            }
        }
        let Some((stages, modules)) = best else { continue };
        for (what, s) in ["read", "compile"].into_iter().zip(stages) {
            let per = |v: usize| v as f64 / modules as f64;
            println!(
                "{:<30} {what:<8} {:>9.2} {:>10.0} {:>8.2} {:>8.0} {:>8.0}",
                format!("{modules} modules, {name}"),
                s.ms,
                s.ms * 1e6 / modules as f64,
                per(s.calls),
                per(s.peak),
                per(s.kept)
            );
        }
    }
}
