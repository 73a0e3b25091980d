//! Test engine for one device: the real engine, guard and gateway, in one thread, with a scene that pulls slightly at
//! each degree of freedom.

use crate::ToolError;
use ca_compile::Options as Compile;
use ca_core::{Controls, Scene};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{Change, Engine, EngineCommand, Options, Port, Setup};
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::host::{Event, Gateway, HostError, Site, session_number};
use ca_haptic::profile::Profile;
use ca_haptic::rt::{Waits, now_ns};
use ca_model::read;
use cordis_anima::catalog;
use std::fmt::Write as _;
use std::sync::Arc;

/// Frames of the device that are examined in a phase.
pub(super) const LOOK: usize = 200;
/// Engine frames of a phase at rest.
pub(super) const REST: u32 = 600;
/// Longest wait for the first frame of a device, and for a phase \[ns\].
pub(super) const PATIENCE: u64 = 5_000_000_000;

/// Attempts to switch forces on: a busy machine trips watchdogs, which is not the fault of the device.
pub(super) const TRIES: u32 = 8;

/// Largest distance from the device to the rest position of the known spring: \[m\], and as a share of its travel.
const STRETCH: [f64; 2] = [0.002, 0.1];

/// Distance of the far ends of the pulling springs from the hand \[m\]: so large that their force hardly depends on the
/// position.
const REACH: f64 = 1.0;

/// Connection to one device, with the frames exchanged.
pub struct Bench {
    lines: Gateway,
    /// Name of the device.
    pub name: String,
    calibration: Calibration,
    /// Frames of the device since [`Bench::forget`], with positions in metres.
    pub frames: Vec<DeviceFrame>,
    /// Force frames sent since then.
    pub sent: Vec<ForceFrame>,
    /// Number of frames of other versions or devices.
    pub foreign: u64,
    due: f64,
    waits: Waits,
}

/// An engine, and the parameters of its scene.
pub struct Player {
    pub engine: Engine,
    controls: Controls,
    period: f64,
    /// Rest positions of the two known springs of each degree of freedom, on either side of the device \[m\].
    pub rest: [[f64; DOF]; 2],
    /// Their distance from the device \[m\].
    pub stretch: f64,
}

impl Bench {
    /// Opens the services of the device as its server.
    pub fn open(site: &Site, name: &str, calibration: Calibration) -> Result<Bench, HostError> {
        Ok(Bench {
            lines: Gateway::open(site, &[name])?,
            name: name.into(),
            calibration,
            frames: Vec::new(),
            sent: Vec::new(),
            foreign: 0,
            due: 0.0,
            waits: Waits::default(),
        })
    }

    /// Returns the description that the device sends of itself.
    pub fn about(&self) -> Option<About> {
        self.lines.about(0).copied()
    }

    /// Begins a new phase.
    pub fn forget(&mut self) {
        self.poll(&mut |_| {});
        self.frames.clear();
        self.sent.clear();
        self.due = now_ns() as f64;
    }

    fn poll(&mut self, each: &mut dyn FnMut(DeviceFrame)) {
        let (frames, calibration) = (&mut self.frames, &self.calibration);
        self.lines.poll(&mut |_, f| {
            let mut real = f;
            calibration.positions(&mut real.pos);
            frames.push(real);
            each(f);
        });
        while let Some((_, event)) = self.lines.event() {
            self.foreign += u64::from(matches!(event, Event::Foreign(_)));
        }
    }

    /// Receives without sending, until `frames` frames came or `patience` \[ns\] is over.
    pub fn listen(&mut self, frames: usize, patience: u64) {
        let end = now_ns() + patience;
        while self.frames.len() < frames && now_ns() < end {
            self.poll(&mut |_| {});
            self.waits.sleep(now_ns() + 200_000);
        }
    }

    /// Runs an engine for `frames` frames, at its rate.
    pub fn play(&mut self, player: &mut Player, frames: u32) {
        for _ in 0..frames {
            self.due += player.period;
            let now = self.waits.until(self.due as u64) as f64;
            // late by more than a frame: missed frames are not made up for
            if now > self.due + player.period {
                self.due = now;
            }
            let engine = &mut player.engine;
            self.poll(&mut |mut f| {
                engine.take(0, &mut f);
            });
            let out = engine.answer().next().copied();
            if let Some(mut out) = out {
                self.send(&mut out);
            }
            player.engine.finish();
        }
    }

    /// Sends a force frame unchanged but for the time.
    pub fn send(&mut self, frame: &mut ForceFrame) {
        frame.t_host_ns = now_ns();
        self.lines.send(0, frame);
        self.sent.push(*frame);
    }

    /// Returns the mode and cause of the last force.
    pub fn mode(&self) -> (Mode, Cause) {
        self.sent.last().map_or((Mode::Off, Cause::Disarmed), |f| (Mode::read(f.mode), Cause::read(f.cause)))
    }

    /// Makes an engine whose scene has the device at its present position.
    pub fn player(&self, profile: &Profile) -> Result<Player, ToolError> {
        let x = self.frames.last().map_or([0.0; DOF], |f| f.pos);
        let [low, high] = profile.range;
        let stretch = STRETCH[0].min(STRETCH[1] * (high - low));
        let rest = [x.map(|x| x - stretch), x.map(|x| x + stretch)];
        let scene = Arc::new(scene(&self.name, profile.dof as usize, &x, &rest)?);
        let setup = Setup {
            device: self.name.clone(),
            profile: profile.clone(),
            calibration: self.calibration.clone(),
            gains: Vec::new(),
        };
        let port = Port::new(&scene, setup);
        let (controls, period) = (scene.controls(), 1e9 * f64::from(scene.rates.ratio) / scene.rate);
        let own = Options { session: session_number(), ..Options::default() };
        Ok(Player { engine: Engine::new(scene, vec![port], own), controls, period, rest, stretch })
    }
}

impl Player {
    pub fn order(&mut self, order: Order) {
        self.engine.command(EngineCommand::Order(None, order));
    }

    /// Pulls at each degree of freedom with this force \[N\].
    pub fn pull(&mut self, force: f64) -> Result<(), ToolError> {
        self.set("pull", force / REACH)
    }

    /// Holds each degree of freedom by springs of this stiffness \[N/m\], with rest positions [`Player::rest`].
    pub fn springs(&mut self, k: [f64; 2]) -> Result<(), ToolError> {
        self.set("below", k[0])?;
        self.set("above", k[1])
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), ToolError> {
        let patch = self.controls.set(name, value).map_err(|e| ToolError::Failed(e.to_string()))?;
        self.engine.command(EngineCommand::Set(Box::new(Change { params: Vec::new(), patches: vec![patch] })));
        Ok(())
    }
}

/// Makes a scene with three springs at each degree of freedom: a pulling one with the live parameter `pull`, and two
/// around the position with the stiffness parameters `below` and `above`.
fn scene(name: &str, n: usize, x: &[f64; DOF], rest: &[[f64; DOF]; 2]) -> Result<Scene, ToolError> {
    let mut text = String::from("[param]\n");
    for (param, most) in [("pull", 100), ("below", 10_000), ("above", 10_000)] {
        let _ = writeln!(text, "{param} = {{ value = 0, unit = \"N/m\", live = true, min = 0, max = {most} }}");
    }
    text += "[TGR]\n";
    for (k, x) in x.iter().enumerate().take(n) {
        let _ = writeln!(text, "d{k} = {{ device = \"{name}\", dof = {k}, x = {x:e} }}");
    }
    text += "[SOL]\n";
    for (k, x) in x.iter().enumerate().take(n) {
        let [below, above] = [rest[0][k], rest[1][k]];
        let _ = writeln!(text, "far{k} = {{ x = {:e} }}\nlow{k} = {{ x = {below:e} }}", x + REACH);
        let _ = writeln!(text, "high{k} = {{ x = {above:e} }}");
    }
    text += "[RES]\n";
    for k in 0..n {
        for (to, param) in [("far", "pull"), ("low", "below"), ("high", "above")] {
            let _ = writeln!(text, "{to}_{k} = {{ between = [\"d{k}\", \"{to}{k}\"], k = \"{param}\", l0 = 0 }}");
        }
    }
    let (model, found) = read::read(&text, "conformance", &catalog());
    ca_compile::load::finish(&model, found, &catalog(), &Compile::default())
        .map(|compiled| compiled.scene)
        .map_err(|d| ToolError::Failed(format!("the test scene does not compile: {:?}", d.list)))
}
