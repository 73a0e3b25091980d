//! A performance without a server: an engine, scripted devices that send real frames, and its take.

use ca_compile::Options;
use ca_core::{Catalog, State};
use ca_haptic::engine::{self, Change, Engine, EngineCommand, Port, Setup};
use ca_haptic::equivalence::Gains;
use ca_haptic::frame::DeviceFrame;
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::record::Record;
use ca_haptic::take::{Finished, Header, Rt, TakeWriter};
use std::path::Path;
use std::sync::Arc;

/// Two devices, a live parameter, contacts, two channels, an energy ledger.
pub const DUO: &str = r#"
# Two hands on one bar.
[model]
title = "Duo"
[param]
stiff = { value = 400, unit = "N/m", live = true, min = 100, max = 2000 }
[TGR]
key = { device = "left", dof = 0, x = "-5 mm" }
pad = { device = "right", dof = 1, x = "0 mm" }
[CEL]
bar = { m = "5 g", f = "220 Hz", t60 = "1 s" }
[RES]
shank = { between = ["key", "bar"], k = "stiff" }
[BUT]
hit = { between = ["pad", "bar"], k = "2 kN/m", z = "0.1 N s/m" }
[SOX]
out = { from = "bar", gain = 100 }
other = { from = "pad", gain = 10 }
"#;

pub fn catalog() -> Catalog {
    ca_lab::catalog()
}

pub struct Performer {
    pub engine: Engine,
    take: Option<TakeWriter>,
    /// Sound so far, interleaved.
    pub sound: Vec<f64>,
    /// Position \[m\] of a device and degree of freedom as a function of time.
    script: fn(usize, usize, f64) -> f64,
    seq: u64,
    controls: ca_core::Controls,
}

/// Slow and fast motion within the limits of a hand.
pub fn swing(device: usize, dof: usize, t: f64) -> f64 {
    let f = 1.5 + dof as f64 + 0.7 * device as f64;
    -0.002 + 0.003 * (std::f64::consts::TAU * f * t).sin()
}

impl Performer {
    /// Prepares to play `text` with every device it names.
    pub fn new(text: &str, path: &Path) -> Performer {
        let changes: &[_] = if text.contains("bar") { &[("bar.f", "231 Hz")] } else { &[] };
        Performer::of(text, changes, true, path)
    }

    /// Prepares to play `text` with changes, with or without the energy ledger.
    pub fn of(text: &str, changes: &[(&str, &str)], energy: bool, path: &Path) -> Performer {
        let options = Options { energy, ..Options::default() };
        let (mut model, found) = ca_model::read::read(text, "some/where/duo.ca.toml", &catalog());
        let changes: Vec<_> = changes.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        for (name, value) in &changes {
            assert!(model.set(name, value));
        }
        let scene = ca_compile::load::finish(&model, found, &catalog(), &options).expect("it compiles");
        let mut names: Vec<String> = scene.inputs.iter().filter_map(|i| Some(i.device.as_ref()?.0.clone())).collect();
        names.dedup();
        let mut profile = Profile::shipped("tgr12").expect("shipped");
        profile.guard.ramp = 0.05;
        profile.guard.clear_time = 0.01;
        profile.guard.clear = 0.5;
        let setup = |(k, device): (usize, &String)| Setup {
            device: device.clone(),
            profile: Profile { dof: 2 + k as u32, ..profile.clone() },
            calibration: ca_haptic::calibration::Calibration::default(),
            gains: vec![Gains { alpha: 1.0 / 1.3, beta: 1.1 }],
        };
        let setups: Vec<Setup> = names.iter().enumerate().map(setup).collect();
        let own = engine::Options { session: 0xfeed_face_dead_beef, ..engine::Options::default() };
        let header = Header::new(&model, changes, options, &scene, setups.clone(), own);
        let take = TakeWriter::create(path, &header, &scene).expect("a take");
        let scene = Arc::new(scene.scene);
        let ports = setups.into_iter().map(|s| Port::new(&scene, s)).collect();
        let controls = scene.controls();
        let engine = Engine::new(scene, ports, own);
        Performer { engine, take: Some(take), sound: Vec::new(), script: swing, seq: 0, controls }
    }

    fn note(&mut self, record: &Record) {
        self.take.as_mut().expect("not finished").record(record).expect("written");
    }

    /// Executes and records a command between frames.
    pub fn command(&mut self, act: EngineCommand) {
        let tick = self.engine.due();
        if let EngineCommand::Order(port, order) = act {
            self.engine.command(act);
            self.note(&Record::Order { tick, port, order });
        } else if let Some(retired) = self.engine.command(act) {
            self.note(&Record::Retired { tick, retired });
        }
    }

    pub fn set(&mut self, name: &str, value: f64) {
        let p = self.controls.params().iter().position(|p| p.name == name).expect("a live parameter") as u32;
        let patch = self.controls.set(name, value).expect("in range");
        self.command(EngineCommand::Set(Box::new(Change { params: vec![(p, value)], patches: vec![patch] })));
    }

    /// Resets the scene to its state at load.
    pub fn reload(&mut self) {
        let fresh: State = self.engine.scene.state();
        self.controls = self.engine.scene.controls();
        self.command(EngineCommand::Reload(Box::new(fresh)));
    }

    pub fn frame(&mut self) {
        self.seq += 1;
        let due = self.engine.due();
        let ratio = u64::from(self.engine.scene.rates.ratio);
        let t = (due.saturating_sub(1) / ratio) as f64 * self.engine.scene.rates.sample_dt * ratio as f64;
        for k in 0..self.engine.ports.len() {
            let (name, n) = (self.engine.ports[k].name.clone(), self.engine.ports[k].profile.dof as usize);
            let mut frame = DeviceFrame::new(&name, n);
            (frame.session, frame.seq, frame.t_device_ns) = (9, self.seq, (t * 1e9) as u64);
            for dof in 0..n {
                frame.pos[dof] = (self.script)(k, dof, t);
            }
            // occasionally sends an invalid frame or none
            match self.seq % 997 {
                500 => frame.pos[0] = f64::NAN,
                501 => frame.seq -= 2,
                502 => continue,
                _ => {}
            }
            self.engine.take(k, &mut frame);
            self.note(&Record::Device { port: k as u32, frame });
        }
        let forces: Vec<_> = self.engine.answer().copied().collect();
        for (k, frame) in forces.into_iter().enumerate() {
            self.note(&Record::Force { port: k as u32, frame });
        }
        let x = self.engine.state.x.clone();
        let heard = self.engine.finish().to_vec();
        self.sound.extend_from_slice(&heard);
        let rt = Rt { tick: due, frames: self.engine.counts.frames, late_p50: 1.5, ..Rt::default() };
        let (view, second) = (self.seq % 50 == 1, self.seq.is_multiple_of(300));
        let take = self.take.as_mut().expect("not finished");
        take.sound(due, &heard).expect("written");
        if view {
            take.view(due, &x).expect("written");
        }
        if second {
            take.stats(&rt).expect("written");
        }
        if second {
            let (tick, bits) = (self.engine.due(), self.engine.state.bits());
            self.note(&Record::Hash { tick, bits });
            if let Some(ledger) = &self.engine.state.ledger {
                let balance = ledger.balance();
                self.note(&Record::Energy { tick, balance });
            }
        }
    }

    pub fn frames(&mut self, n: u64) {
        (0..n).for_each(|_| self.frame());
    }

    /// Plays a performance with every kind of event in `n` frames, at least 1500.
    pub fn play(&mut self, n: u64) {
        self.frames(10);
        self.command(EngineCommand::Order(None, Order::Arm));
        self.frames(400);
        let has_param = !self.controls.params().is_empty();
        if has_param {
            self.set("stiff", 731.0);
            self.frames(1);
            self.set("stiff", 1000.0 / 3.0);
        }
        self.frames(300);
        self.command(EngineCommand::Order(Some(0), Order::Trip(ca_haptic::frame::Cause::Software)));
        self.frames(200);
        self.command(EngineCommand::Order(Some(0), Order::Arm));
        self.frames(300);
        if has_param {
            self.reload();
            self.command(EngineCommand::Order(None, Order::Arm));
        }
        let more = n.saturating_sub(self.seq);
        self.frames(more);
    }

    pub fn finish(&mut self) -> Finished {
        self.take.take().expect("not finished").finish([0; 3]).expect("finished")
    }
}

pub fn duo(path: &Path, frames: u64) -> Performer {
    let mut p = Performer::new(DUO, path);
    p.play(frames);
    p.finish();
    p
}

pub fn tgr12(path: &Path) {
    let mut p = Performer::new(&DUO.replace("\"left\"", "\"tgr12\""), path);
    p.play(1500);
    p.finish();
}
