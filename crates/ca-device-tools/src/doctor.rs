//! Checks of this machine, with a remedy for each one that fails.
//!
//! Each check is an experiment: a device and a server exchange frames through shared memory, a thread requests
//! real-time priority and reads back what was granted, and a timer waits for a second of gesture frames. Only unusable
//! shared memory is a failure; everything else costs punctuality.

use crate::{ToolError, about};
use ca_haptic::frame::{DeviceFrame, ForceFrame};
use ca_haptic::host::control::{Request, ask};
use ca_haptic::host::gateway::list_devices;
use ca_haptic::host::{DeviceClient, Gateway, HostError, HostErrorKind, Site, stale_shm};
use ca_haptic::profile::Profile;
use ca_haptic::rt::{self, RtRequest, Waits, now_ns};
use ca_haptic::stats::{Percentiles, Times};
use ca_model::quantity::short;
use std::fs;
use std::time::Duration;

/// Gesture frame of most models \[ns\].
const PERIOD: u64 = 333_333;
/// Frames in a second.
const FRAMES: u64 = 3000;
/// Frames exchanged through shared memory.
const ROUNDS: u64 = 200;

/// Result of one check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// As it should be.
    Good,
    /// Costs punctuality.
    Poor,
    /// Devices cannot be played.
    Bad,
}

impl State {
    /// Returns the name of the state.
    pub fn name(self) -> &'static str {
        match self {
            State::Good => "good",
            State::Poor => "poor",
            State::Bad => "bad",
        }
    }
}

/// One check with its result.
#[derive(Clone, Debug)]
pub struct DiagnosisRow {
    /// Result.
    pub state: State,
    /// Name of the check.
    pub what: &'static str,
    /// Description of the finding.
    pub found: String,
    /// Remedy; empty if none is needed.
    pub fix: String,
}

impl DiagnosisRow {
    fn good(what: &'static str, found: impl Into<String>) -> DiagnosisRow {
        DiagnosisRow { state: State::Good, what, found: found.into(), fix: String::new() }
    }
    fn poor(what: &'static str, found: impl Into<String>, fix: impl Into<String>) -> DiagnosisRow {
        DiagnosisRow { state: State::Poor, what, found: found.into(), fix: fix.into() }
    }
    fn bad(what: &'static str, e: &HostError) -> DiagnosisRow {
        DiagnosisRow { state: State::Bad, what, found: e.what.clone(), fix: e.fix.clone() }
    }
}

/// Results of all checks.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// Checks, in order.
    pub rows: Vec<DiagnosisRow>,
    /// Lateness of a second of gesture frames.
    pub late: Percentiles,
    /// Number of frames that were late by more than a frame.
    pub late_by_a_frame: u64,
}

impl Diagnosis {
    /// Returns true if devices can be played on this machine.
    pub fn is_usable(&self) -> bool {
        self.rows.iter().all(|r| r.state != State::Bad)
    }
}

/// Checks this machine. This takes a few seconds.
///
/// # Errors
/// If a thread for the timer cannot be started.
pub fn examine() -> Result<Diagnosis, ToolError> {
    let mut rows = Vec::new();
    match Site::of_user() {
        Ok(site) => {
            rows.push(DiagnosisRow::good("place", format!("{}, writable only by you", site.root().display())));
            rows.push(left_over(&site));
            rows.push(match round(&site) {
                Ok(t) => DiagnosisRow::good("memory", format!("{ROUNDS} round trips of a frame, p50 {:.1} us", t.p50)),
                Err(e) => DiagnosisRow::bad("memory", &e),
            });
            rows.extend(others(&site));
        }
        Err(e) => rows.push(DiagnosisRow::bad("place", &e)),
    }
    rows.extend(limits());
    let second = std::thread::Builder::new()
        .name("ca doctor".into())
        .spawn(second)
        .map_err(|e| ToolError::Failed(format!("cannot start a thread: {e}")))?;
    let stopped = |_| ToolError::Failed("the timer thread stopped unexpectedly".into());
    let (granted, late, over) = second.join().map_err(stopped)?;
    rows.push(if granted.refused.is_empty() {
        DiagnosisRow::good("real time", granted.to_string())
    } else {
        let fix = "give your user `rtprio 95`, `memlock unlimited` and `nice -11` in /etc/security/limits.conf, and log in again";
        DiagnosisRow::poor("real time", granted.to_string(), fix)
    });
    let reported = format!("{FRAMES} wake-ups, late by {}; {over} by more than a frame", times(&late));
    rows.push(if over <= FRAMES / 100 {
        DiagnosisRow::good("timer", reported)
    } else {
        DiagnosisRow::poor(
            "timer",
            reported,
            "close programs that keep the cores busy, or bind the engine to a core: `ca serve MODEL --cpu N`",
        )
    });
    Ok(Diagnosis { rows, late, late_by_a_frame: over })
}

fn times(t: &Percentiles) -> String {
    let [a, b, c, d] = [t.p50, t.p99, t.p999, t.max].map(short);
    format!("p50 {a}  p99 {b}  p99.9 {c}  max {d} us")
}

/// Looks for shared memory of processes that ended.
fn left_over(site: &Site) -> DiagnosisRow {
    let groups = stale_shm::list(site);
    let dead: Vec<String> = groups
        .iter()
        .filter(|g| !g.current && g.alive.is_empty())
        .map(|g| format!("{} files (frame version {}, iceoryx2 {})", g.files.len(), g.frames, g.iox))
        .collect();
    let swept = site.remove_dead();
    if swept.left > 0 {
        let found = format!("the files of {} ended processes cannot be removed", swept.left);
        return DiagnosisRow::poor("stale shared memory", found, "run `ca shm clean`");
    }
    if dead.is_empty() {
        DiagnosisRow::good("stale shared memory", "none")
    } else {
        DiagnosisRow::poor("stale shared memory", dead.join(", "), "run `ca shm clean`")
    }
}

/// Measures round trips of frames between a device and a server, both in this process, through shared memory.
fn round(site: &Site) -> Result<Percentiles, HostError> {
    let name = format!("doctor-{}", std::process::id());
    let profile = Profile { dof: 1, axes: 1, ..Profile::shipped("unknown").unwrap_or_else(|| unreachable!()) };
    let mut device = DeviceClient::open(site, about(&name, &profile))?;
    let mut server = Gateway::open(site, &[&name])?;
    let (mut frame, mut force) = (DeviceFrame::new(&name, 1), ForceFrame::new(&name, 1));
    let mut times = Times::new();
    (force.session, force.ttl_us) = (1, 5000);
    for n in 1..=ROUNDS {
        let begin = now_ns();
        frame.pos[0] = n as f64;
        device.send(&mut frame)?;
        let mut came = None;
        server.poll(&mut |_, f| came = Some(f));
        let answer = came.filter(|f| f.pos[0] == n as f64).and_then(|f| {
            (force.seq, force.ack_session, force.ack) = (n, f.session, f.seq);
            force.t_host_ns = now_ns();
            server.send(0, &force);
            device.force().filter(|f| f.seq == n)
        });
        if answer.is_none() {
            return Err(HostError {
                kind: HostErrorKind::System,
                what: format!("frame {n} of {ROUNDS} did not come back through shared memory"),
                fix: "check if /dev/shm is full: `df /dev/shm`".into(),
            });
        }
        times.add(now_ns() - begin);
    }
    Ok(times.percentiles())
}

/// Looks for the server and the devices of this machine.
fn others(site: &Site) -> Vec<DiagnosisRow> {
    let server = match ask(site, &Request::Status, Duration::from_millis(500)) {
        Ok(r) => DiagnosisRow::good("server", format!("running: {}", r.text.lines().next().unwrap_or_default())),
        Err(e) if e.kind == HostErrorKind::Absent => {
            DiagnosisRow::good("server", "none is running; `ca serve MODEL` starts one")
        }
        Err(e) => DiagnosisRow::poor("server", e.what, e.fix),
    };
    let devices = match list_devices(site, Duration::from_millis(1500)) {
        Ok(list) if list.is_empty() => DiagnosisRow::good("devices", "none is running"),
        Ok(list) => {
            let names: Vec<_> = list.iter().map(|a| ca_haptic::frame::text(&a.device)).collect();
            DiagnosisRow::good("devices", names.join(", "))
        }
        Err(e) => DiagnosisRow::poor("devices", e.what, e.fix),
    };
    vec![server, devices]
}

fn limits() -> Vec<DiagnosisRow> {
    let mut rows = Vec::new();
    let cores = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
    rows.push(if cores >= 2 {
        DiagnosisRow::good("cores", cores.to_string())
    } else {
        DiagnosisRow::poor(
            "cores",
            cores.to_string(),
            "the engine and the gateway need one core each: expect late frames",
        )
    });
    let read = |path: &str| fs::read_to_string(path).ok().map(|t| t.trim().to_string());
    if let Some(limits) = read("/proc/self/limits") {
        let of = |name: &str| {
            let line = limits.lines().find(|l| l.starts_with(name))?;
            line[name.len()..].split_whitespace().next().map(str::to_owned)
        };
        let all = [of("Max locked memory"), of("Max realtime priority"), of("Max nice priority")];
        let [lock, priority, nice] = all.map(|v| v.unwrap_or_else(|| "?".into()));
        // the system reports 20 minus the lowest value
        let nice = nice.parse::<i32>().map_or(nice, |n| (20 - n).to_string());
        let found = format!("memlock {lock} bytes, rtprio {priority}, nice {nice} (root does not need them)");
        rows.push(DiagnosisRow::good("limits", found));
    }
    let governor = read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
    if let Some(governor) = governor.filter(|g| g != "performance") {
        let fix = "run `cpupower frequency-set -g performance` before you play";
        rows.push(DiagnosisRow::poor("frequency", format!("governor `{governor}`: cores wake slowly"), fix));
    }
    if let Some(us) = read("/proc/sys/kernel/sched_rt_runtime_us") {
        rows.push(DiagnosisRow::good(
            "throttle",
            format!("real-time threads may run {us} us of each second; `ca` stays below this limit"),
        ));
    }
    rows
}

/// Waits for a second of gesture frames like the engine. Returns the priority granted, the lateness, and the number of
/// frames late by more than a frame.
fn second() -> (rt::Granted, Percentiles, u64) {
    let granted = rt::ask(RtRequest { priority: Some(70), lock: true, ..RtRequest::default() });
    let (mut late, mut over, mut waits) = (Times::new(), 0, Waits::default());
    let start = now_ns();
    for n in 1..=FRAMES {
        let due = start + n * PERIOD;
        let by = waits.until(due) - due;
        late.add(by);
        over += u64::from(by > PERIOD);
    }
    (granted, late.percentiles(), over)
}
