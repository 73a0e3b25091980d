//! Real time as the operating system grants it: asked for, read back, reported (H17).
//!
//! Decides on `libc` alone: priority, memory lock, affinity and an absolute sleep are four calls, and no crate that is
//! kept covers all of them. Nothing here fails: what was not granted is in [`Granted`], and the caller goes on without.
//! A wait sleeps until shortly before the time and spins the rest; a thread that spun for ever would be stopped for
//! 50 ms every second by the kernel's own guard. Linux; elsewhere nothing is granted and waits are those of `std`.

#![allow(unsafe_code)]

use std::fmt;

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wish {
    /// priority of `SCHED_FIFO`, 1 to 99
    pub priority: Option<u8>,
    /// the core to stay on
    pub cpu: Option<usize>,
    /// keep all memory of the process in RAM
    pub lock: bool,
}

/// What was granted, as the system itself reports it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Granted {
    /// `FIFO`, `RR`, `OTHER` …
    pub policy: String,
    /// priority of the policy
    pub priority: i32,
    /// cores the thread may run on
    pub cpus: Vec<usize>,
    /// memory that is kept in RAM \[kB\]
    pub locked_kb: u64,
    /// what was asked and not granted, in words
    pub refused: Vec<String>,
}

impl fmt::Display for Granted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cpus: Vec<String> = self.cpus.iter().map(usize::to_string).collect();
        write!(
            f,
            "policy {} {}, cores {}, {} MB locked",
            self.policy,
            self.priority,
            if cpus.is_empty() { "?".into() } else { cpus.join(" ") },
            self.locked_kb / 1024
        )?;
        for r in &self.refused {
            write!(f, "; not granted: {r}")?;
        }
        Ok(())
    }
}

/// How long before its time a wait stops sleeping and spins \[ns\], at most: more than most wake-ups are late by. At
/// least, with a machine that wakes as it should.
const SPIN: u64 = 80_000;
const LEAST_SPIN: u64 = 5_000;
/// Waits over which a late wake-up is forgotten: it was a second ago at 3000 a second.
const FORGET: u64 = 3000;

/// The waits of one thread: they sleep until shortly before the time, by as much as this machine woke us late of late,
/// and spin the rest. So a quiet machine spins for a few per cent of the time, and a restless one for a quarter.
#[derive(Clone, Debug)]
pub struct Waits {
    /// \[ns\]
    spin: u64,
}

impl Default for Waits {
    fn default() -> Waits {
        Waits { spin: SPIN }
    }
}

impl Waits {
    /// Waits until `at` \[ns of [`now_ns`]\]; returns the time it is then.
    pub fn until(&mut self, at: u64) -> u64 {
        let wake = at.saturating_sub(self.spin);
        if wake > now_ns() {
            system::sleep_until(wake);
            let late = now_ns().saturating_sub(wake);
            // a thread that was put off for longer than it would spin is not helped by spinning
            let wanted = if late < SPIN { late + late / 4 } else { 0 };
            self.spin = (self.spin - self.spin / FORGET).max(wanted).clamp(LEAST_SPIN, SPIN);
        }
        loop {
            let now = now_ns();
            if now >= at {
                return now;
            }
            core::hint::spin_loop();
        }
    }
}

/// A single wait until `at` \[ns of [`now_ns`]\]; returns the time it is then.
pub fn wait_until(at: u64) -> u64 {
    Waits::default().until(at)
}

pub use system::{ask, fine_sleep, now_ns};

#[cfg(target_os = "linux")]
mod system {
    use super::{Granted, Wish};

    /// `CLOCK_MONOTONIC` \[ns\]; no call into the kernel.
    pub fn now_ns() -> u64 {
        let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: `t` is a valid place for the result.
        unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut t) };
        t.tv_sec as u64 * 1_000_000_000 + t.tv_nsec as u64
    }

    pub(super) fn sleep_until(at: u64) {
        let t = libc::timespec { tv_sec: (at / 1_000_000_000) as _, tv_nsec: (at % 1_000_000_000) as _ };
        // SAFETY: `t` is valid; a null remainder is allowed with an absolute time. A signal ends it early, which the
        // caller's spin makes up for.
        unsafe {
            libc::clock_nanosleep(libc::CLOCK_MONOTONIC, libc::TIMER_ABSTIME, &raw const t, std::ptr::null_mut())
        };
    }

    /// Makes short sleeps of this thread short: without it the kernel rounds them up by 50 µs.
    pub fn fine_sleep() {
        // SAFETY: takes no pointers.
        unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, 1_u64, 0, 0, 0) };
    }

    fn error() -> String {
        std::io::Error::last_os_error().to_string()
    }

    /// Asks for what the calling thread needs, and reads back what it has.
    pub fn ask(wish: Wish) -> Granted {
        let mut refused = Vec::new();
        fine_sleep();
        if wish.lock {
            // pages mapped later are locked too only where that cannot make allocations fail
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
        if let Some(cpu) = wish.cpu {
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
        if let Some(priority) = wish.priority {
            let p = libc::sched_param { sched_priority: i32::from(priority) };
            // SAFETY: `p` is valid.
            let failed = unsafe { libc::pthread_setschedparam(libc::pthread_self(), libc::SCHED_FIFO, &raw const p) };
            if failed != 0 {
                let why = std::io::Error::from_raw_os_error(failed);
                refused.push(format!("priority {priority} ({why}): raise `rtprio` in limits.conf"));
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
            cpus,
            locked_kb: locked.and_then(|l| l.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0),
            refused: Vec::new(),
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use super::{Granted, Wish};
    use std::sync::OnceLock;
    use std::time::{Duration, Instant};

    static START: OnceLock<Instant> = OnceLock::new();

    /// Time since the first call \[ns\].
    pub fn now_ns() -> u64 {
        START.get_or_init(Instant::now).elapsed().as_nanos() as u64
    }

    pub(super) fn sleep_until(at: u64) {
        std::thread::sleep(Duration::from_nanos(at.saturating_sub(now_ns())));
    }

    /// Nothing here.
    pub fn fine_sleep() {}

    /// Grants nothing.
    pub fn ask(wish: Wish) -> Granted {
        let asked = wish.lock || wish.cpu.is_some() || wish.priority.is_some();
        let refused = if asked { vec!["real time is asked for on Linux only".into()] } else { Vec::new() };
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
            // short ones only spin, and one of the past does nothing
            let at = last + 1000 * (n % 200);
            let now = waits.until(at);
            assert!(now >= at && now >= last);
            assert!((LEAST_SPIN..=SPIN).contains(&waits.spin));
            last = now;
        }
        assert!(wait_until(last + 100_000) >= last + 100_000);
        assert!(waits.until(0) > last);
    }

    #[test]
    fn what_is_granted_is_read_back() {
        std::thread::spawn(|| {
            let cpu = ask(Wish::default()).cpus.first().copied();
            let g = ask(Wish { priority: Some(1), cpu, lock: false });
            assert_eq!(g.policy == "FIFO", g.refused.iter().all(|r| !r.starts_with("priority")), "{g}");
            assert_eq!(g.cpus.len(), 1, "{g}");
            let none = ask(Wish { cpu: Some(100_000), ..Wish::default() });
            assert_eq!(none.refused.len(), 1, "{none}");
            assert!(none.to_string().contains("not granted: core 100000"), "{none}");
        })
        .join()
        .expect("no panic");
    }
}
