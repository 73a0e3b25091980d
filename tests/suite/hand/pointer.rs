//! A pointer that holds a mass: the coupling in closed form, no cost without it, its work in the ledger, and no
//! divergence under any motion; also ports and the model's own gesture in an engine.

use super::guard::{Rig, bare};
use crate::play::{Random, audited, mat, scene, with};
use ca_compile::{Options, compile};
use ca_core::internal::state::FINGERS;
use ca_core::pointer::{Pointer, Refused};
use ca_core::{Level, Scene, State, compute_forces, integrate};
use ca_haptic::engine::{Engine, EngineCommand, GLIDE, ManualEvent, ManualInput, Options as EngineOptions, OwnGesture};
use ca_model::read;
use ca_tests::long_form::long_form;
use ca_tests::{catalog, texts};
use std::sync::Arc;

const STRING: &str =
    "[STRING]\ns = { n = 40, f = \"110 Hz\", t60 = \"2 s\", m = \"1 g\" }\n[SOX]\nout = { from = \"s[7]\" }\n";
const MESH: &str =
    "[MESH]\nm = { nx = 9, ny = 7, f = \"90 Hz\", m = \"1 g\", t60 = \"2 s\" }\n[SOX]\nout = { from = \"m[3,2]\" }\n";
const CLOTH: &str = r#"
[w]
dim = 3
[w.MAS]
a = { m = "1 g", x = ["0 cm", "0 cm", "0 cm"] }
b = { m = "2 g", x = ["3 cm", "0 cm", "0 cm"] }
c = { m = "1 g", x = ["0 cm", "3 cm", "1 cm"] }
[w.RES]
ab = { between = ["w.a", "w.b"], k = 900 }
bc = { between = ["w.b", "w.c"], k = 700 }
ca = { between = ["w.c", "w.a"], k = 800 }
[SOX]
out = { from = "w.a", along = [1, 0, 0] }
"#;

/// Runs one tick with a pointer, as an engine does.
fn tick(scene: &Scene, s: &mut State, pointer: &mut Pointer) {
    compute_forces(scene, s);
    pointer.prepare(s);
    integrate(scene, s);
    pointer.apply(s);
}

#[test]
fn a_mass_alone_follows_in_closed_form() {
    let scene = scene("[MAS]\nm = { m = \"3 g\" }\n[SOX]\nout = { from = \"m\" }\n");
    let (mut s, mut pointer) = (scene.state(), Pointer::new(&scene, 0, 0).unwrap());
    pointer.hold(&s);
    pointer.pull([5e-3, 0.0, 0.0]);
    let glide = (scene.rate / 60.0) as u64;
    for _ in 0..glide {
        tick(&scene, &mut s, &mut pointer);
    }
    let [k, z] = pointer.coupling(&scene, &s);
    let t = scene.rates.sample_dt;
    let (kappa, nu) = (k * t * t / 3e-3, z * t / 3e-3);
    // x_{n+1} = (2 − κ − ν) x_n − (1 − ν) x_{n−1} relative to the target
    let (b, c) = (0.5 * (2.0 - kappa - nu), 1.0 - nu);
    let x0 = s.x[0] - 5e-3;
    let before = s.x[0] - s.d[0] - 5e-3;
    let root = (b * b - c).abs().sqrt();
    let mut largest: f64 = 0.0;
    for n in 1..2000 {
        tick(&scene, &mut s, &mut pointer);
        let n = f64::from(n);
        let want = if b * b >= c {
            let (r1, r2) = (b + root, b - root);
            let a = (x0 - before * r2) * r1 / (r1 - r2);
            a * r1.powf(n) + (x0 - a) * r2.powf(n)
        } else {
            let (r, w) = (c.sqrt(), root.atan2(b));
            let a = (x0 * w.cos() - before * r) / w.sin();
            r.powf(n) * (x0 * (w * n).cos() + a * (w * n).sin())
        };
        largest = largest.max((s.x[0] - 5e-3 - want).abs());
    }
    assert!(largest < 1e-12, "{largest:e} m of 5 mm");
    assert!((s.x[0] - 5e-3).abs() < 1e-9, "it is where it was pulled to");
}

#[test]
fn who_holds_at_rest_changes_no_bit_and_who_lets_go_is_gone() {
    for text in [STRING, MESH, CLOTH] {
        let scene = scene(text);
        let (mut alone, mut held) = (scene.state(), scene.state());
        let mut pointer = Pointer::new(&scene, scene.mats() / 2, 0).unwrap();
        pointer.hold(&held);
        for n in 0..500 {
            ca_core::tick(&scene, &mut alone);
            if n < 250 {
                tick(&scene, &mut held, &mut pointer);
            } else {
                ca_core::tick(&scene, &mut held);
            }
        }
        assert_eq!(alone.bits(), held.bits(), "{text}");
    }
}

#[test]
fn what_a_pointer_gives_stands_in_the_ledger() {
    for text in [STRING, MESH, CLOTH] {
        let scene = audited(text);
        let (mut s, mut pointer) = (scene.state(), Pointer::new(&scene, scene.mats() / 2, 0).unwrap());
        let mut random = Random(7);
        pointer.hold(&s);
        for n in 0..6000 {
            if n < 4000 {
                if n % 500 == 0 {
                    pointer.pull([0.0; 3].map(|_: f64| 5e-4 * random.uniform()));
                }
                tick(&scene, &mut s, &mut pointer);
            } else {
                ca_core::tick(&scene, &mut s);
            }
        }
        let ledger = s.ledger.as_deref().unwrap();
        let balance = ledger.balance();
        assert!(balance.work > 0.0 && balance.work == ledger.pointer, "{balance:?}");
        assert!(balance.residual.abs() <= 1e-9 * balance.peak, "{text}\n{balance:?}");
    }
}

/// Ten fingers pull neighbours of a string at 0.99 of its limit: each weaker than the one before, and all that they give
/// is in the ledger.
#[test]
fn ten_fingers_together_stay_below_the_limit() {
    let k = 0.99 * 1e-3 * 48_000.0 * 48_000.0;
    let text = format!(
        "[STRING]\ns = {{ n = 20, k = {k}, m = 1e-3, ends = \"fixed\" }}\n[SOX]\nout = {{ from = \"s[3]\" }}\n"
    );
    let scene = audited(&text);
    assert_eq!(scene.certificate.level, Level::Proven);
    let mut s = scene.state();
    let at = |f: u8| {
        let place = mat(&scene, &format!("s[{}]", 4 + f)) as u32;
        scene.symbols.places().iter().position(|p| *p == place).expect("a mass of the string")
    };
    let mut all: Vec<Pointer> = (0..FINGERS as u8).map(|f| Pointer::new(&scene, at(f), f).unwrap()).collect();
    let firmness: Vec<f64> = all.iter().map(|p| p.coupling(&scene, &s)[0]).collect();
    assert!(firmness.windows(2).all(|two| two[1] < two[0]), "{firmness:?}");
    let fastest = |s: &State| s.d.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
    let mut random = Random(3);
    let mut moved = [0.0_f64; 4];
    for n in 0..40_000 {
        for p in &mut all {
            if n == 0 {
                p.hold(&s);
            } else if n % 500 == 0 && n < 20_000 {
                p.pull([1e-3 * random.uniform(), 0.0, 0.0]);
            }
        }
        compute_forces(&scene, &mut s);
        for p in &mut all {
            p.prepare(&s);
        }
        integrate(&scene, &mut s);
        for p in &mut all {
            p.apply(&mut s);
        }
        let part = &mut moved[n / 10_000];
        *part = part.max(fastest(&s));
    }
    let balance = s.ledger.as_deref().unwrap().balance();
    assert!(balance.residual.abs() <= 1e-9 * balance.peak, "{balance:?}");
    // held at their places, nothing grows
    assert!(moved[0] > 1e-9 && moved[3] <= 1.1 * moved[2], "{moved:?}");
}

#[test]
fn what_cannot_be_held_says_why() {
    let scene = scene(
        "[SOL]\nwall = {}\n[MAS]\nm = { m = 1 }\n[ENX]\npush = {}\n[REF]\na = { between = [\"wall\", \"m\"], k = 1e5, z = 1 }\n\
         b = { between = [\"push\", \"m\"], k = 1e4, z = 1 }\n[SOX]\nout = { from = \"m\" }\n",
    );
    let refused = |name: &str| {
        let place = mat(&scene, name) as u32;
        Pointer::new(&scene, scene.symbols.places().iter().position(|p| *p == place).unwrap(), 0).err()
    };
    assert_eq!(refused("wall"), Some(Refused::Fixed("wall".into())));
    assert_eq!(refused("push"), Some(Refused::Port("push".into())));
    assert_eq!(refused("m"), None);
    assert_eq!(Pointer::new(&scene, 3, 0).err(), Some(Refused::Unknown));
    let stiff = |k: f64| {
        let text = format!(
            "[SOL]\nw = {{}}\n[MAS]\nm = {{ m = 1 }}\n[RES]\na = {{ between = [\"w\", \"m\"], k = {k} }}\n[SOX]\nout = {{ from = \"m\" }}\n"
        );
        let scene = crate::play::scene(&text);
        let at = scene.symbols.places().iter().position(|p| *p == mat(&scene, "m") as u32).unwrap();
        Pointer::new(&scene, at, 0).map(|p| p.coupling(&scene, &scene.state())[0])
    };
    // κ = kT²/m: nothing is left at 4, and the coupling takes half of the rest
    let limit = 4.0 * 48_000.0 * 48_000.0;
    assert_eq!(stiff(limit), Err(Refused::Margin("m".into())));
    let [soft, firm] = [0.999, 0.5].map(|part| stiff(part * limit).unwrap());
    assert!(soft < 0.01 * firm, "{soft} {firm}");
}

/// No motion of any mass makes a bundled model, or any model proven stable, diverge. Laws of the test models that
/// stiffen without bound can be pressed beyond their rule of thumb; those are then silent (H15).
#[test]
fn no_hand_makes_a_bundled_model_diverge() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let bundled = |name: &str| folder.join(name).exists();
    let [of_bundled, of_others] = if long_form("most masses of each model") { [48, 12] } else { [5, 3] };
    let mut unheld = Vec::new();
    let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 0.0];
    for (name, text) in texts() {
        let (model, _) = read::read(&text, &name, &catalog());
        let Ok(compiled) = compile(&model, &catalog(), &Options { whole: true, ..Options::default() }) else {
            continue;
        };
        let scene = Arc::new(compiled.scene);
        let mut random = Random(11);
        let mut held = 0;
        // equal parts may put every step at the same unholdable place; then other steps are tried
        let step = (scene.mats() / if bundled(&name) { of_bundled } else { of_others }).max(1);
        let by = |step: usize| -> Vec<usize> {
            let all = (0..scene.mats()).step_by(step);
            all.filter(|mass| Pointer::new(&scene, *mass, 0).is_ok()).collect()
        };
        let mut grabs = by(step);
        if grabs.is_empty() {
            grabs = by(step | 1);
        }
        for mass in grabs {
            held += 1;
            let mut engine = Engine::new(scene.clone(), Vec::new(), EngineOptions::default());
            // a second finger holds the next mass, if that can be held
            for finger in 0..2 {
                if let Some(grab) = ManualEvent::Grab(finger, mass as u32 + u32::from(finger)).to_input(&scene) {
                    engine.command(EngineCommand::Manual(grab));
                }
            }
            let frame = |engine: &mut Engine| {
                let _ = engine.answer().count();
                engine.finish();
            };
            for n in 0..600 {
                if n % 50 == 0 {
                    let any = |r: &mut Random| {
                        if r.uniform() < -0.4 { wild[(r.uniform().abs() * 6.0) as usize % 6] } else { r.uniform() }
                    };
                    let to = [any(&mut random), any(&mut random), any(&mut random)];
                    engine.command(EngineCommand::Manual(ManualInput::Pull((n / 50 % 2) as u8, to)));
                }
                frame(&mut engine);
            }
            (0..2).for_each(|finger| drop(engine.command(EngineCommand::Manual(ManualInput::Release(finger)))));
            for _ in 0..300 {
                frame(&mut engine);
            }
            let at = scene.symbols.get(mass).map(|s| s.name.to_string()).unwrap_or_default();
            let must = bundled(&name) || scene.certificate.level == Level::Proven;
            assert!(!(must && engine.has_diverged()), "{name}: `{at}`");
            assert!(engine.has_diverged() || engine.state.is_bounded(1e3), "{name}: `{at}`");
        }
        if held == 0 && bundled(&name) {
            unheld.push(name);
        }
    }
    assert!(unheld.is_empty(), "nothing that was tried can be held in {unheld:?}");
}

#[test]
fn ports_glide_and_a_gesture_begins_where_they_are() {
    let text = "[ENX]\np = { x = \"1 mm\" }\n[MAS]\nm = { m = \"1 g\" }\n[REF]\nl = { between = [\"p\", \"m\"], k = 1e4, z = 0.1 }\n\
                [SOX]\nout = { from = \"m\" }\n[gesture]\np = [[0, 2e-3], [0.1, 5e-3]]\n";
    let scene = Arc::new(with(text, &Options::default()).scene);
    let mut engine = Engine::new(scene.clone(), Vec::new(), EngineOptions::default());
    let input = scene.input("p").unwrap();
    let mut moved: f64 = 0.0;
    let mut run = |engine: &mut Engine, seconds: f64| {
        for _ in 0..(3000.0 * seconds) as u32 {
            let before = engine.state.input[input];
            let _ = engine.answer().count();
            engine.finish();
            moved = moved.max((engine.state.input[input] - before).abs());
        }
        engine.state.input[input]
    };
    let at = run(&mut engine, 0.05);
    engine.command(EngineCommand::Manual(ManualInput::Port(input as u32, 4e-3, GLIDE)));
    assert_eq!(run(&mut engine, 0.05), 4e-3, "from {at}");
    engine.command(EngineCommand::Manual(ManualInput::Play(Box::new(OwnGesture::new(&scene).unwrap()))));
    assert_eq!(run(&mut engine, 0.3), 5e-3, "the end of the gesture");
    // played again and stopped half-way: the port stays there
    engine.command(EngineCommand::Manual(ManualInput::Play(Box::new(OwnGesture::new(&scene).unwrap()))));
    let half = run(&mut engine, 0.1);
    assert!(half > 2.5e-3 && half < 4.5e-3, "{half}");
    assert!(engine.command(EngineCommand::Manual(ManualInput::Stop)).is_some(), "its memory is given back");
    assert_eq!(run(&mut engine, 0.1), half);
    // the fastest motion is 3 mm in 17 ms: 60 µm a frame
    assert!(moved < 8e-5, "a jump of {moved} m");
    engine.command(EngineCommand::Manual(ManualInput::Port(99, 1.0, GLIDE)));
    engine.command(EngineCommand::Manual(ManualInput::Port(input as u32, f64::NAN, GLIDE)));
    assert_eq!(engine.counts.refused, 2);
}

/// A device with one degree of freedom, in a model with one key that it has and one that it does not have.
#[test]
fn a_key_that_its_device_does_not_have_is_moved_while_that_plays() {
    let mut rig = Rig::new(
        "[MAS]\na = { m = \"1 g\" }\nb = { m = \"1 g\" }\n[TGR]\nnear = { device = \"key\" }\nfar = { device = \"key\", dof = 40 }\n\
         [REF]\nl = { between = [\"near\", \"a\"], k = 10, z = 0.1 }\nm = { between = [\"far\", \"b\"], k = 10, z = 0.1 }\n[SOX]\nout = { from = \"b\" }\n",
        bare(),
    );
    let inputs = ["near", "far"].map(|name| rig.engine.scene.input(name).unwrap());
    for _ in 0..100 {
        rig.go(&[1e-3]);
    }
    for input in inputs {
        rig.engine.command(EngineCommand::Manual(ManualInput::Port(input as u32, 4e-3, GLIDE)));
    }
    for _ in 0..100 {
        rig.go(&[1e-3]);
    }
    assert_eq!(inputs.map(|i| rig.engine.state.input[i]), [1e-3, 4e-3]);
}
