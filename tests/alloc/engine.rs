//! Checks that the engine and its guard never allocate: arming, faults, reload, changes, frames of any kind.

use super::calls;
use ca_compile::{Options as Compile, compile};
use ca_core::{Scene, State};
use ca_haptic::calibration::{Axis, Calibration};
use ca_haptic::engine::{Change, Engine, EngineCommand, Options, Port, Retired, Setup};
use ca_haptic::frame::{CAUSES, DeviceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_model::read;
use std::sync::Arc;

const TEXT: &str = r#"
[param]
k = { value = 500, unit = "N/m", live = true, min = 100, max = 1000 }
[TGR]
x = { device = "hand", dof = 0 }
y = { device = "hand", dof = 1 }
[SOL]
wall = {}
[CEL]
bar = { m = "2 g", f = "220 Hz" }
[RES]
a = { between = ["x", "bar"], k = "k" }
b = { between = ["y", "wall"], k = "k" }
[SOX]
out = { from = "bar", gain = 100 }
"#;

/// An engine with a device that uses every stage of the guard. `patient` sets watchdog times for a stalled machine.
pub(super) fn engine(energy: bool, patient: bool) -> (Engine, State, Change) {
    let catalog = ca_tests::catalog();
    let (model, _) = read::read(TEXT, "hand.ca.toml", &catalog);
    let scene: Scene = compile(&model, &catalog, &Compile { energy, ..Compile::default() }).expect("it compiles").scene;
    let mut profile = Profile::shipped("tgr12").expect("shipped");
    (profile.dof, profile.axes, profile.continuous) = (2, 2, Some(3.0));
    (profile.guard.clear_time, profile.guard.ramp) = (0.01, 0.02);
    if patient {
        (profile.guard.hold, profile.guard.zero) = (Some(0.05), 0.09);
    }
    let calibration = Calibration { axis: vec![Axis::default(); 2], ..Calibration::default() };
    let mut controls = scene.controls();
    let patch = controls.set("k", 600.0).expect("live");
    let change = Change { params: vec![(0, 600.0)], patches: vec![patch] };
    let setup = Setup { device: "hand".into(), profile, calibration, gains: vec![] };
    let scene = Arc::new(scene);
    let port = Port::new(&scene, setup);
    assert_eq!(port.chain.names().len(), 8);
    let state = scene.state();
    (Engine::new(scene, vec![port], Options::default()), state, change)
}

#[test]
fn an_engine_allocates_nothing() {
    for energy in [false, true] {
        let (mut e, state, change) = engine(energy, false);
        let mut boxes: Vec<Box<State>> = (0..4).map(|_| Box::new(state.clone())).collect();
        let mut changes: Vec<Box<Change>> = (0..8).map(|_| Box::new(change.clone())).collect();
        let mut retired: Vec<Retired> = Vec::with_capacity(16);
        let mut next = DeviceFrame::new("hand", 2);
        next.session = 1;
        let mut rng = 0x9e37_79b9_7f4a_7c15_u64;
        let mut modes = [0; 5];
        let mut diverged = 0;
        let n = calls(|| {
            for n in 0..12_000_u32 {
                let t = n % 3000;
                if t % 500 == 0 {
                    e.command(EngineCommand::Order(None, Order::Arm));
                }
                if t == 700 {
                    if let Some(c) = changes.pop() {
                        retired.extend(e.command(EngineCommand::Set(c)));
                    }
                }
                if t % 500 == 450 {
                    let why = CAUSES[(n / 500) as usize % CAUSES.len()];
                    e.command(EngineCommand::Order(Some(0), if t < 500 { Order::Disarm } else { Order::Trip(why) }));
                }
                // makes the model diverge; it is reloaded below
                if t == 2800 {
                    let last = e.state.x.len() - 1;
                    e.state.x[last] = if n < 6000 { 1e9 } else { f64::NAN };
                }
                if t == 2990 {
                    if let Some(s) = boxes.pop() {
                        retired.extend(e.command(EngineCommand::Reload(s)));
                    }
                }
                rng ^= rng << 13;
                rng ^= rng >> 7;
                rng ^= rng << 17;
                next.seq += 1;
                next.t_device_ns += 333_333;
                // the positions press, then jump, then stop arriving
                let phase = f64::from(t % 500) / 500.0;
                next.pos[0] = if t > 1000 { 0.01 * (0.25 - (phase - 0.75).abs()).max(0.0) } else { 0.0 };
                next.pos[1] = if t > 2000 { next.pos[0] * 20.0 } else { next.pos[0] };
                if !(1600..1650).contains(&t) {
                    let mut f = next;
                    e.take(0, &mut f);
                }
                if rng.is_multiple_of(100) {
                    let mut f = next;
                    match rng % 7 {
                        0 => f.pos[0] = f64::NAN,
                        1 => f.layout = rng,
                        2 => f.seq = 0,
                        3 => f.n = rng as u16,
                        4 => f.status = rng as u32,
                        5 => f.cause = rng as u16,
                        _ => f.pos[1] = f64::INFINITY,
                    }
                    f.seq = f.seq.saturating_add(rng % 2);
                    e.take(0, &mut f);
                }
                for out in e.answer() {
                    modes[Mode::read(out.mode) as usize] += 1;
                }
                e.finish();
                diverged += u32::from(e.has_diverged());
            }
        });
        assert_eq!(n, 0, "energy {energy}");
        assert!(modes.iter().all(|n| *n > 20), "off, ramp, on, damp, fault: {modes:?}");
        assert!(
            diverged > 100 && !e.has_diverged() && retired.len() == 8,
            "{diverged} diverged, {} given back",
            retired.len()
        );
        let c = e.counts;
        assert!(c.faults > 3 && c.dropped > 50 && c.stale > 40 && c.refused == 0, "{c:?}");
    }
}
