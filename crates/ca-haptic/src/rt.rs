//! Requests real-time scheduling from the operating system, reads back what was granted, and reports it (H17).
//!
//! It calls `libc` directly: priority, memory lock, affinity and an absolute sleep are four calls, and no maintained
//! crate covers all of them. Nothing here fails: [`Granted`] lists what was refused, and the caller goes on without it.
//!
//! A wait sleeps until shortly before its time and spins for the rest. A real-time thread that never slept would block
//! its core, and the kernel would stop it for 50 ms every second. A loop whose waits are too short to sleep in, or that
//! is always late, therefore still sleeps a sixteenth of the time, at least a quarter of a ms at once ([`Waits`]).
//!
//! Real time is for Linux only; elsewhere nothing is granted and waits use `std`.

#![allow(unsafe_code)]

use std::fmt;

/// Real-time properties requested for a thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RtRequest {
    /// Priority of `SCHED_FIFO`, 1 to 99.
    pub priority: Option<u8>,
    /// Core to which the thread is pinned.
    pub cpu: Option<usize>,
    /// Locks all memory of the process in RAM.
    pub lock: bool,
    /// Nice value among threads without real time, −20 to 19; a negative one gets a larger share of the cores.
    pub nice: Option<i8>,
}

/// Real-time properties granted, as the system reports them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Granted {
    /// Scheduling policy: `FIFO`, `RR`, `OTHER` …
    pub policy: String,
    /// Priority within the policy.
    pub priority: i32,
    /// Nice value.
    pub nice: i32,
    /// Cores on which the thread may run.
    pub cpus: Vec<usize>,
    /// Memory locked in RAM \[kB\].
    pub locked_kb: u64,
    /// Refused requests, in words.
    pub refused: Vec<String>,
}

impl fmt::Display for Granted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cpus: Vec<String> = self.cpus.iter().map(usize::to_string).collect();
        write!(f, "policy {} {}", self.policy, self.priority)?;
        if self.nice != 0 {
            write!(f, " nice {}", self.nice)?;
        }
        let cpus = if cpus.is_empty() { "?".into() } else { cpus.join(" ") };
        write!(f, ", cores {cpus}, {} MB locked", self.locked_kb / 1024)?;
        for r in &self.refused {
            write!(f, "; not granted: {r}")?;
        }
        Ok(())
    }
}

/// Bounds of the time before its end at which a wait stops sleeping and spins \[ns\]. The upper one exceeds most late
/// wake-ups; the lower one suits a machine that wakes on time.
const SPIN: u64 = 80_000;
const LEAST_SPIN: u64 = 5_000;
/// Waits after which a late wake-up is forgotten: a second at 3000 waits a second. Waits without a sleep count too, so
/// that a loop of short waits tries again whether it can sleep.
const FORGET: u64 = 3000;

/// A thread sleeps one part in this many of its waking time; the kernel withholds a twentieth from real-time threads.
const REST: u64 = 16;
/// Least owed sleep that is taken \[ns\], and the most that can be owed.
const OWED: u64 = 250_000;
const MOST_OWED: u64 = 10_000_000;

/// Waits of one thread, each a sleep followed by a spin.
///
/// The spin is as long as recent wake-ups on this machine were late: a few per cent of the time on a quiet machine, a
/// quarter on a busy one. No thread is awake for more than sixteen parts in seventeen, however short its waits. Where
/// they leave no time for sleep, one of them ends late.
#[derive(Clone, Debug)]
pub struct Waits {
    /// Time before the end of a wait at which it spins \[ns\].
    spin: u64,
    /// Start of the waking time not yet accounted for \[ns\]; 0 before the first wait.
    woke: u64,
    /// Sleep owed \[ns\].
    owed: u64,
}

impl Default for Waits {
    fn default() -> Waits {
        Waits { spin: SPIN, woke: 0, owed: 0 }
    }
}

impl Waits {
    /// Waits until `at` \[ns of [`now_ns`]\] and returns the time at the end.
    pub fn until(&mut self, at: u64) -> u64 {
        let now = now_ns();
        if let Some(wake) = self.plan(now, at) {
            system::sleep_until(wake);
            self.slept(now, wake, now_ns());
        }
        loop {
            let now = now_ns();
            if now >= at {
                return now;
            }
            core::hint::spin_loop();
        }
    }

    /// Sleeps until `at` \[ns\] without a spin, where microseconds do not matter.
    pub fn sleep(&mut self, at: u64) {
        let now = now_ns();
        self.awake(now);
        let wake = at.max(now + self.due());
        if wake > now {
            system::sleep_until(wake);
            self.rested(now, now_ns());
        }
    }

    /// Sleeps only if sleep is owed, for a loop that does not wait.
    pub fn pass(&mut self) {
        self.sleep(0);
    }

    /// Returns the time until which to sleep \[ns\] in a wait from `now`; `None` where there is no time for sleep.
    fn plan(&mut self, now: u64, at: u64) -> Option<u64> {
        self.awake(now);
        self.spin = (self.spin - self.spin / FORGET).max(LEAST_SPIN);
        let wake = at.saturating_sub(self.spin).max(now + self.due());
        (wake > now).then_some(wake)
    }

    /// Records a sleep from `now`, planned until `wake` and ended at `after` \[ns\].
    fn slept(&mut self, now: u64, wake: u64, after: u64) {
        let late = after.saturating_sub(wake);
        // spinning does not help a thread that wakes later than the longest spin
        let wanted = if late < SPIN { late + late / 4 } else { 0 };
        self.spin = self.spin.max(wanted).clamp(LEAST_SPIN, SPIN);
        self.rested(now, after);
    }

    /// Records that the thread was awake until `now` \[ns\].
    fn awake(&mut self, now: u64) {
        let awake = if self.woke == 0 { 0 } else { now.saturating_sub(self.woke) };
        self.owed = (self.owed + awake / REST).min(MOST_OWED);
        self.woke = now;
    }

    fn rested(&mut self, from: u64, to: u64) {
        self.owed = self.owed.saturating_sub(to.saturating_sub(from));
        self.woke = to;
    }

    /// Returns the sleep to take now \[ns\].
    fn due(&self) -> u64 {
        if self.owed >= OWED { self.owed } else { 0 }
    }
}

/// Waits once until `at` \[ns of [`now_ns`]\] and returns the time at the end.
pub fn wait_until(at: u64) -> u64 {
    Waits::default().until(at)
}

pub use system::{ask, fine_sleep, now_ns};

#[cfg(target_os = "linux")]
mod system {
    use super::{Granted, RtRequest};

    /// Returns `CLOCK_MONOTONIC` \[ns\] without a system call.
    pub fn now_ns() -> u64 {
        let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: `t` is a valid place for the result.
        unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut t) };
        t.tv_sec as u64 * 1_000_000_000 + t.tv_nsec as u64
    }

    pub(super) fn sleep_until(at: u64) {
        let t = libc::timespec { tv_sec: (at / 1_000_000_000) as _, tv_nsec: (at % 1_000_000_000) as _ };
        // SAFETY: `t` is valid; a null remainder is allowed with an absolute time. A signal ends the sleep early, and
        // the caller's spin makes up for it.
        unsafe {
            libc::clock_nanosleep(libc::CLOCK_MONOTONIC, libc::TIMER_ABSTIME, &raw const t, std::ptr::null_mut())
        };
    }

    /// Sets the timer slack of this thread to 1 ns; by default the kernel delays wake-ups by up to 50 µs.
    pub fn fine_sleep() {
        // SAFETY: takes no pointers.
        unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, 1_u64, 0, 0, 0) };
    }

    fn error() -> String {
        std::io::Error::last_os_error().to_string()
    }

    /// Requests these properties for the calling thread, and reads back those in force.
    pub fn ask(request: RtRequest) -> Granted {
        let mut refused = Vec::new();
        fine_sleep();
        if request.lock {
            // locks future pages only where the limit cannot make allocations fail
            let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
            // SAFETY: `limit` is a valid place for the result; the others take no pointers.
            let failed = unsafe {
                libc::getrlimit(libc::RLIMIT_MEMLOCK, &raw mut limit);
                let free = limit.rlim_cur == libc::RLIM_INFINITY || libc::geteuid() == 0;
                libc::mlockall(if free { libc::MCL_CURRENT | libc::MCL_FUTURE } else { libc::MCL_CURRENT }) != 0
            };
            if failed {
                refused.push(format!("memory lock ({}): raise `memlock` in limits.conf", error()));
            }
        }
        if let Some(cpu) = request.cpu {
            // SAFETY: an empty set is all zeros; `CPU_SET` writes within it since `cpu` is checked.
            let failed = unsafe {
                let mut set: libc::cpu_set_t = std::mem::zeroed();
                if cpu < libc::CPU_SETSIZE as usize {
                    libc::CPU_SET(cpu, &mut set);
                }
                libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const set) != 0
            };
            if failed {
                refused.push(format!("core {cpu} ({})", error()));
            }
        }
        if let Some(priority) = request.priority {
            let p = libc::sched_param { sched_priority: i32::from(priority) };
            // SAFETY: `p` is valid.
            let failed = unsafe { libc::pthread_setschedparam(libc::pthread_self(), libc::SCHED_FIFO, &raw const p) };
            if failed != 0 {
                let why = std::io::Error::from_raw_os_error(failed);
                refused.push(format!("priority {priority} ({why}): raise `rtprio` in limits.conf"));
            }
        }
        if let Some(nice) = request.nice {
            // SAFETY: takes no pointers; on Linux 0 is the calling thread, not the process.
            if unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, i32::from(nice)) } != 0 {
                refused.push(format!("nice {nice} ({}): lower `nice` in limits.conf", error()));
            }
        }
        Granted { refused, ..read_back() }
    }

    fn read_back() -> Granted {
        let (mut policy, mut p) = (0, libc::sched_param { sched_priority: 0 });
        // SAFETY: both are valid places for the results.
        unsafe { libc::pthread_getschedparam(libc::pthread_self(), &raw mut policy, &raw mut p) };
        // SAFETY: an empty set is all zeros, and a valid place for the result; `CPU_ISSET` reads within it.
        let cpus = unsafe {
            let mut set: libc::cpu_set_t = std::mem::zeroed();
            libc::sched_getaffinity(0, size_of::<libc::cpu_set_t>(), &raw mut set);
            (0..libc::CPU_SETSIZE as usize).filter(|c| libc::CPU_ISSET(*c, &set)).collect()
        };
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let locked = status.lines().find_map(|l| l.strip_prefix("VmLck:"));
        Granted {
            policy: match policy {
                libc::SCHED_FIFO => "FIFO".into(),
                libc::SCHED_RR => "RR".into(),
                libc::SCHED_OTHER => "OTHER".into(),
                n => format!("{n}"),
            },
            priority: p.sched_priority,
            // SAFETY: takes no pointers. −1 is both a value and an error; this call has no reason to fail.
            nice: unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) },
            cpus,
            locked_kb: locked.and_then(|l| l.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0),
            refused: Vec::new(),
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use super::{Granted, RtRequest};
    use std::sync::OnceLock;
    use std::time::{Duration, Instant};

    static START: OnceLock<Instant> = OnceLock::new();

    /// Returns the time since the first call \[ns\].
    pub fn now_ns() -> u64 {
        START.get_or_init(Instant::now).elapsed().as_nanos() as u64
    }

    pub(super) fn sleep_until(at: u64) {
        std::thread::sleep(Duration::from_nanos(at.saturating_sub(now_ns())));
    }

    /// Does nothing.
    pub fn fine_sleep() {}

    /// Grants nothing.
    pub fn ask(request: RtRequest) -> Granted {
        let asked = request.lock || request.cpu.is_some() || request.priority.is_some() || request.nice.is_some();
        let refused = if asked { vec!["real-time scheduling is supported on Linux only".into()] } else { Vec::new() };
        Granted { policy: "OTHER".into(), refused, ..Granted::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_is_never_early_and_the_clock_never_runs_back() {
        let (mut last, mut waits) = (now_ns(), Waits::default());
        for n in 0..200_u64 {
            // short waits only spin, and one in the past returns at once
            let at = last + 1000 * (n % 200);
            let now = waits.until(at);
            assert!(now >= at && now >= last);
            assert!((LEAST_SPIN..=SPIN).contains(&waits.spin));
            last = now;
        }
        assert!(wait_until(last + 100_000) >= last + 100_000);
        assert!(waits.until(0) > last);
    }

    /// On a simulated clock, loops of any period and load sleep for a twentieth of any half second, whether the machine
    /// wakes them late or not. A loop with time to sleep is not late because of it.
    #[test]
    fn no_loop_is_awake_all_the_time() {
        for period in [5_000, 20_833, 80_000, 333_333, 5_000_000_u64] {
            for load in [0, 50, 90, 96, 100, 150, 1000_u64] {
                for wakes in [0, 3_000, 60_000, 2_000_000] {
                    let (mut waits, mut now) = (Waits::default(), 1_000_000_000_u64);
                    let (mut due, mut late, mut n) = (now, 0, 0_u64);
                    let (mut slept, mut from) = (0, now);
                    while now < 2_000_000_000 {
                        n += 1;
                        due += period;
                        // skips missed periods, as the clock of the engine does
                        if now > due {
                            due += (now - due) / period * period;
                        }
                        if let Some(wake) = waits.plan(now, due) {
                            let after = wake + wakes;
                            waits.slept(now, wake, after);
                            slept += after - now;
                            now = after;
                        }
                        now = now.max(due);
                        late += u64::from(now > due + wakes);
                        now += period * load / 100;
                        if now - from >= 500_000_000 {
                            assert!(
                                slept * 20 >= now - from,
                                "period {period} ns, load {load} %, woken {wakes} ns late: slept {slept} of {} ns",
                                now - from
                            );
                            (slept, from) = (0, now);
                        }
                    }
                    if period >= 333_333 && load <= 50 {
                        assert_eq!(late, 0, "period {period} ns, load {load} %: of {n}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_granted_is_read_back() {
        std::thread::spawn(|| {
            let cpu = ask(RtRequest::default()).cpus.first().copied();
            let g = ask(RtRequest { priority: Some(1), cpu, ..RtRequest::default() });
            assert_eq!(g.policy == "FIFO", g.refused.iter().all(|r| !r.starts_with("priority")), "{g}");
            assert_eq!(g.cpus.len(), 1, "{g}");
            // any process may raise its nice value
            let g = ask(RtRequest { nice: Some(7), ..RtRequest::default() });
            assert!(g.nice == 7 && g.refused.is_empty() && g.to_string().contains("nice 7"), "{g}");
            let none = ask(RtRequest { cpu: Some(100_000), ..RtRequest::default() });
            assert_eq!(none.refused.len(), 1, "{none}");
            assert!(none.to_string().contains("not granted: core 100000"), "{none}");
        })
        .join()
        .expect("no panic");
    }
}
