//! Measures the time of a call on this machine.
//!
//! It uses the processor time of this thread: on a busy machine, wall time was eight times as long. The fastest of
//! several batches counts, since other programs did not use its caches. Systems without such a clock use wall time.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Steps of a clock in the shortest time that it measures well.
const FEW: u32 = 20;

/// Clock by which run times are measured.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Returns the time since a fixed moment.
    pub now: fn() -> Duration,
    /// Step by which it advances. Runs that last only a few steps are timed together.
    pub step: Duration,
}

impl Clock {
    /// Wall time, in WebAssembly not available.
    pub const WALL: Clock = Clock { now: wall, step: Duration::ZERO };

    /// Time since `begin` \[ns\].
    pub(crate) fn since(self, begin: Duration) -> f64 {
        (self.now)().saturating_sub(begin).as_nanos() as f64
    }

    /// True for the clock of a browser.
    pub(crate) fn is_coarse(self) -> bool {
        !self.step.is_zero()
    }

    /// Shortest time that it measures well \[ns\].
    pub(crate) fn least(self) -> f64 {
        (FEW * self.step).as_nanos() as f64
    }
}

fn wall() -> Duration {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}

/// Extent of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Least duration of a batch of calls.
    pub batch: Duration,
    /// Number of batches; the fastest counts.
    pub batches: u32,
}

impl Default for Timing {
    fn default() -> Timing {
        Timing { batch: Duration::from_micros(200), batches: 9 }
    }
}

impl Timing {
    /// Returns the fastest time of one call \[ns\]; `renew` runs before each batch and is not counted.
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

/// Wall time.
#[cfg(not(unix))]
pub fn processor() -> Duration {
    wall()
}

/// Describes the processor of this machine.
pub fn machine() -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = cpuinfo.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split_once(": "));
    let virtual_one = if cpuinfo.contains("hypervisor") { " (virtual machine)" } else { "" };
    format!("{}{virtual_one}", name.map_or("unknown processor", |(_, name)| name.trim()))
}

/// Returns the time in which this machine reads `bytes` bytes and writes two fifths of them back \[ns\], with its
/// widest vectors and hardly any computation. A tick that takes about as long for as many bytes is limited by memory.
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

/// A function, so that its slices are known not to overlap, as vectors require.
#[inline(always)]
fn stream(x: &mut [f64], d: &mut [f64], a: &[f64], b: &[f64], c: &[f64]) {
    for ((((x, d), a), b), c) in x.iter_mut().zip(d).zip(a).zip(b).zip(c) {
        *d = 0.25 * (*d + a + b + c);
        *x = 0.5 * (*x + *d);
    }
}

/// Returns the data caches of the first processor, as far as known: name and bytes, smallest first.
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
