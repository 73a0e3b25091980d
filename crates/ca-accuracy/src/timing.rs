//! Timing: what one call costs on this machine.
//!
//! Decides to count the processor time of this thread and not the time on the wall: on a machine that does other things too
//! the wall counts those, eight times what a tick took where it was tried. The fastest of several batches counts, which is
//! the one whose caches nobody else used. Where the system has no clock for a thread it is the wall after all.

use std::time::Duration;

/// How long is measured.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// a batch of calls lasts at least this long
    pub batch: Duration,
    /// so many batches, of which the fastest counts
    pub batches: u32,
}

impl Default for Timing {
    fn default() -> Timing {
        Timing { batch: Duration::from_micros(200), batches: 9 }
    }
}

impl Timing {
    /// The fastest time of one call \[ns\]; `renew` stands before each batch and is not counted.
    pub fn fastest<S>(self, state: &mut S, renew: impl Fn(&mut S), mut call: impl FnMut(&mut S)) -> f64 {
        let mut batch = |n: u32| {
            renew(state);
            let begin = processor();
            for _ in 0..n {
                call(std::hint::black_box(state));
            }
            processor().saturating_sub(begin)
        };
        let mut n = 1;
        while batch(n) < self.batch && n < 1 << 20 {
            n *= 2;
        }
        let best = (0..self.batches).map(|_| batch(n)).min().unwrap_or_default();
        best.as_secs_f64() * 1e9 / f64::from(n)
    }
}

/// Processor time of this thread.
#[cfg(unix)]
pub fn processor() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or_default())
}

/// Time on the wall.
#[cfg(not(unix))]
pub fn processor() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}

/// Whose times these are.
pub fn machine() -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = cpuinfo.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split_once(": "));
    let virtual_one = if cpuinfo.contains("hypervisor") { ", a virtual one" } else { "" };
    format!("{}{virtual_one}", name.map_or("a processor that does not say its name", |(_, name)| name.trim()))
}

/// The time in which this machine reads so many bytes and writes two fifths of them back \[ns\], with the widest vectors it
/// has and next to nothing to compute: a tick that takes about as long for as many waits for memory, whatever it computes.
pub fn streaming(bytes: usize) -> f64 {
    let row = || vec![0.5; bytes.div_ceil(40)];
    let read = [row(), row(), row()];
    let widest = pulp::Arch::new();
    Timing::default().fastest(
        &mut [row(), row()],
        |_| (),
        |[x, d]| {
            let [a, b, c] = std::hint::black_box(&read);
            widest.dispatch(
                #[inline(always)]
                || stream(x, d, a, b, c),
            );
        },
    )
}

/// Slices of its own, or nobody could know that one is not part of another, and there would be no vectors.
#[inline(always)]
fn stream(x: &mut [f64], d: &mut [f64], a: &[f64], b: &[f64], c: &[f64]) {
    for ((((x, d), a), b), c) in x.iter_mut().zip(d).zip(a).zip(b).zip(c) {
        *d = 0.25 * (*d + a + b + c);
        *x = 0.5 * (*x + *d);
    }
}

/// The caches of data of the first processor, as far as the system says: name and bytes, smallest first.
pub fn caches() -> Vec<(String, u64)> {
    let mut all = Vec::new();
    for index in 0..8 {
        let read = |what: &str| {
            let path = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{what}");
            std::fs::read_to_string(path).ok().map(|t| t.trim().to_owned())
        };
        let (Some(level), Some(size), Some(kind)) = (read("level"), read("size"), read("type")) else { continue };
        let kilobytes = size.strip_suffix('K').and_then(|k| k.parse::<u64>().ok());
        if let (Some(k), true) = (kilobytes, kind != "Instruction") {
            all.push((format!("L{level}"), 1024 * k));
        }
    }
    all.sort_by_key(|c| c.1);
    all
}
