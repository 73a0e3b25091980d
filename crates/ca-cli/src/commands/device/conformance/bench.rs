//! An engine of its own for one device: the real engine, guard and gateway, in one thread, with a scene that pulls a
//! little at each degree of freedom.

use crate::{Failure, catalog};
use ca_core::live::Controls;
use ca_core::model::read;
use ca_core::{Options as Compile, Scene};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{Act, Change, Engine, Options, Port, Setup};
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::host::{Event, Gateway, HostError, Site, session};
use ca_haptic::profile::Profile;
use ca_haptic::rt::{Waits, now_ns};
use std::fmt::Write as _;
use std::sync::Arc;

/// Where the springs of the scene end, beyond the hand \[m\]: so far that their force hardly depends on where it is.
const REACH: f64 = 1.0;

/// One device, and what passed between it and us.
pub struct Bench {
    lines: Gateway,
    name: String,
    calibration: Calibration,
    /// frames of the device since [`Bench::forget`], positions in metres
    pub frames: Vec<DeviceFrame>,
    /// force frames sent since then
    pub sent: Vec<ForceFrame>,
    /// frames of other versions or devices
    pub foreign: u64,
    due: f64,
    waits: Waits,
}

/// An engine, and the parameter of its scene.
pub struct Player {
    pub engine: Engine,
    controls: Controls,
    period: f64,
}

impl Bench {
    /// Takes the lines of a server.
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

    /// What the device says of itself.
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

    /// Listens without a word until so many frames came, or for so long \[ns\].
    pub fn listen(&mut self, frames: usize, patience: u64) {
        let end = now_ns() + patience;
        while self.frames.len() < frames && now_ns() < end {
            self.poll(&mut |_| {});
            self.waits.sleep(now_ns() + 200_000);
        }
    }

    /// So many frames of an engine, at its rate.
    pub fn play(&mut self, player: &mut Player, frames: u32) {
        for _ in 0..frames {
            self.due += player.period;
            let now = self.waits.until(self.due as u64) as f64;
            // late by more than a frame: what was missed is not made up for
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

    /// A force frame as it is, stamped with the time.
    pub fn send(&mut self, frame: &mut ForceFrame) {
        frame.t_host_ns = now_ns();
        self.lines.send(0, frame);
        self.sent.push(*frame);
    }

    /// Mode and cause of the last force.
    pub fn mode(&self) -> (Mode, Cause) {
        self.sent.last().map_or((Mode::Off, Cause::Disarmed), |f| (Mode::read(f.mode), Cause::read(f.cause)))
    }

    /// An engine whose scene has the device where it is now.
    pub fn player(&self, profile: &Profile) -> Result<Player, Failure> {
        let x = self.frames.last().map_or([0.0; DOF], |f| f.pos);
        let scene = Arc::new(scene(&self.name, profile.dof as usize, &x)?);
        let setup = Setup {
            device: self.name.clone(),
            profile: profile.clone(),
            calibration: self.calibration.clone(),
            gains: Vec::new(),
        };
        let port = Port::new(&scene, setup);
        let (controls, period) = (scene.controls(), 1e9 * f64::from(scene.ratio) / scene.rate);
        let own = Options { session: session(), ..Options::default() };
        Ok(Player { engine: Engine::new(scene, vec![port], own), controls, period })
    }
}

impl Player {
    /// Forces on, or off.
    pub fn order(&mut self, order: Order) {
        self.engine.act(Act::Order(None, order));
    }

    /// Pulls at each degree of freedom with so much \[N\].
    pub fn pull(&mut self, force: f64) -> Result<(), Failure> {
        let patch = self.controls.set("pull", force / REACH).map_err(|e| Failure::Failed(e.to_string()))?;
        self.engine.act(Act::Set(Box::new(Change { params: Vec::new(), patches: vec![patch] })));
        Ok(())
    }
}

/// A spring that pulls at each degree of freedom, as much as the parameter `pull` says.
fn scene(name: &str, n: usize, x: &[f64; DOF]) -> Result<Scene, Failure> {
    let mut text =
        String::from("[param]\npull = { value = 0, unit = \"N/m\", live = true, min = 0, max = 100 }\n[TGR]\n");
    for (k, x) in x.iter().enumerate().take(n) {
        let _ = writeln!(text, "d{k} = {{ device = \"{name}\", dof = {k}, x = {x:e} }}");
    }
    text += "[SOL]\n";
    for (k, x) in x.iter().enumerate().take(n) {
        let _ = writeln!(text, "far{k} = {{ x = {:e} }}", x + REACH);
    }
    text += "[RES]\n";
    for k in 0..n {
        let _ = writeln!(text, "s{k} = {{ between = [\"d{k}\", \"far{k}\"], k = \"pull\", l0 = 0 }}");
    }
    let (model, found) = read::read(&text, "conformance", &catalog());
    ca_core::load::finish(&model, found, &catalog(), &Compile::default())
        .map_err(|d| Failure::Failed(format!("the scene of this test: {:?}", d.list)))
}
