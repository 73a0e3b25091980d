//! State of one device in the recorder: mode, latency, what it waits for, and messages about these.

use crate::engine::{Port, coupled};
use crate::frame::{Cause, DeviceFrame, ForceFrame, Mode, flag};
use crate::guard::Order;
use crate::guard::wait::Wait;
use crate::serve::loop_latency::LoopLatency;
use crate::serve::sink::Notice;
use crate::serve::summary::{DeviceSummary, Fault};
use crate::stats::Times;
use ca_core::{InputRole, Scene};

/// Interval between messages about a device that is armed and waits \[s\].
const REPEAT: f64 = 2.0;
/// Checks after which a waiting device is reported; a model moves to its device within a second, without a message.
const LOOKS: u32 = 5;

pub(super) struct DeviceMonitor {
    pub name: String,
    profile: String,
    pub mode: Mode,
    pub cause: Cause,
    pub frames: u64,
    /// Degrees of freedom in its last frame.
    pub dof: u32,
    forces_on: bool,
    /// True while its passivity stage is off.
    undamped: bool,
    /// Reason for waiting, number of checks at which it waited, and tick of the last message.
    wait: Option<String>,
    looks: u32,
    reported: u64,
    /// Tick of the disarm or trip that ended its wait.
    ended: Option<u64>,
    loops: LoopLatency,
    times: Times,
}

impl DeviceMonitor {
    /// Starts with the device of a port, before any frame.
    pub fn new(p: &Port) -> DeviceMonitor {
        DeviceMonitor {
            name: p.name.clone(),
            profile: p.profile.name.clone(),
            mode: Mode::Off,
            cause: Cause::Disarmed,
            frames: 0,
            dof: 0,
            forces_on: false,
            undamped: false,
            wait: None,
            looks: 0,
            reported: 0,
            ended: None,
            loops: LoopLatency::new(),
            times: Times::new(),
        }
    }

    /// Notes a frame from the device. Returns the latency \[ns\] of the loop that it ends, if any.
    pub fn sent(&mut self, frame: &DeviceFrame) -> Option<u64> {
        self.frames += 1;
        self.dof = u32::from(frame.n);
        let ns = self.loops.device(frame, crate::time::now_ns())?;
        self.times.add(ns);
        Some(ns)
    }

    /// Notes a force frame to the device, adds messages to `notices`, and returns the fault that it begins, if any.
    pub fn force(&mut self, frame: &ForceFrame, notices: &mut Vec<Notice>) -> Option<Fault> {
        self.loops.force(frame);
        let undamped = frame.flags & flag::PASSIVITY_OFF != 0;
        if undamped && !self.undamped {
            notices.push(self.notice(frame.tick, true, "passivity damping gave energy to the hand; off for a while"));
        }
        self.undamped = undamped;
        let now = (Mode::read(frame.mode), Cause::read(frame.cause));
        if now == (self.mode, self.cause) {
            return None;
        }
        let had_forces = self.mode != Mode::Off;
        (self.mode, self.cause) = now;
        self.forces_on |= matches!(now.0, Mode::Ramp | Mode::On);
        if now.0 != Mode::Off {
            (self.wait, self.looks, self.reported) = (None, 0, 0);
        }
        let text = match now {
            (Mode::Fault, cause) => format!("forces off, {}", cause.name()),
            (Mode::Damp, cause) => format!("braking, {}", cause.name()),
            (Mode::Off, Cause::None) => "armed; waiting until nothing pushes".into(),
            (Mode::Off, _) => "forces off".into(),
            (Mode::Ramp, _) if had_forces && frame.flags & flag::WAIT_CLEAR != 0 => {
                "forces fade out: another version of the model plays".into()
            }
            (Mode::Ramp, _) => "forces fade in".into(),
            (Mode::On, _) => "forces on".into(),
        };
        notices.push(self.notice(frame.tick, matches!(now.0, Mode::Fault | Mode::Damp), &text));
        (now.0 == Mode::Fault).then(|| Fault { device: self.name.clone(), cause: now.1, tick: frame.tick })
    }

    pub fn order(&mut self, tick: u64, order: Order) {
        if order == Order::Arm {
            (self.wait, self.looks, self.reported, self.ended) = (None, 0, 0, None);
        } else {
            self.ended = Some(tick);
        }
    }

    /// Notes that it is armed without force. Returns a message once this has lasted, and again at intervals.
    pub fn waits(&mut self, tick: u64, wait: &Wait, scene: &Scene) -> Option<Notice> {
        let name = |dof: u32| {
            let this = |d: &(String, u32)| d.0 == self.name && d.1 == dof;
            let found =
                scene.inputs.iter().find(|i| i.role == InputRole::Device && i.device.as_ref().is_some_and(this));
            found.map_or_else(|| format!("degree of freedom {dof}"), |i| format!("`{}`", i.name))
        };
        let text = wait.text(&name);
        self.looks += 1;
        let due = self.reported == 0 || tick >= self.reported + (REPEAT * scene.rate) as u64;
        let said =
            (self.looks >= LOOKS && due).then(|| self.notice(tick, true, &format!("armed, forces still off: {text}")));
        if said.is_some() {
            self.reported = tick.max(1);
        }
        (self.wait, self.ended) = (Some(text), None);
        said
    }

    /// Returns the reason for which it waits.
    pub fn waiting(&self) -> Option<&str> {
        self.wait.as_deref().filter(|_| self.ended.is_none())
    }

    /// Returns the summary at the last `tick` of an engine with `ratio` samples in a gesture frame.
    pub fn summary(&self, port: &Port, scene: &Scene, tick: u64, ratio: u64) -> DeviceSummary {
        DeviceSummary {
            device: self.name.clone(),
            profile: self.profile.clone(),
            frames: self.frames,
            dropped: port.dropped(),
            softened: coupled(scene, &self.name).iter().map(|c| (c.0.into(), c.1)).collect(),
            loop_us: self.times.percentiles(),
            forces_on: self.forces_on,
            // the engine ends with its own disarm order, so a device that waited until then waited to the end
            waits: self.wait.clone().filter(|_| self.ended.is_none_or(|t| t + 2 * ratio >= tick)),
        }
    }

    fn notice(&self, tick: u64, bad: bool, what: &str) -> Notice {
        Notice { tick, device: Some(self.name.clone()), bad, text: format!("{}: {what}", self.name) }
    }
}
