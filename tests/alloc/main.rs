//! Checks that a tick never allocates, by counting all allocator calls on this thread while scenes play.
//!
//! This is a separate binary because a program has one allocator.
#![allow(unsafe_code)]

mod audio;
mod callback;
mod counting;
mod engine;
mod large;
mod live;
mod manual_input;
mod rings;

use ca_benches::rattle;
use ca_compile::{KernelClass, Options, compile};
use ca_core::{Scene, State, compute_forces, integrate, process, tick};
use ca_io::perform::Performance;
use ca_model::{Item, Model, Value, read};
use ca_tests::{gesture, texts};
use counting::{calls, most};

/// Returns the model with every option of the rate boundary and of the outputs in use.
fn burdened(model: &Model, border: &str, feedback: &str) -> Model {
    let mut m = model.clone();
    for (key, value) in [("border", border), ("latency", "3"), ("feedback", feedback), ("filter", "2 kHz")] {
        assert!(m.set(&format!("rate.{key}"), value));
    }
    // outputs of acceleration need no DC filter
    let bare = |i: &Item| !i.args.iter().any(|e| e.key == "hear" && e.value == Value::Text("acceleration".into()));
    let outputs = model.items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF") && bare(i));
    outputs.for_each(|i| assert!(m.set(&format!("{}.dc", i.name), "7 Hz")));
    m
}

/// Models with implicit links, alone and solved together, some without pull.
fn stable() -> Vec<(String, String)> {
    let alone = r#"
[param]
k = { value = 1e7, unit = "N/m", live = true, min = 1e5, max = 1e9 }
[SOL]
wall = {}
[MAS]
a = { m = "1 g", x = "1 mm", v = "-3 m/s" }
b = { m = "1 g", x = "1 mm", v = "-2 m/s" }
c = { m = "1 g", x = "1 mm", v = "-4 m/s" }
d = { m = "1 g", v = "3 m/s" }
[BUT]
one = { between = ["wall", "a"], k = "k", z = 1, method = "stable" }
two = { between = ["wall", "b"], k = "k", z = 100, sticky = false, method = "stable" }
[HRZ]
three = { between = ["wall", "c"], k = 1e9, h = 0.1, method = "stable" }
[BOW]
rub = { between = ["wall", "d"], f = 1, v0 = 1, method = "newton" }
[SOX]
out = { from = "a" }
more = { from = "b" }
"#;
    let rubbed = alone.replace("[\"wall\", \"d\"]", "[\"c\", \"d\"]").replace("newton", "secant");
    let clipped = rattle::text(1.0, "stable3d", 3).replace("method =", "z = 20, sticky = false, method =");
    let rattle = rattle::text(1e4, "stable", 2);
    [("alone", alone.into()), ("rubbed", rubbed), ("together", rattle), ("clipped", clipped)]
        .map(|(n, t)| (format!("stable, {n}"), t))
        .into()
}

/// Models with groups at the gesture rate, in space and with several ticks per sample.
fn slow() -> Vec<(String, String)> {
    let body = r#"
[body]
dim = 3
rate = "gesture"
gravity = "9.81 m/s^2"
[body.GRAINS]
beads = { n = 20, m = "1 g", gap = "6 mm" }
[body.SOL]
roof = { x = [0, 0, "20 cm"] }
[BUT]
hits = { between = ["body.beads[*]", "body.beads[*]"], k = "2 kN/m", z = "10 mN s/m", d = "7 mm" }
[REF]
up = { between = ["body.roof", "body.beads[*]"], k = "50 N/m" }
tie = { between = ["body.beads[0]", "low[10]"], along = "y", k = "1 kN/m", z = "0.1 N s/m" }
[STRING]
low = { n = 40, f = "110 Hz", t60 = "2 s", m = "4 g" }
[SOX]
out = { from = "low[5]", gain = 100 }
"#;
    let fine = format!("[rate]\noversample = 3\n{body}");
    [("slow group", body.into()), ("slow group in finer ticks", fine)].map(|(n, t)| (n.into(), t)).into()
}

fn scenes() -> Vec<(String, Scene)> {
    let catalog = ca_tests::catalog();
    let mut all = Vec::new();
    for (name, text) in texts().into_iter().chain(stable()) {
        let (plain, _) = read::read(&text, &name, &catalog);
        let (held, line) = (burdened(&plain, "hold", "false"), burdened(&plain, "linear", "true"));
        let mut fine = line.clone();
        assert!(fine.set("rate.oversample", "3"));
        let ways =
            [(&plain, ""), (&held, ", late, held and mute"), (&line, ", late"), (&fine, ", late, in finer ticks")];
        for (model, what) in ways {
            for energy in [false, true] {
                for kernel in [KernelClass::Fast, KernelClass::Reference] {
                    let options = Options { energy, kernel, ..Options::default() };
                    let scene = compile(model, &catalog, &options).unwrap_or_else(|d| panic!("{name}: {d}")).scene;
                    all.push((format!("{name}{what}, energy {energy}, {kernel:?}"), scene));
                }
            }
        }
    }
    for (name, text) in slow() {
        let (model, _) = read::read(&text, &name, &catalog);
        for energy in [false, true] {
            let options = Options { energy, ..Options::default() };
            let scene = compile(&model, &catalog, &options).unwrap_or_else(|d| panic!("{name}: {d}")).scene;
            assert!(scene.rates.slow.is_some(), "{name}");
            all.push((format!("{name}, energy {energy}"), scene));
        }
    }
    assert!(all.len() > 100);
    all
}

#[test]
fn the_counter_counts() {
    assert!(calls(|| drop(std::hint::black_box(vec![1u8; 100]))) >= 2);
    assert_eq!(calls(|| assert_eq!(std::hint::black_box([1u8; 100]).len(), 100)), 0);
}

#[test]
fn a_tick_allocates_nothing() {
    for (name, scene) in scenes() {
        let mut s = scene.state();
        let n = calls(|| {
            for _ in 0..200 {
                gesture(&scene, &mut s);
                compute_forces(&scene, &mut s);
                integrate(&scene, &mut s);
                tick(&scene, &mut s);
            }
        });
        assert_eq!(n, 0, "{name}");
        let mut block = vec![0.0; 64 * scene.counts.n_out.max(1)];
        assert_eq!(calls(|| assert!(process(&scene, &mut s, &mut block))), 0, "{name}");
    }
}

#[test]
fn nor_with_bad_inputs() {
    for (name, scene) in scenes() {
        let mut s = scene.state();
        let n = calls(|| {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
                s.input.fill(bad);
                (0..40).for_each(|_| tick(&scene, &mut s));
            }
        });
        assert_eq!(n, 0, "{name}");
    }
}

#[test]
fn nor_while_parameters_move() {
    let mut moved = 0;
    for (name, scene) in scenes() {
        let mut controls = scene.controls();
        let params: Vec<_> = controls.params().to_vec();
        for p in params {
            let to = p.value * 1.01 + if p.value == 0.0 { p.min.max(0.0) } else { 0.0 };
            let Ok(patch) = controls.set(&p.name, to.clamp(p.min, p.max)) else { continue };
            // a clone has the capacity of the original
            let mut s: State = scene.state().clone();
            let mut good = false;
            let n = calls(|| {
                good = s.apply(&patch, 30);
                (0..20).for_each(|_| tick(&scene, &mut s));
                good &= s.apply(&patch, 3);
                (0..20).for_each(|_| tick(&scene, &mut s));
            });
            assert_eq!((n, good), (0, true), "{name}: {}", p.name);
            moved += patch.set.len();
        }
    }
    assert!(moved > 0, "no model has a live parameter");
}

/// The gesture changes live parameters at every frame: in a link, a contact, a cell, a string, a bank, a mass, a
/// mesh with held nodes, a cloud of points, and implicit links that do and do not share a mass.
#[test]
fn nor_a_performance_whose_gesture_moves_parameters() {
    let text = r#"
[param]
k = { value = 1000, unit = "N/m", live = true, min = 100, max = 1e4 }
f = { value = 200, unit = "Hz", live = true, min = 100, max = 400 }
m = { value = "1 g", live = true, min = "0.5 g", max = "2 g" }
g = { value = 1, live = true, min = 0, max = 2 }
[SOL]
wall = {}
[MAS]
a = { m = "m", x = "1 mm", v = "-3 m/s" }
c = { m = "m", v = 1 }
d = { m = "1 g" }
e = { m = "1 g" }
e2 = { m = "m", v = 1 }
[CEL]
bar = { m = "2 g", f = "f", t60 = "1 s", dx0 = "1 mm" }
[STRING]
low = { n = 12, m = "3 g", f = "f", t60 = "2 s" }
[BANK]
bells = { f = ["500 Hz", "700 Hz"], t60 = 1, m = "m" }
[REF]
tie = { between = ["wall", "a"], k = "k", z = 0.01 }
also = { between = ["a", "low[3]"], k = "k" }
more = { between = ["low[5]", "bar"], k = "k" }
bell = { between = ["bells[0]", "bar"], k = "k" }
[BUT]
hit = { between = ["bar", "a"], k = "k" }
held = { between = ["skin[1,1]", "bar"], k = 10 }
[RES]
next = { between = ["c", "d"], k = "k", method = "implicit" }
after = { between = ["d", "e"], k = "k", method = "implicit" }
alone = { between = ["wall", "e2"], k = "k", method = "implicit" }
[MESH]
skin = { nx = 4, ny = 3, k = "k", m = "m", fixed = [[0, 0], [-1, -1]] }
[room]
dim = 3
[room.CLOUD]
star = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], scale = 0.02, reach = "4 cm", m = "m", k = "k" }
[SOX]
out = { from = "a", gain = "g" }
low = { from = "low[2]" }
star = { from = "room.star[1]", along = "x" }
[gesture]
k = [[0, 500], [1, 5000]]
f = [[0, 150], [1, 300]]
m = [[0, 0.0007], [1, 0.0017]]
g = [[0, 0.1], [1, 1.9]]
"#
    .replace("low = { from", "string = { from");
    let catalog = ca_tests::catalog();
    let (model, _) = read::read(&text, "moved", &catalog);
    let scene = compile(&model, &catalog, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    let mut p = Performance::new(&scene, None).expect("a gesture");
    (0..64).for_each(|_| p.tick());
    let before: Vec<f64> = p.controls.params().iter().map(|p| p.value).collect();
    let n = calls(|| (0..48_000).for_each(|_| p.tick()));
    assert_eq!(n, 0);
    for (was, param) in before.iter().zip(p.controls.params()) {
        assert!(param.value != *was, "{} stood still", param.name);
    }
    assert!(!p.diverged && p.state.x.iter().any(|x| *x != 0.0));
}
