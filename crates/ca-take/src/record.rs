//! Records a take without a device: a gesture moves the simulated hands.
//!
//! The real engine with its guard processes frames as a device sends them. So the take replays to the bit and contains
//! the forces that a hand would have received. As in `ca serve`, built-in gestures of ports other than devices are not
//! played.

use crate::{Original, devices, dofs};
use ca_compile::Options;
use ca_core::{Controls, InputRole, Scene};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{self, Change, Engine, EngineCommand, Port, Setup};
use ca_haptic::equivalence;
use ca_haptic::frame::{DOF, DeviceFrame};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::record::Record;
use ca_haptic::take::{Finished, Header, TakeWriter};
use ca_io::gesture::{Gesture, Track};
use ca_io::perform::{Driven, Performance};
use ca_lab::load::Loaded;
use ca_lab::{Failure, play};
use std::path::Path;
use std::sync::Arc;

/// Pictures of the scene per second.
const VIEWS: f64 = 60.0;

/// Options of a recording.
#[derive(Clone, Debug, Default)]
pub struct RecordOptions {
    /// Length \[s\]; if `None`, the default length of a performance.
    pub seconds: Option<f64>,
    /// Sound rate \[Hz\]; if `None`, the rate of the model.
    pub rate: Option<f64>,
    /// Records the energy ledger.
    pub energy: bool,
    /// Arms the forces as soon as the guard allows it.
    pub forces: bool,
}

/// An engine whose devices are moved by a gesture.
struct Stage<'a> {
    hands: Performance<'a>,
    engine: Engine,
    controls: Controls,
    take: TakeWriter,
    /// Sequence number of the next device frame.
    seq: u64,
}

/// Plays a model and writes the take to `path`. Calls `goes_on` with the samples done and the total.
///
/// # Errors
/// Returns [`Failure::Usage`] if the gesture drives something other than a device or a live parameter,
/// [`Failure::Found`] if the model has errors, and [`Failure::Failed`] if the file exists or cannot be written. Returns
/// [`Failure::Stopped`] if `goes_on` returns false. The incomplete file is removed on failure.
pub fn record(
    loaded: &Loaded,
    gesture: Option<&Gesture>,
    ask: &RecordOptions,
    path: &Path,
    goes_on: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<Finished, Failure> {
    let Original { played: loaded, changes, .. } = &Original::of(loaded)?;
    let options = Options { rate: ask.rate, energy: ask.energy, clouds: loaded.clouds.clone(), ..Options::default() };
    let scene = Arc::new(loaded.compile(&options)?.scene);
    let mut hands = Performance::new(&scene, gesture)?;
    let frames = play::frames(&scene, play::seconds(&hands, ask.seconds));
    let given = gesture.map_or(&[][..], Gesture::tracks).iter().map(Track::name);
    let port = |name: &&str| scene.inputs.iter().any(|i| i.name == **name && i.role != InputRole::Device);
    if let Some(name) = given.into_iter().find(port) {
        let what = format!("`{name}` is not a device port");
        return Err(Failure::Usage(format!("{what}; a take records only devices and live parameters")));
    }
    let far = hands.hands(0).find_map(|(what, _)| {
        let Driven::Device(input) = what else { return None };
        let input = &scene.inputs[input];
        input.device.as_ref().filter(|d| d.1 as usize >= DOF).map(|d| (&input.name, d.1))
    });
    if let Some((name, dof)) = far {
        let what = format!("`{name}` uses degree of freedom {dof}");
        return Err(Failure::Usage(format!("{what}; a device in a take has at most {DOF}, counted from 0")));
    }
    let setups: Vec<Setup> = devices(&scene).iter().map(|name| setup(&scene, name)).collect();
    // no other session takes part in the recording
    let own = engine::Options { session: 1, ..engine::Options::default() };
    let header = Header::new(&loaded.model, changes.clone(), options, &scene, setups.clone(), own);
    let take = TakeWriter::create(path, &header, &scene)?;
    let ports = setups.into_iter().map(|s| Port::new(&scene, s)).collect();
    let (controls, engine) = (scene.controls(), Engine::new(scene.clone(), ports, own));
    let mut stage = Stage { hands, engine, controls, take, seq: 0 };
    let done = stage.play(frames, ask.forces, goes_on);
    let done = done.and_then(|()| Ok(stage.take.finish([0; 3])?));
    if done.is_err() {
        let _ = std::fs::remove_file(path);
    }
    done
}

/// Sets up the device `name` with its bundled profile, or with the `unknown` profile if there is none.
fn setup(scene: &Scene, name: &str) -> Setup {
    let mut profile = Profile::shipped(name).or_else(|| Profile::shipped("unknown")).unwrap_or_else(|| unreachable!());
    profile.dof = profile.dof.max(dofs(scene, name));
    let gains = equivalence::gains(scene, name);
    Setup { device: name.into(), profile, calibration: Calibration::default(), gains }
}

impl Stage<'_> {
    fn play(&mut self, frames: u64, forces: bool, goes_on: &mut dyn FnMut(u64, u64) -> bool) -> Result<(), Failure> {
        let scene = self.engine.scene.clone();
        let every = |rate: f64| (scene.rate / rate / f64::from(scene.rates.ratio)).round().max(1.0) as u64;
        let (second, view) = (every(1.0), every(VIEWS));
        if forces {
            self.order(Order::Arm)?;
        }
        while self.engine.due() < frames {
            self.frame(self.seq.is_multiple_of(view), self.seq.is_multiple_of(second))?;
            if !goes_on(self.engine.due().min(frames), frames) {
                return Err(Failure::Stopped);
            }
        }
        Ok(())
    }

    fn order(&mut self, order: Order) -> Result<(), Failure> {
        let tick = self.engine.due();
        self.engine.command(EngineCommand::Order(None, order));
        Ok(self.take.record(&Record::Order { tick, port: None, order })?)
    }

    fn frame(&mut self, view: bool, second: bool) -> Result<(), Failure> {
        let due = self.engine.due();
        let mut sent: Vec<DeviceFrame> = Vec::new();
        for p in &self.engine.ports {
            let mut frame = DeviceFrame::new(&p.name, p.profile.dof as usize);
            let ns = (due as f64 * self.engine.scene.rates.sample_dt * 1e9) as u64;
            (frame.session, frame.seq, frame.t_device_ns) = (1, self.seq + 1, ns);
            // degrees of freedom without a gesture stay at the rest position of the scene
            for l in &p.links {
                frame.pos[l.dof] = self.engine.scene.inputs[l.input].rest / l.gains.alpha;
            }
            sent.push(frame);
        }
        let mut moved: Vec<(usize, usize, f64)> = Vec::new();
        let mut changes = Vec::new();
        for (what, value) in self.hands.hands(due) {
            match what {
                Driven::Device(input) => {
                    for (k, (p, frame)) in self.engine.ports.iter().zip(&mut sent).enumerate() {
                        for l in p.links.iter().filter(|l| l.input == input) {
                            let at = value / l.gains.alpha;
                            if moved.iter().any(|m| (m.0, m.1) == (k, l.dof) && m.2 != at) {
                                let what = format!("the gesture moves device `{}`", p.name);
                                let why = format!(
                                    "{what} to two positions at degree of freedom {}; give both ports the same values",
                                    l.dof
                                );
                                return Err(Failure::Usage(why));
                            }
                            moved.push((k, l.dof, at));
                            frame.pos[l.dof] = at;
                        }
                    }
                }
                Driven::Param(name) => changes.push((name.to_owned(), value)),
                Driven::Port(_) => {}
            }
        }
        for (name, value) in changes {
            self.set(&name, value)?;
        }
        self.seq += 1;
        for (k, mut frame) in sent.into_iter().enumerate() {
            self.engine.take(k, &mut frame);
            self.take.record(&Record::Device { port: k as u32, frame })?;
        }
        for (port, frame) in (0..).zip(self.engine.answer()) {
            self.take.record(&Record::Force { port, frame: *frame })?;
        }
        if view {
            self.take.view(due, &self.engine.state.x)?;
        }
        self.take.sound(due, self.engine.finish())?;
        if second {
            let (tick, bits) = (self.engine.due(), self.engine.state.bits());
            self.take.record(&Record::Hash { tick, bits })?;
            if let Some(ledger) = &self.engine.state.ledger {
                self.take.record(&Record::Energy { tick, balance: ledger.balance() })?;
            }
        }
        Ok(())
    }

    /// Sets a live parameter if its value differs, clamped to its range like a signal.
    fn set(&mut self, name: &str, value: f64) -> Result<(), Failure> {
        let Some(p) = self.controls.params().iter().position(|p| p.name == name) else { return Ok(()) };
        let param = &self.controls.params()[p];
        let value = value.max(param.min).min(param.max);
        if param.value == value {
            return Ok(());
        }
        let patch = self.controls.set(name, value).map_err(|e| Failure::Failed(e.to_string()))?;
        let tick = self.engine.due();
        let change = Change { params: vec![(p as u32, value)], patches: vec![patch] };
        if let Some(retired) = self.engine.command(EngineCommand::Set(Box::new(change))) {
            self.take.record(&Record::Retired { tick, retired })?;
        }
        Ok(())
    }
}
