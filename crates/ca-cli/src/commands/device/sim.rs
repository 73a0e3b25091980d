//! `ca device sim`: a device that is a process, and no hardware.
//!
//! Decides that it does what a driver of a real device does, no more: once a period it says where the hand is, and gives
//! its motors what [`DeviceClient::safe_force`] lets through. What it was late for is left out and counted, never made
//! up for in a burst; a process that was suspended goes on from where it stopped. With `--lockstep` the engine's answer
//! is its clock: the force is used as it comes, and the loop is the same every time, however slow the machine.

use super::about;
use crate::args::{ScriptKind, SimArgs};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, store, term};
use ca_haptic::frame::{Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::host::{DeviceClient, HostError, Site};
use ca_haptic::profile::Profile;
use ca_haptic::rt::{self, Waits, now_ns};
use ca_haptic::simulated::{Device, Hand, Script, ScriptOptions};
use ca_haptic::stats::Times;
use ca_io::gesture::Gesture;
use ca_model::quantity::short;
use serde_json::json;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

static STOP: AtomicBool = AtomicBool::new(false);

/// In lock-step: how long an answer may take before the position is said again \[ns\]. Longer than the engine waits.
const AGAIN: u64 = 300_000_000;
/// Shortest wait for an answer, in lock step for a given time \[ns\].
const PATIENCE: f64 = 2e9;
/// Frames whose times are remembered.
const KEPT: usize = 4096;

/// Runs the command.
pub fn run(args: &SimArgs) -> Outcome {
    if let Some(log) = &args.force_log {
        let profile = store::profile_file(&args.profile);
        let gesture = args.gesture.iter().map(|p| ("the gesture", &**p));
        let inputs: Vec<_> = profile.iter().map(|p| ("the profile", &**p)).chain(gesture).collect();
        outputs::apart(&[("--force-log", log)], &inputs)?;
    }
    if args.wait && args.script == ScriptKind::Push {
        return Err(Failure::Usage(
            "--wait: `--script push` has no beginning to wait with; it pushes all the time".into(),
        ));
    }
    let mut profile = store::profile(&args.profile)?;
    if let Some(rate) = args.rate {
        profile.rate = rate;
    }
    let name = args.name.clone().unwrap_or_else(|| profile.name.clone());
    let script = script(args, &profile)?;
    let hand = if args.script == ScriptKind::Push {
        Hand::NONE
    } else {
        // where nothing pushes back any hand will do
        Hand::finger(if profile.force > 0.0 { profile.force } else { 1.0 }, &profile)
    };
    let device = Device::new(&profile, hand, script, usize::from(args.delay), args.seed);
    let log = args.force_log.as_deref().map(|path| Log::create(path, profile.dof as usize)).transpose()?;
    let client = DeviceClient::open(&Site::of_user()?, about(&name, &profile))?;
    // a handler can be set once in a process; where that fails, Ctrl-C ends the process as it would anyway
    let _ = ctrlc::set_handler(|| STOP.store(true, Relaxed));
    let granted =
        rt::ask(rt::RtRequest { priority: (args.priority > 0).then_some(args.priority), ..rt::RtRequest::default() });
    term::note(&format!("`{name}`: {}, simulated, {} frames a second; {granted}", profile.title, profile.rate));
    let mut sim = Sim {
        frame: DeviceFrame::new(&name, profile.dof as usize),
        n: profile.dof as usize,
        frame_dt: 1.0 / profile.rate,
        delay: usize::from(args.delay),
        strict: args.lockstep,
        waits: args.wait,
        device,
        client,
        log,
        held: [0; DOF],
        sent: vec![(0, 0); KEPT],
        seen: Seen { most: vec![0.0; profile.dof as usize], ..Seen::default() },
        cause: Cause::Disarmed,
    };
    let frames = args.seconds.map(|s| (s * profile.rate).round().max(1.0) as u64);
    let ended = if args.lockstep { sim.lockstep(frames) } else { sim.free(frames) };
    // what was logged is worth keeping even where the lines broke
    if let Some(log) = sim.log.take() {
        log.finish()?;
    }
    ended?;
    sim.seen.reported(&name, profile.rate, sim.client.watch().restarts, args.json)?;
    Ok(Ended::Well)
}

fn script(args: &SimArgs, profile: &Profile) -> Result<Script, Failure> {
    if args.push.is_some() && args.script != ScriptKind::Push {
        return Err(Failure::Usage("--push is the force of `--script push`".into()));
    }
    let asked = ScriptOptions { rest: args.rest.first().copied(), depth: args.depth, speed: args.speed };
    let goes = !matches!(args.script, ScriptKind::Push | ScriptKind::File);
    if !goes && (asked != ScriptOptions::default() || !args.dof.is_empty()) {
        return Err(Failure::Usage(
            "--rest, --dof, --depth and --speed are of scripts that go somewhere by themselves".into(),
        ));
    }
    if args.gesture.is_some() && args.script != ScriptKind::File {
        return Err(Failure::Usage("--gesture is played by `--script file`".into()));
    }
    let name = match args.script {
        ScriptKind::Strike => "strike",
        ScriptKind::Bow => "bow",
        ScriptKind::Shake => "shake",
        ScriptKind::Hold => "hold",
        ScriptKind::Push => match args.push {
            Some(force) if force.is_finite() => return Ok(Script::Push { force }),
            Some(_) => return Err(Failure::Usage("--push is a force in newtons".into())),
            None => "push",
        },
        ScriptKind::File => {
            let path = args.gesture.as_deref().unwrap_or(Path::new(""));
            return Ok(Script::File(Gesture::open(path, &[], None)?));
        }
    };
    let [low, high] = profile.range;
    let n = profile.dof as usize;
    if let Some(k) = args.dof.iter().find(|k| **k >= n) {
        let what = format!("--dof {k}: a {} has {n} degrees of freedom, 0 to {}", profile.title, n.saturating_sub(1));
        return Err(Failure::Usage(what));
    }
    if args.rest.len() > n {
        let what = format!("--rest: {} places for the {n} degrees of freedom of a {}", args.rest.len(), profile.title);
        return Err(Failure::Usage(what));
    }
    let moves = |k: usize| args.dof.is_empty() || args.dof.contains(&k);
    let rest = |k: usize| args.rest.get(k).or(args.rest.last()).copied().unwrap_or(0.5 * (low + high));
    for k in 0..n {
        let end = rest(k) + if moves(k) { args.depth.unwrap_or(0.0) } else { 0.0 };
        for (what, x) in [("--rest", rest(k)), ("--rest and --depth", end)] {
            if !(low..=high).contains(&x) {
                let travel = format!("its travel is {} to {} m", short(low), short(high));
                return Err(Failure::Usage(format!(
                    "{what}: {} m is where a {} cannot be; {travel}",
                    short(x),
                    profile.title
                )));
            }
        }
    }
    if args.depth == Some(0.0) {
        return Err(Failure::Usage("--depth 0 is `--script hold`".into()));
    }
    let one = |k: usize| {
        let name = if moves(k) { name } else { "hold" };
        // every name above is one of a script
        Script::named(name, profile, ScriptOptions { rest: Some(rest(k)), ..asked })
            .ok_or_else(|| Failure::Usage(format!("no script `{name}`")))
    };
    Ok(Script::Each((0..n).map(one).collect::<Result<_, _>>()?))
}

/// A device under way.
struct Sim {
    device: Device,
    client: DeviceClient,
    frame: DeviceFrame,
    n: usize,
    frame_dt: f64,
    delay: usize,
    /// forces are used as they come
    strict: bool,
    /// the script has not begun: forces are still off
    waits: bool,
    /// numbers of the forces under way to the motors, the newest first
    held: [u64; DOF],
    /// when each position was sent \[ns\], by its number
    sent: Vec<(u64, u64)>,
    log: Option<Log>,
    seen: Seen,
    cause: Cause,
}

impl Sim {
    /// At its own rate, for so many periods.
    fn free(&mut self, periods: Option<u64>) -> Result<(), Failure> {
        let (start, period, mut waits) = (now_ns(), self.frame_dt * 1e9, Waits::default());
        let mut force = [0.0; DOF];
        let mut n = 0_u64;
        while !STOP.load(Relaxed) && periods.is_none_or(|all| n < all) {
            if n > 0 {
                self.device.step(&force[..self.n], self.frame_dt);
            }
            self.send()?;
            force = self.client.safe_force();
            // of the force that was just given, not of one that came meanwhile
            let cause = self.client.watch().cause(now_ns());
            let latest = self.client.watch().last().copied();
            self.note(cause, latest.as_ref())?;
            n += 1;
            let due = start + (n as f64 * period) as u64;
            let late = (waits.until(due) - due) as f64 / period;
            // whole periods that are over say nothing of where the hand is now
            self.seen.left_out += late as u64;
            n += late as u64;
        }
        Ok(())
    }

    /// At the engine's pace, for so many frames.
    fn lockstep(&mut self, frames: Option<u64>) -> Result<(), Failure> {
        let mut n = 0_u64;
        while !STOP.load(Relaxed) && frames.is_none_or(|all| n < all) {
            let mut at = self.send()?;
            // as long as it was to last in all, and nobody answered: no server is there any more, or never was
            let patience = frames.map(|all| (all as f64 * self.frame_dt * 1e9).max(PATIENCE) as u64);
            let asked = at;
            let answer = loop {
                if STOP.load(Relaxed) {
                    return Ok(());
                }
                self.client.wait(Duration::from_millis(1));
                self.client.force();
                let (me, seq) = (self.frame.session, self.frame.seq);
                if let Some(f) = self.client.watch().last().filter(|f| f.ack_session == me && f.ack == seq) {
                    break *f;
                }
                if patience.is_some_and(|p| now_ns() > asked + p) {
                    term::warning(&format!("no server answered frame {}: ended", self.frame.seq));
                    return Ok(());
                }
                if now_ns() > at + AGAIN {
                    // nobody listened yet, or the server is another one now
                    at = self.send()?;
                    self.seen.again += 1;
                }
            };
            let mode = Mode::read(answer.mode);
            let cause = match mode {
                Mode::Off | Mode::Fault => Some(Cause::read(answer.cause)).filter(|c| *c != Cause::None),
                _ => None,
            };
            let cause = cause.unwrap_or(if mode == Mode::Off { Cause::Disarmed } else { Cause::None });
            self.note(cause, Some(&answer))?;
            let mut force = [0.0; DOF];
            for (to, f) in force.iter_mut().zip(&answer.force[..self.n]) {
                *to = f64::from(*f);
            }
            self.device.step(&force[..self.n], self.frame_dt);
            n += 1;
        }
        Ok(())
    }

    /// Says where the hand is. Returns the time \[ns\].
    fn send(&mut self) -> Result<u64, HostError> {
        self.device.frame(&mut self.frame);
        if self.strict {
            self.client.held(self.held[self.delay]);
            self.frame.cause = self.cause as u16;
        } else if self.delay > 0 {
            self.client.held(self.held[self.delay]);
            let heard = self.client.watch().last().is_some();
            self.frame.cause = if heard { self.client.watch().cause(now_ns()) } else { Cause::Disarmed } as u16;
        }
        let readers = self.client.send(&mut self.frame)?;
        self.sent[self.frame.seq as usize % KEPT] = (self.frame.seq, self.frame.t_host_ns);
        self.seen.frames += 1;
        self.seen.unread += u64::from(readers == 0);
        Ok(self.frame.t_host_ns)
    }

    /// Takes note of what acts from now on.
    fn note(&mut self, cause: Cause, latest: Option<&ForceFrame>) -> Result<(), Failure> {
        let seq = latest.map_or(0, |f| f.seq);
        if let Some(f) = latest.filter(|f| f.seq != self.seen.last) {
            self.seen.last = f.seq;
            self.seen.forces += 1;
            if f.ack > 0 && f.ack_session == self.frame.session && self.seen.first == 0 {
                self.seen.first = f.ack;
            }
            let (sent, at) = self.sent[f.ack as usize % KEPT];
            if f.ack > 0 && f.ack_session == self.frame.session && sent == f.ack {
                self.seen.loops.add(now_ns().saturating_sub(at));
            }
        }
        self.held.copy_within(0..DOF - 1, 1);
        self.held[0] = seq;
        if cause != self.cause {
            self.cause = cause;
            term::note(&format!("frame {}: {}", self.frame.seq, said(cause)));
        }
        if self.waits {
            self.waits = cause != Cause::None;
            self.device.begin();
        }
        self.seen.causes[cause as usize] += 1;
        for (most, f) in self.seen.most.iter_mut().zip(self.device.held()) {
            *most = most.max(f.abs());
        }
        if let Some(log) = &mut self.log {
            log.line(&self.frame, latest, cause, &self.device)?;
        }
        Ok(())
    }
}

fn said(cause: Cause) -> String {
    if cause == Cause::None { "forces come".into() } else { format!("no force, {}", cause.name()) }
}

/// What it saw.
#[derive(Default)]
struct Seen {
    frames: u64,
    unread: u64,
    left_out: u64,
    again: u64,
    forces: u64,
    last: u64,
    /// number of its first position that was answered
    first: u64,
    most: Vec<f64>,
    loops: Times,
    causes: [u64; ca_haptic::frame::CAUSES.len()],
}

impl Seen {
    fn reported(&self, name: &str, rate: f64, restarts: u64, asked: bool) -> std::io::Result<()> {
        let mut out = std::io::stdout().lock();
        let causes = || ca_haptic::frame::CAUSES.iter().zip(self.causes).filter(|c| c.1 > 0);
        let loops = self.loops.percentiles();
        if asked {
            let causes: serde_json::Map<String, serde_json::Value> =
                causes().map(|(c, n)| (c.name().into(), json!(n))).collect();
            let v = json!({
                "device": name, "rate": rate, "frames": self.frames, "unread": self.unread,
                "first_answered": self.first, "left_out": self.left_out, "asked_again": self.again, "forces": self.forces,
                "largest": self.most, "loop_us": loops, "causes": causes, "restarts": restarts,
            });
            return writeln!(out, "{v:#}");
        }
        writeln!(out, "{name}: {} frames at {rate} Hz", self.frames)?;
        let again = if self.again > 0 { format!(", {} said again", self.again) } else { String::new() };
        writeln!(out, "  {:<10}{} read by nobody, {} periods left out{again}", "sent", self.unread, self.left_out)?;
        let (k, most) = self.most.iter().enumerate().fold((0, 0.0), |a, (k, f)| if *f > a.1 { (k, *f) } else { a });
        let engine = if restarts > 0 { format!("; {restarts} times another engine") } else { String::new() };
        writeln!(out, "  {:<10}{} frames, largest {} N (dof {k}){engine}", "forces", self.forces, short(most))?;
        if loops.n > 0 {
            let [a, b, c, d] = [loops.p50, loops.p99, loops.p999, loops.max].map(short);
            writeln!(out, "  {:<10}p50 {a}  p99 {b}  p99.9 {c}  max {d} us, from a position to its force", "loop")?;
        }
        let list: Vec<String> = causes().map(|(c, n)| format!("{} {n}", c.name())).collect();
        writeln!(out, "  {:<10}{} (frames)", "off", list.join(", "))
    }
}

/// The file of `--force-log`.
struct Log {
    to: BufWriter<File>,
    path: String,
    line: String,
}

impl Log {
    fn create(path: &Path, n: usize) -> Result<Log, Failure> {
        let name = path.display().to_string();
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(true)
            .mode(0o644)
            .open(path)
            .map_err(|e| Failure::Failed(format!("`{name}` cannot be written: {}", crate::load::reason(&e))))?;
        let mut log = Log { to: BufWriter::with_capacity(1 << 16, file), path: name, line: String::new() };
        log.line += "seq,time,force,answers,mode,off,flags";
        for what in ["x", "f"] {
            for k in 0..n {
                let _ = write!(log.line, ",{what}{k}");
            }
        }
        log.put()?;
        Ok(log)
    }

    fn line(&mut self, frame: &DeviceFrame, f: Option<&ForceFrame>, off: Cause, d: &Device) -> Result<(), Failure> {
        self.line.clear();
        let (seq, ack, flags) = f.map_or((0, 0, 0), |f| (f.seq, f.ack, f.flags));
        let mode = f.map_or("none", |f| Mode::read(f.mode).name());
        let _ = write!(self.line, "{},{},{seq},{ack},{mode},{},{flags}", frame.seq, d.time(), off.name());
        for v in d.measured().iter().chain(d.held()) {
            let _ = write!(self.line, ",{v}");
        }
        self.put()
    }

    fn put(&mut self) -> Result<(), Failure> {
        let written = writeln!(self.to, "{}", self.line);
        written.map_err(|e| Failure::Failed(format!("`{}` cannot be written: {}", self.path, crate::load::reason(&e))))
    }

    fn finish(mut self) -> Result<(), Failure> {
        let written = self.to.flush();
        written.map_err(|e| Failure::Failed(format!("`{}` cannot be written: {}", self.path, crate::load::reason(&e))))
    }
}
