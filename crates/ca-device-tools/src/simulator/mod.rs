//! A device process without hardware.
//!
//! It works like the driver of a real device: once a period it sends the position of the hand, and gives its motors the
//! force from [`DeviceClient::safe_force`]. A missed period is skipped and counted, never made up for in a burst; a
//! suspended process resumes where it stopped. In lock-step the answer of the engine is the clock: the force is used as
//! it comes, so the loop is deterministic on a machine of any speed.

mod log;

use crate::{Message, ToolError, about};
use ca_haptic::frame::{CAUSES, Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::host::{DeviceClient, HostError, Site};
use ca_haptic::profile::Profile;
use ca_haptic::rt::{self, RtRequest, Waits, now_ns};
use ca_haptic::simulated::{Device, Hand, Script};
use ca_haptic::stats::{Percentiles, Times};
use log::Log;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// In lock-step: time without an answer after which the position is sent again \[ns\]. It exceeds the wait of the
/// engine.
const AGAIN: u64 = 300_000_000;
/// Shortest wait for an answer in lock-step with a given duration \[ns\].
const PATIENCE: f64 = 2e9;
/// Frames whose times are stored.
const KEPT: usize = 4096;

/// Options of a simulated device.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Name by which models know the device.
    pub name: String,
    /// Simulated hardware, with its rate.
    pub profile: Profile,
    /// Hand that holds the device.
    pub hand: Hand,
    /// Motion of the hand.
    pub script: Script,
    /// Delay of a force on its way to the motors \[frames\], less than [`DOF`].
    pub delay: usize,
    /// Seed of the noise on its positions.
    pub seed: u64,
    /// Duration \[s\]; `None` runs until stopped.
    pub seconds: Option<f64>,
    /// Starts the script when forces come.
    pub waits: bool,
    /// Uses the answers of the engine as the clock.
    pub lockstep: bool,
    /// File that gets a line for each frame.
    pub force_log: Option<PathBuf>,
    /// Real-time priority (SCHED_FIFO) to request, if any.
    pub priority: Option<u8>,
}

/// Statistics of a simulated device.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Name of the device.
    pub device: String,
    /// Frames a second.
    pub rate: f64,
    /// Number of frames sent.
    pub frames: u64,
    /// Number of frames without a reader.
    pub unread: u64,
    /// Number of its first position that was answered.
    pub first_answered: u64,
    /// Number of skipped periods.
    pub left_out: u64,
    /// Number of positions sent again.
    pub again: u64,
    /// Number of forces received.
    pub forces: u64,
    /// Largest force at each degree of freedom \[N\].
    pub largest: Vec<f64>,
    /// Times from a position to its force.
    pub loops: Percentiles,
    /// Number of frames under each cause, in the order of [`CAUSES`].
    pub causes: [u64; CAUSES.len()],
    /// Number of changes to another engine.
    pub restarts: u64,
}

/// A running simulated device.
pub struct Simulator {
    title: String,
    priority: Option<u8>,
    frames: Option<u64>,
    lockstep: bool,
    device: Device,
    client: DeviceClient,
    frame: DeviceFrame,
    n: usize,
    frame_dt: f64,
    delay: usize,
    /// Waits for forces before the script starts.
    waits: bool,
    /// Numbers of the forces on their way to the motors, the newest first.
    held: [u64; DOF],
    /// Number and time \[ns\] of each position sent.
    sent: Vec<(u64, u64)>,
    log: Option<Log>,
    seen: Summary,
    /// Number of the last force, and times from a position to its force.
    last: u64,
    loops: Times,
    cause: Cause,
}

impl Simulator {
    /// Opens the services of the device.
    ///
    /// # Errors
    /// If its name is taken, its delay is too long, or the force log cannot be written.
    pub fn open(options: Simulation) -> Result<Simulator, ToolError> {
        let Simulation { name, profile, hand, script, delay, seed, seconds, waits, lockstep, force_log, priority } =
            options;
        if delay >= DOF {
            return Err(ToolError::Usage(format!("a delay of {delay} frames is too long; use at most {}", DOF - 1)));
        }
        let n = profile.dof as usize;
        let device = Device::new(&profile, hand, script, delay, seed);
        let log = force_log.as_deref().map(|path| Log::create(path, n)).transpose()?;
        let client = DeviceClient::open(&Site::of_user()?, about(&name, &profile))?;
        Ok(Simulator {
            frame: DeviceFrame::new(&name, n),
            n,
            frame_dt: 1.0 / profile.rate,
            frames: seconds.map(|s| (s * profile.rate).round().max(1.0) as u64),
            seen: Summary { device: name, rate: profile.rate, largest: vec![0.0; n], ..Summary::default() },
            title: profile.title,
            priority,
            lockstep,
            delay,
            waits,
            device,
            client,
            log,
            held: [0; DOF],
            sent: vec![(0, 0); KEPT],
            last: 0,
            loops: Times::new(),
            cause: Cause::Disarmed,
        })
    }

    /// Runs for its duration, or until `stop` is true.
    ///
    /// # Errors
    /// If the connection fails, or the force log cannot be written.
    pub fn run(mut self, stop: &AtomicBool, say: &mut dyn FnMut(Message)) -> Result<Summary, ToolError> {
        let granted = rt::ask(RtRequest { priority: self.priority, ..RtRequest::default() });
        let (name, rate) = (&self.seen.device, self.seen.rate);
        say(Message::Note(format!("`{name}`: {}, simulated, {rate} frames a second; {granted}", self.title)));
        let frames = self.frames;
        let ended = if self.lockstep { self.in_lockstep(frames, stop, say) } else { self.free(frames, stop, say) };
        // the log is kept even if the connection failed
        if let Some(log) = self.log.take() {
            log.finish()?;
        }
        ended?;
        self.seen.restarts = self.client.watchdog().restarts;
        self.seen.loops = self.loops.percentiles();
        Ok(self.seen)
    }

    /// Runs at the rate of the device, for `periods` if given.
    fn free(&mut self, periods: Option<u64>, stop: &AtomicBool, say: &mut dyn FnMut(Message)) -> Result<(), ToolError> {
        let (start, period, mut waits) = (now_ns(), self.frame_dt * 1e9, Waits::default());
        let mut force = [0.0; DOF];
        let mut n = 0_u64;
        while !stop.load(Relaxed) && periods.is_none_or(|all| n < all) {
            if n > 0 {
                self.device.step(&force[..self.n], self.frame_dt);
            }
            self.send()?;
            force = self.client.safe_force();
            // the cause of the force just applied, not of one received since
            let cause = self.client.watchdog().cause(now_ns());
            let latest = self.client.watchdog().last().copied();
            self.note(cause, latest.as_ref(), say)?;
            n += 1;
            let due = start + (n as f64 * period) as u64;
            let late = (waits.until(due) - due) as f64 / period;
            // skips missed periods, since the position of the hand then is out of date
            self.seen.left_out += late as u64;
            n += late as u64;
        }
        Ok(())
    }

    /// Runs at the pace of the engine, for `frames` if given.
    fn in_lockstep(
        &mut self,
        frames: Option<u64>,
        stop: &AtomicBool,
        say: &mut dyn FnMut(Message),
    ) -> Result<(), ToolError> {
        let mut n = 0_u64;
        while !stop.load(Relaxed) && frames.is_none_or(|all| n < all) {
            let mut at = self.send()?;
            // no answer for the whole duration: the server has ended, or there never was one
            let patience = frames.map(|all| (all as f64 * self.frame_dt * 1e9).max(PATIENCE) as u64);
            let asked = at;
            let answer = loop {
                if stop.load(Relaxed) {
                    return Ok(());
                }
                self.client.wait(Duration::from_millis(1));
                self.client.force();
                let (me, seq) = (self.frame.session, self.frame.seq);
                if let Some(f) = self.client.watchdog().last().filter(|f| f.ack_session == me && f.ack == seq) {
                    break *f;
                }
                if patience.is_some_and(|p| now_ns() > asked + p) {
                    say(Message::Warning(format!("stopped, because no server answered frame {}", self.frame.seq)));
                    return Ok(());
                }
                if now_ns() > at + AGAIN {
                    // the server started after the frame, or has been replaced
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
            self.note(cause, Some(&answer), say)?;
            let mut force = [0.0; DOF];
            for (to, f) in force.iter_mut().zip(&answer.force[..self.n]) {
                *to = f64::from(*f);
            }
            self.device.step(&force[..self.n], self.frame_dt);
            n += 1;
        }
        Ok(())
    }

    /// Sends the position of the hand. Returns the time \[ns\].
    fn send(&mut self) -> Result<u64, HostError> {
        self.device.frame(&mut self.frame);
        if self.lockstep {
            self.client.held(self.held[self.delay]);
            self.frame.cause = self.cause as u16;
        } else if self.delay > 0 {
            self.client.held(self.held[self.delay]);
            let heard = self.client.watchdog().last().is_some();
            self.frame.cause = if heard { self.client.watchdog().cause(now_ns()) } else { Cause::Disarmed } as u16;
        }
        let readers = self.client.send(&mut self.frame)?;
        self.sent[self.frame.seq as usize % KEPT] = (self.frame.seq, self.frame.t_host_ns);
        self.seen.frames += 1;
        self.seen.unread += u64::from(readers == 0);
        Ok(self.frame.t_host_ns)
    }

    /// Records the force that acts from now on.
    fn note(
        &mut self,
        cause: Cause,
        latest: Option<&ForceFrame>,
        say: &mut dyn FnMut(Message),
    ) -> Result<(), ToolError> {
        let seq = latest.map_or(0, |f| f.seq);
        if let Some(f) = latest.filter(|f| f.seq != self.last) {
            self.last = f.seq;
            self.seen.forces += 1;
            if f.ack > 0 && f.ack_session == self.frame.session && self.seen.first_answered == 0 {
                self.seen.first_answered = f.ack;
            }
            let (sent, at) = self.sent[f.ack as usize % KEPT];
            if f.ack > 0 && f.ack_session == self.frame.session && sent == f.ack {
                self.loops.add(now_ns().saturating_sub(at));
            }
        }
        self.held.copy_within(0..DOF - 1, 1);
        self.held[0] = seq;
        if cause != self.cause {
            self.cause = cause;
            say(Message::Note(format!("frame {}: {}", self.frame.seq, cause_text(cause))));
        }
        if self.waits {
            self.waits = cause != Cause::None;
            self.device.begin();
        }
        self.seen.causes[cause as usize] += 1;
        for (most, f) in self.seen.largest.iter_mut().zip(self.device.held()) {
            *most = most.max(f.abs());
        }
        if let Some(log) = &mut self.log {
            log.line(&self.frame, latest, cause, &self.device)?;
        }
        Ok(())
    }
}

fn cause_text(cause: Cause) -> String {
    if cause == Cause::None { "receiving forces".into() } else { format!("no force, {}", cause.name()) }
}
