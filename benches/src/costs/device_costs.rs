//! Costs of a device: the stages of the guard one by one, the chain, a whole device in an engine, the engine around a
//! scene, and the records.
//!
//! There is one device of twelve keys, with all stages, forces on, and a slow motion within all limits: the cost of
//! every frame while nothing is wrong.

use super::{CostRow, Played, Player, Run, Without};
use crate::string;
use ca_core::{Scene, tick};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{Engine, EngineCommand, Options, Port, Setup};
use ca_haptic::frame::{DOF, DeviceFrame, Mode};
use ca_haptic::guard::input::InputValidator;
use ca_haptic::guard::{Chain, GuardFrame, Order, Stage};
use ca_haptic::guard::{finite, gate, oscillation, passivity, saturation, slew, thermal, workspace};
use ca_haptic::profile::Profile;
use ca_haptic::serve::{Clock, GatewayEnds, Live, RecordIntervals, Shared, rings};
use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Length of a gesture frame \[s\].
const FRAME_DT: f64 = 1.0 / 3000.0;
const KEYS: usize = 12;

/// Setup that is run frame by frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rig {
    /// A hand alone.
    Frame,
    /// Frames of a device alone.
    Silent,
    /// A guard stage by name.
    Stage(&'static str),
    /// The checks of device frames.
    InputValidator,
    /// The whole chain of the guard.
    Chain,
    /// A string of 100 without an engine, frame by frame.
    Ticks,
    /// The same in an engine.
    Engine,
    /// Twelve keys on springs in an engine, without their device.
    Keys,
    /// The same with their device.
    Device,
    /// The same with the rings and records of the real-time thread.
    Live,
}

fn profile() -> Profile {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    p.continuous = Some(3.0);
    // switches forces on immediately
    (p.guard.clear_time, p.guard.ramp, p.guard.approach) = (FRAME_DT, FRAME_DT, FRAME_DT);
    p
}

/// Returns a profile without optional stages.
fn bare() -> Profile {
    let mut p = profile();
    p.continuous = None;
    (p.guard.passivity, p.guard.oscillation, p.guard.edge) = (false, false, 0.0);
    p
}

fn keys() -> Scene {
    let mut text = String::from("[SOL]\nwall = {}\n[TGR]\n");
    for i in 0..KEYS {
        let _ = writeln!(text, "k{i} = {{ device = \"keys\", dof = {i} }}");
    }
    let names: Vec<String> = (0..KEYS).map(|i| format!("\"k{i}\"")).collect();
    let _ = writeln!(text, "[RES]\nspring = {{ between = [\"wall\", [{}]], k = 500 }}", names.join(", "));
    Played::new(text + "[SOX]\nout = { from = \"k0\" }\n").scene()
}

fn engine(scene: Scene, device: Option<Profile>) -> Engine {
    let scene = Arc::new(scene);
    let setup = |profile| Setup { device: "keys".into(), profile, calibration: Calibration::default(), gains: vec![] };
    let ports = device.map(|profile| Port::new(&scene, setup(profile))).into_iter().collect();
    Engine::new(scene, ports, Options::default())
}

fn stage(name: &str) -> Box<dyn Stage> {
    fn boxed<S: Stage + 'static>(s: Option<S>) -> Option<Box<dyn Stage>> {
        s.map(|s| Box::new(s) as Box<dyn Stage>)
    }
    let p = profile();
    let mut gate = gate::Gate::new(&p, FRAME_DT);
    gate.order(Order::Arm);
    let all = [
        boxed(Some(finite::Finite)),
        boxed(workspace::Workspace::new(&p)),
        boxed(Some(saturation::Saturation::new(&p))),
        boxed(passivity::Passivity::new(&p, FRAME_DT)),
        boxed(oscillation::Oscillation::new(&p, FRAME_DT)),
        boxed(thermal::Thermal::new(&p, FRAME_DT)),
        boxed(Some(gate)),
        boxed(Some(slew::Slew::new(&p, FRAME_DT))),
    ];
    all.into_iter().flatten().find(|s| s.name() == name).unwrap_or_else(|| panic!("no stage `{name}`"))
}

/// Frames of a hand that moves back and forth by a millimetre.
struct Frames(DeviceFrame);

impl Frames {
    fn new() -> Frames {
        let mut frame = DeviceFrame::new("keys", KEYS);
        frame.session = 7;
        Frames(frame)
    }

    fn next(&mut self) -> DeviceFrame {
        let f = &mut self.0;
        f.seq += 1;
        f.t_device_ns += 333_333;
        let at = (f.seq % 600) as f64 / 600.0 - 0.5;
        f.pos[..KEYS].fill(4e-3 * (at.abs() - 0.25));
        *f
    }
}

/// Returns a hand while forces are on.
fn moving() -> GuardFrame {
    let mut hand = GuardFrame::new(KEYS, FRAME_DT);
    (hand.is_new, hand.age, hand.calibrated, hand.arrived, hand.mode) = (true, 0, true, u32::MAX, Mode::On);
    hand.moved[..KEYS].fill(1e-5);
    hand.v[..KEYS].fill(0.03);
    hand.sent[..KEYS].fill(0.3);
    hand
}

impl Rig {
    /// Starts the setup, with forces on.
    pub(super) fn player(self) -> Player {
        match self {
            Rig::Frame => looked_at(None),
            Rig::Stage(name) => looked_at(Some(stage(name))),
            Rig::Silent => said(None),
            Rig::InputValidator => said(Some(InputValidator::new(&profile(), FRAME_DT))),
            Rig::Chain => {
                let mut chain = Chain::new(&profile(), FRAME_DT);
                chain.order(Order::Arm);
                let mut hand = moving();
                Box::new(move |n| {
                    for _ in 0..n {
                        hand.force = [0.3; DOF];
                        chain.pass(&mut hand);
                        hand.frame += 1;
                        black_box(&mut hand);
                    }
                    assert!(hand.mode == Mode::On, "forces are off");
                })
            }
            Rig::Ticks => {
                let scene = Played::new(string(100)).scene();
                let mut state = scene.state();
                Box::new(move |n| (0..n * scene.rates.ratio).for_each(|_| tick(&scene, &mut state)))
            }
            Rig::Engine => engine_alone(Played::new(string(100)).scene()),
            Rig::Keys => engine_alone(keys()),
            Rig::Device => {
                let (mut engine, mut frames) = armed();
                Box::new(move |n| {
                    (0..n).for_each(|_| frame(&mut engine, &mut frames));
                    assert!(engine.ports[0].hand.mode == Mode::On && engine.counts.dropped == 0);
                })
            }
            Rig::Live => live(),
        }
    }
}

/// Runs a hand with one stage, or none.
fn looked_at(mut stage: Option<Box<dyn Stage>>) -> Player {
    let mut hand = moving();
    Box::new(move |n| {
        for _ in 0..n {
            hand.force = [0.3; DOF];
            if let Some(stage) = &mut stage {
                stage.pass(&mut hand);
                stage.sent(&hand);
            }
            black_box(&mut hand);
        }
        assert!(hand.mode == Mode::On, "forces are off");
    })
}

/// Runs frames of a device, with checks or without.
fn said(mut validator: Option<InputValidator>) -> Player {
    let (mut hand, mut frames) = (moving(), Frames::new());
    Box::new(move |n| {
        for _ in 0..n {
            let frame = frames.next();
            if let Some(validator) = &mut validator {
                validator.take(&frame, &mut hand);
                validator.update(&mut hand);
            }
            hand.frame += 1;
            black_box((&mut hand, &frame));
        }
        assert!(validator.as_ref().is_none_or(|i| i.dropped == 0));
    })
}

fn engine_alone(scene: Scene) -> Player {
    let mut engine = engine(scene, None);
    Box::new(move |n| {
        for _ in 0..n {
            assert!(engine.answer().next().is_none());
            black_box(engine.finish());
        }
    })
}

fn frame(engine: &mut Engine, frames: &mut Frames) {
    let mut frame = frames.next();
    engine.take(0, &mut frame);
    engine.answer().for_each(|out| {
        black_box(out);
    });
    black_box(engine.finish());
}

/// Returns the engine of the keys and the frames of its device, with forces on.
fn armed() -> (Engine, Frames) {
    let (mut engine, mut frames) = (engine(keys(), Some(profile())), Frames::new());
    engine.command(EngineCommand::Order(None, Order::Arm));
    let on = (0..3000).any(|_| {
        frame(&mut engine, &mut frames);
        engine.ports[0].hand.mode == Mode::On
    });
    assert!(on, "forces stay off");
    (engine, frames)
}

/// Runs the engine in its loop, with both ends of its rings.
fn live() -> Player {
    let (engine, mut frames) = armed();
    let (ends, GatewayEnds { frames: mut said, forces: mut given }, mut desk) = rings(&engine.scene, 1, 0);
    let shared = Arc::new(Shared::default());
    let mut live = Live::new(engine, ends, shared.clone(), Clock::Device { patience: 0 }, RecordIntervals::default());
    let mut player: Player = Box::new(move |n| {
        for _ in 0..n {
            assert!(said.push((0, frames.next())).is_ok(), "no room");
            live.frame();
            black_box(given.pop().is_ok());
            while let Ok(record) = desk.records.pop() {
                black_box(&record);
            }
            if let Ok(chunk) = desk.sound.read_chunk(desk.sound.slots()) {
                chunk.commit_all();
            }
        }
        assert!(shared.lost_records.load(Relaxed) + shared.lost_forces.load(Relaxed) == 0, "records are lost");
    });
    // once around all rings, to touch all of their memory
    player(10_000);
    player
}

/// Checks that a chain has the stage (or, for `None`, more stages) only with a device that asks for it. With `asked`,
/// the comparison is with a device that does not ask, otherwise with no device.
pub(super) fn nothing(stage: Option<&str>, asked: bool) -> Result<(), String> {
    let names = |profile: Option<Profile>| -> Vec<&str> {
        engine(keys(), profile).ports.iter().flat_map(|p| p.chain.names()).collect()
    };
    let (without, with) = (names(asked.then(bare)), names(Some(profile())));
    match stage {
        Some(name) if without.contains(&name) || !with.contains(&name) => {
            Err(format!("`{name}` is in {without:?}, or not in {with:?}"))
        }
        None if without.len() >= with.len() => Err(format!("{without:?} is not less than {with:?}")),
        _ => Ok(()),
    }
}

pub(super) fn rows() -> Vec<CostRow> {
    let row = |thing, with, plain, used, without| CostRow {
        thing,
        with,
        modules: 1.0,
        plain: Run::Hand(plain),
        used: Run::Hand(used),
        without,
    };
    let stage =
        |thing, with, name, asked| row(thing, with, Rig::Frame, Rig::Stage(name), Without::Device(Some(name), asked));
    let device = || Without::Device(None, false);
    vec![
        row("H10: what a device says", "frames in order, speeds", Rig::Silent, Rig::InputValidator, device()),
        stage("H1: non-finite forces", "`finite`", "finite", false),
        stage("H11: the edge of the travel", "`workspace`", "workspace", true),
        stage("H2: the largest force", "`saturation`", "saturation", false),
        stage("H12: passivity", "`passivity`", "passivity", true),
        stage("H13: oscillation", "`oscillation`", "oscillation", true),
        stage("H4: heat", "`thermal`", "thermal", true),
        stage("H5, H6, H8, H9: arming and faults", "`gate`", "gate", false),
        stage("H3: the fastest force", "`slew`", "slew", false),
        row("the chain", "all stages, and the ledger of the hand", Rig::Frame, Rig::Chain, device()),
        row("H1 to H14: a device", "input, ports of the scene, chain, frame", Rig::Keys, Rig::Device, device()),
        row("records", "rings to gateway and desk, both ends", Rig::Device, Rig::Live, device()),
        row("H15, H16: an engine", "around a string of 100, without a device", Rig::Ticks, Rig::Engine, device()),
    ]
}
