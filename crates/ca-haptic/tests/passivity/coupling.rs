//! Walls beyond the limit of a device, softened by a virtual coupling.

use super::*;
use ca_haptic::coupling::{StiffnessLimits, needed};
use ca_haptic::engine::Swap;
use ca_haptic::frame::Cause;

/// Walls that were found to shake.
const FOUND: &str = include_str!("../../../../tests/data/wall-limit-cycle.json");

/// Stiffnesses of these walls \[N/m\].
fn found() -> Vec<f64> {
    let (_, list) = FOUND.split_once("\"stiffness_n_per_m\": [").expect("a list");
    let (list, _) = list.split_once(']').expect("its end");
    list.split(',').map(|k| k.trim().parse().expect("a number")).collect()
}

#[test]
fn walls_that_shook_are_still() {
    let mut worst = 0.0f64;
    for (gesture, delay) in [(3000, 1), (3000, 2), (1000, 1), (1000, 2)] {
        for k in found() {
            // the friction of the profile is right, or a third too high, which takes longer to settle
            for (friction, frames) in [(2.0, 6000), (1.4, 30_000)] {
                let (mut p, mut real) = (e02(true), e02(true));
                p.rate = f64::from(gesture);
                real.body.friction = friction;
                let scene = met(&wall_at(gesture, k, 0.0), &p);
                let mut l = Loop::new(&scene, &p, delay);
                l.device = Device::new(&real, Hand::NONE, Script::Push { force: 0.0 }, 0, 1);
                let (mut low, mut high) = (f64::MAX, f64::MIN);
                for n in 0..frames {
                    let (x, _) = l.step(-2.0);
                    if n >= frames - gesture / 2 {
                        (low, high) = (low.min(x), high.max(x));
                    }
                }
                println!("{gesture} Hz, {delay} frames, {k} N/m, {friction} N s/m: {:.3} um", 1e6 * (high - low));
                worst = worst.max(high - low);
            }
        }
    }
    assert!(worst < 5e-6, "{worst} m");
}

#[test]
fn what_is_felt_is_what_the_device_holds() {
    let p = e02(true);
    for k in [2.8e3, 5.5e3, 2e4, 1e6] {
        let text = wall(k, 0.0);
        let first = scene(&text);
        let held = StiffnessLimits::new(&first, &p);
        assert!(
            (held.passive - 3000.0).abs() < 1e-6
                && (held.unchanged - 2700.0).abs() < 1e-6
                && (held.softened_to - 1500.0).abs() < 1e-6,
            "{held:?}"
        );
        let soft = &needed(&first, &[setup(&first, &p)]).softened[0];
        assert!(
            soft.stiffness <= held.softened_to * (1.0 + 1e-9) && soft.stiffness > 0.7 * held.softened_to,
            "{k}: {soft:?}"
        );
        // a hand that presses slowly feels this stiffness
        let mut rig = Rig::new(&met(&text, &p), "key", p.clone());
        let on = (0..9000).find(|n| Mode::read(rig.go(Some(&[0.0]), *n).mode) == Mode::On).expect("forces on");
        let at = |n: u64| -1e-3 * (n as f64 / 3000.0).min(1.0);
        let f = (0..6000).map(|n| rig.go(Some(&[at(n)]), on + n)).last().expect("frames");
        let want = soft.stiffness * (1e-3 - GAP);
        assert!((f64::from(f.force[0]) / want - 1.0).abs() < 1e-3, "{k}: {} N, {want} N", f.force[0]);
        assert!(f.flags & flag::COUPLED != 0 && f.flags & flag::PASSIVITY == 0);
    }
}

/// A device at a third of the gesture rate holds each force three times as long, and gets it one device frame later.
#[test]
fn a_slower_device_gives_a_softened_key_less() {
    let p = Profile { rate: 1e3, ..e02(true) };
    let held = StiffnessLimits::new(&scene(&wall(8e3, 0.0)), &p);
    // 2 N s/m over two frames of 1 ms; softened, half of it over three
    assert!((held.passive - 1000.0).abs() < 1e-6 && (held.softened_to - 1000.0 / 3.0).abs() < 1e-6, "{held:?}");
}

/// The mass of a coupling grows with the wall: 20 g, a tenth of this device, at 11 MN/m.
#[test]
fn a_wall_that_no_coupling_fits_is_reported() {
    let p = e02(true);
    for (k, fits) in [(1e7, true), (1.2e7, false), (1e300, false)] {
        let first = scene(&wall(k, 0.0));
        let needed = needed(&first, &[setup(&first, &p)]);
        assert_eq!(
            (needed.softened.len(), needed.too_stiff.len()),
            if fits { (1, 0) } else { (0, 1) },
            "{k}: {needed:?}"
        );
    }
}

/// Sticking friction, on which a pushing hand stays still, and a damper of ten times the friction of the device.
#[test]
fn friction_that_sticks_and_strong_dampers_are_softened() {
    let p = e02(true);
    let text = |link: &str| {
        format!(
            "[TGR]\nkey = {{ device = \"key\", dof = 0 }}\n[SOL]\nground = {{}}\n[MAS]\nbody = {{ m = 1 }}\n\
             [RES]\nhold = {{ between = [\"ground\", \"body\"], k = 4e4 }}\n{link}"
        )
    };
    for (link, sticks) in [
        ("[BOW]\nrub = { between = [\"body\", \"key\"], f = 5, curve = \"coulomb\", method = \"set-valued\" }\n", true),
        ("[FRO]\ndamp = { between = [\"body\", \"key\"], z = 20 }\n", false),
    ] {
        let first = scene(&text(link));
        let soft = &needed(&first, &[setup(&first, &p)]).softened[0];
        assert!(soft.rigid && soft.stiffness <= 1500.0 * (1.0 + 1e-9), "{soft:?}");
        assert_eq!(first.certificate.keys[0].sticks, sticks);
        // a damper keeps yielding to a push
        if !sticks {
            continue;
        }
        let coupled = met(&text(link), &p);
        let mut l = Loop::new(&coupled, &p, 2);
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for n in 0..9000 {
            let (x, _) = l.step(-2.0);
            if n >= 7500 {
                (low, high) = (low.min(x), high.max(x));
            }
        }
        assert!(high - low < 5e-6, "{} m", high - low);
    }
    let weak = scene(&text("[FRO]\ndamp = { between = [\"body\", \"key\"], z = 1.7 }\n"));
    assert_eq!(needed(&weak, &[setup(&weak, &p)]).softened.len(), 0);
}

#[test]
fn a_key_that_is_held_has_no_trace_of_a_coupling() {
    let p = e02(true);
    for text in [wall(2.69e3, 0.0), wall_at(1000, 0.89e3, 0.0)] {
        let (plain, same) = (scene(&text), met(&text, &p));
        assert_eq!((plain.identity(), same.hand.couplings.len()), (same.identity(), 0));
    }
    let mut own = p.clone();
    own.guard.coupling = false;
    assert!(met(&wall(2e4, 0.0), &own).hand.couplings.is_empty(), "not wanted");
    let deaf = format!("[rate]\nfeedback = false\n{}", wall(2e4, 0.0));
    assert!(met(&deaf, &p).hand.couplings.is_empty(), "no force");
}

/// With the sensor steps and noise of devices, and all motions of the hand.
#[test]
fn a_softened_wall_gives_a_hand_nothing() {
    let mut cases = Vec::new();
    for profile in ["tgr12", "falcon", "omega3", "touch", "firefader", "unknown"] {
        for noise in [0.0, 1e-6, 5e-6] {
            for step in [1e-6, 1e-5, 6e-5] {
                for (delay, known) in [(1, true), (1, false), (2, true), (2, false)] {
                    for motion in MOVES {
                        for k in [5e2, 3e3, 5.5e3, 8e3, 2e4] {
                            for gesture in [1000, 3000] {
                                let coupling = true;
                                cases.push(Case { profile, noise, step, known, delay, motion, k, gesture, coupling });
                            }
                        }
                    }
                }
            }
        }
    }
    let each = if long_form("100 of 101 cases of the grid of couplings") { 1 } else { 101 };
    let (mut rms, mut paid, mut out, mut softened) = (0.0f64, 0.0f64, 0.0f64, 0);
    for case in cases.iter().step_by(each) {
        let seen = play(case, 10.0);
        softened += usize::from(seen.softened);
        println!("{case:?}: {:.4} N {:.2} uJ paid, {:.2} uJ out", seen.rms, 1e6 * seen.paid, 1e6 * seen.out);
        rms = rms.max(seen.rms);
        paid = paid.max(seen.paid);
        if matches!(case.motion, Move::Release | Move::Tremor) {
            out = out.max(seen.out);
        }
    }
    println!("{softened} softened: {rms:.4} N r.m.s., {:.1} uJ paid out, {:.1} uJ out", 1e6 * paid, 1e6 * out);
    assert!(softened > 20 && rms < 0.05 && paid < 1e-4 && out < 1e-4);
}

/// A hand far from the wall, with a 1 kHz device whose frames drift and jitter: nothing may push the hand.
#[test]
fn a_softened_key_in_free_air_does_not_push() {
    for (drift, jitter, limit) in [(0.0, 0.0, 1e-4), (3e-4, 0.0, 5e-3), (3e-4, 0.3e-3, 0.03), (-2e-3, 0.6e-3, 0.3)] {
        for phase in [0.05e-3, 0.15e-3, 0.25e-3] {
            let mut p = e02(true);
            (p.rate, p.guard.speed) = (1e3, 5.0);
            let mut rig = Rig::new(&met(&wall(8e3, 0.0), &p), "key", p);
            let mut rng = Random(11);
            let (mut frame, mut began, mut due) = (0_u64, None, phase);
            let (mut at, mut held, mut most, mut work) = (10e-3, 0.0, 0.0_f64, 0.0);
            let mut last = ForceFrame::new("key", 1);
            for turn in 0_u32..13_000 {
                // the device moves once in its period, and uses the last force as it sends
                let sent = due + jitter * (rng.even() - 0.5);
                due += 1e-3 * (1.0 + drift);
                while frame as f64 * FRAME_DT < sent {
                    last = rig.go(None, last.seq);
                    frame += 1;
                }
                let t = f64::from(turn) * 1e-3;
                let x = 10e-3 + 6e-3 * (2.0 * std::f64::consts::TAU * t).sin();
                if began.is_some() {
                    work += held * (x - at);
                    most = most.max(held.abs());
                }
                (at, held) = (x, f64::from(last.force[0]));
                last = rig.go(Some(&[x]), last.seq);
                frame += 1;
                // the scene has reached the position of the hand
                if began.is_none() && turn >= 500 && Mode::read(last.mode) == Mode::On {
                    began = Some(turn);
                }
            }
            assert!(began.is_some_and(|turn| turn < 3000), "forces are on");
            println!("{drift}, {jitter} s, {phase} s: {most:.5} N, {:.3} uJ", 1e6 * work);
            assert!(most < limit && work < 1e-6, "{drift}, {jitter} s, {phase} s: {most} N, {work} J");
        }
    }
}

/// Presses a key into its wall with forces on, and returns the last force frame too.
fn pressed(p: &Profile, fades: bool) -> (Rig, Arc<Scene>, ForceFrame) {
    let scene = scene(&wall(2e3, 0.0));
    let mut rig = Rig::new(&scene, "key", p.clone());
    if !fades {
        let port = Port::new(&scene, setup(&scene, p));
        rig.engine = Engine::new(scene.clone(), vec![port], Options { fades, ..Options::default() });
        rig.engine.command(EngineCommand::Order(None, Order::Arm));
    }
    let on = (0..9000).find(|n| Mode::read(rig.go(Some(&[0.0]), *n).mode) == Mode::On).expect("forces on");
    let at = |n: u64| -1.7e-3 * (n as f64 / 3000.0).min(1.0);
    let last = (0..6000).map(|n| rig.go(Some(&[at(n)]), on + n)).last().expect("frames");
    assert!((last.force[0] - 3.2).abs() < 0.01, "{} N", last.force[0]);
    (rig, scene, last)
}

/// Switches to another version of the model, with a wall that the device cannot hold.
fn edited(rig: &mut Rig, scene: &Scene, p: &Profile) {
    let next = met(&wall(2e4, 0.0), p);
    assert_eq!(next.hand.couplings.len(), 1);
    let setups = [setup(&next, p)];
    let swap = Swap::new(scene, next.clone(), next.state(), &setups, (1, false)).expect("it fits");
    rig.engine.command(EngineCommand::Swap(Box::new(swap)));
}

#[test]
fn a_force_fades_out_where_another_version_plays() {
    for slew in [200.0, 1e5] {
        let mut p = e02(true);
        (p.guard.slew, p.guard.clear) = (Some(slew), 0.01);
        let (mut rig, scene, mut last) = pressed(&p, true);
        edited(&mut rig, &scene, &p);
        let most = slew.min(3.2 / p.guard.zero * 1.05) * FRAME_DT;
        let mut fading = 0;
        for n in 0..80 {
            // the fade continues while the device is silent
            let f = rig.go((n > 3).then_some(&[-1.7e-3]), 0);
            let step = f64::from(last.force[0] - f.force[0]);
            assert!((-1e-6..most * 1.001 + 1e-6).contains(&step), "frame {n}: {step} N, {most} N");
            let mode = Mode::read(f.mode);
            assert_eq!(mode == Mode::Ramp, f.force[0] != 0.0 || last.force[0] != 0.0, "frame {n}: {mode:?}");
            assert!(f.flags & flag::WAIT_CLEAR != 0);
            fading += usize::from(mode == Mode::Ramp);
            last = f;
        }
        assert!((20..60).contains(&fading), "{fading} frames");
        assert_eq!((last.force[0], Mode::read(last.mode)), (0.0, Mode::Off));
        let on = (0..6000).find(|_| Mode::read(rig.go(Some(&[-1.7e-3]), 0).mode) != Mode::Off);
        assert_eq!(on, None, "it presses");
        for n in 0..3000_u32 {
            rig.go(Some(&[-1.7e-3 * (1.0 - f64::from(n) / 3000.0)]), 0);
        }
        assert!((0..6000).any(|_| Mode::read(rig.go(Some(&[0.0]), 0).mode) == Mode::On));
    }
}

#[test]
fn a_fade_ends_at_once_where_it_must() {
    let p = e02(true);
    for end in [Order::Disarm, Order::Trip(Cause::Deadman)] {
        let (mut rig, scene, _) = pressed(&p, true);
        edited(&mut rig, &scene, &p);
        assert!(rig.go(Some(&[-1.7e-3]), 0).force[0] > 3.0);
        rig.engine.command(EngineCommand::Order(None, end));
        let f = rig.go(Some(&[-1.7e-3]), 0);
        assert_eq!(f.force[0], 0.0, "{end:?}");
        assert!(matches!(Mode::read(f.mode), Mode::Off | Mode::Fault));
    }
    // without a fade, as in older takes
    let mut p = p;
    p.guard.clear = 0.01;
    let (mut rig, scene, _) = pressed(&p, false);
    edited(&mut rig, &scene, &p);
    let f = rig.go(Some(&[-1.7e-3]), 0);
    assert_eq!((f.force[0], Mode::read(f.mode)), (0.0, Mode::Off));
}

#[test]
fn the_ledger_of_a_coupled_key_closes() {
    let p = e02(true);
    let text = format!(
        "{}[MAS]\nbob = {{ m = \"5 g\", x = -1 }}\n[RES]\nr = {{ between = [\"key\", \"bob\"], k = 3000 }}\n",
        wall(2e4, 0.0)
    );
    let first = compiled(&text, &Compile::default());
    let soft = needed(&first.scene, &[setup(&first.scene, &p)]).softened;
    assert_eq!(soft.len(), 1);
    let options = Compile { energy: true, couplings: vec![soft[0].coupling.clone()], ..Compile::default() };
    let scene = Arc::new(compiled(&text, &options).scene);
    let names: Vec<String> = scene.symbols.iter().map(|s| s.name.to_string()).collect();
    assert!(names.iter().any(|n| n == "key (coupled)") && names.iter().any(|n| n == "key (coupling)"), "{names:?}");
    let mut rig = Rig::new(&scene, "key", p);
    for n in 0..9000_u32 {
        let t = f64::from(n) / 3000.0;
        rig.go(Some(&[-1e-3 * (t * 20.0).sin() * (t * 3.0).min(1.0)]), 0);
    }
    let ledger = rig.engine.state.ledger.as_ref().expect("a ledger");
    let b = ledger.balance();
    assert!(ledger.extremes.peak > 5e-4 && b.lost > 1e-4, "something happened: {b:?}");
    assert!(b.residual.abs() < 1e-9 * ledger.extremes.peak, "{b:?}");
    let hand = &ledger.hands[0];
    assert!(hand.received > 0.0, "{hand:?}");
}
