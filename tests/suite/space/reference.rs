//! Scenes in space against motions in continuous time, which `data/space/reference.py` integrates at order 8 and with
//! exact contact switches.
//!
//! Each case is rendered at five rates. The error must fall as the scheme promises: order 2, or order 1 with the
//! backward damper of CORDIS-ANIMA. At 48 kHz it must be the error that the scheme should have; a larger or smaller
//! error is a bug. These figures come from a second, minimal implementation of the equations. `cargo test $ALL --test
//! suite -- reference --nocapture` prints errors and ticks.
//!
//! A blow is not smooth. The position of its switches between two ticks adds an error that jumps from rate to rate, so
//! one blow alone shows any order between 1.5 and 2.5. The reference therefore has each blow seventeen times, with its
//! beginning and end evenly spread over fractions of a tick at every rate. The order is the slope of the mean error
//! over all five rates.

use crate::play::{list, mat, num, off, rows, scene, within};
use ca_core::tick;
use serde_json::Value;
use std::fmt::Write;
use std::sync::OnceLock;

const RATES: [f64; 5] = [12e3, 24e3, 48e3, 96e3, 192e3];

/// The cases whose ids are `name`, or `name` and a number.
fn cases(name: &str) -> Vec<&'static Value> {
    static ALL: OnceLock<Value> = OnceLock::new();
    let all = ALL.get_or_init(|| serde_json::from_str(include_str!("../../data/space/reference.json")).expect("JSON"));
    let named = |c: &&Value| {
        let rest = c["id"].as_str().and_then(|id| id.strip_prefix(name));
        rest.is_some_and(|r| r.trim_start_matches('_').chars().all(|c| c.is_ascii_digit()))
    };
    let found: Vec<_> = all["cases"].as_array().into_iter().flatten().filter(named).collect();
    assert!(!found.is_empty(), "no case {name}");
    found
}

/// The model of a case at the sound rate `fs`; the masses are `room.a0` …, the origin is `room.nail`.
fn model(c: &Value, fs: f64) -> String {
    let name = |i: f64| if i < 0.0 { "room.nail".into() } else { format!("room.a{i}") };
    let mut s = format!("[rate]\nsound = {fs:?}\n[room]\ndim = 3\n");
    let gravity = list(c, "gravity");
    if gravity.iter().any(|g| *g != 0.0) {
        let _ = writeln!(s, "gravity = {gravity:?}");
    }
    let (mut springs, mut contacts, mut held) = (String::new(), String::new(), false);
    for (n, r) in rows(c, "springs").iter().enumerate() {
        let [i, j, k, z, l0] = r[..] else { panic!("{r:?}") };
        held |= i < 0.0;
        let ends = [name(i), name(j)];
        let _ = writeln!(springs, "s{n} = {{ between = {ends:?}, k = {k:?}, z = {z:?}, l0 = {l0:?} }}");
    }
    for sense in ["outside", "inside"] {
        for (n, r) in rows(c, sense).iter().enumerate() {
            let [i, j, k, z, d] = r[..] else { panic!("{r:?}") };
            held |= i < 0.0;
            let ends = [name(i), name(j)];
            let law = format!("k = {k:?}, z = {z:?}, d = {d:?}");
            let _ = writeln!(contacts, "{sense}{n} = {{ between = {ends:?}, {law}, sense = \"{sense}\" }}");
        }
    }
    for r in rows(c, "plane") {
        let [i, k, z] = r[..] else { panic!("{r:?}") };
        held = true;
        let ends = [name(-1.0), name(i)];
        let _ = writeln!(contacts, "floor{i} = {{ between = {ends:?}, along = \"z\", k = {k:?}, z = {z:?}, d = 0 }}");
    }
    if held {
        s += "[room.SOL]\nnail = { x = [0, 0, 0] }\n";
    }
    s += "[room.MAS]\n";
    for (i, ((m, x), v)) in list(c, "m").iter().zip(rows(c, "x0")).zip(rows(c, "v0")).enumerate() {
        let _ = writeln!(s, "a{i} = {{ m = {m:?}, x = {x:?}, v = {v:?} }}");
    }
    for (kind, lines) in [("REF", springs), ("BUT", contacts)] {
        if !lines.is_empty() {
            let _ = write!(s, "[{kind}]\n{lines}");
        }
    }
    s + "[SOX]\nout = { from = \"room.a0\", along = \"z\" }\n"
}

/// Mean square over masses and stored instants of the distance from the reference \[m²\].
fn miss(c: &Value, fs: f64) -> f64 {
    let scene = scene(&model(c, fs));
    let places: Vec<usize> = (0..list(c, "m").len())
        .flat_map(|i| {
            let first = mat(&scene, &format!("room.a{i}"));
            first..first + 3
        })
        .collect();
    let ticks = (fs / num(c, "per_second")) as usize;
    let kept = rows(c, "x");
    let mut s = scene.state();
    let mut sum = 0.0;
    for row in &kept {
        (0..ticks).for_each(|_| tick(&scene, &mut s));
        sum += places.iter().zip(row).map(|(p, x)| (scene.places.rest[*p] + s.x[*p] - x).powi(2)).sum::<f64>();
    }
    sum / (kept.len() * places.len() / 3) as f64
}

/// Root mean square errors \[m\] of a case, or of all its blows together, at [`RATES`], and their order.
fn errors(name: &str) -> (Vec<f64>, f64) {
    let cases = cases(name);
    let mean = |fs: f64| cases.iter().map(|c| miss(c, fs)).sum::<f64>() / cases.len() as f64;
    let errors: Vec<f64> = RATES.iter().map(|fs| mean(*fs).sqrt()).collect();
    // least squares through (octave, log₂ error), with octaves counted from the middle
    let slope = errors.iter().zip([-2.0, -1.0, 0.0, 1.0, 2.0]).map(|(e, o)| o * e.log2()).sum::<f64>() / 10.0;
    println!("{name}: order {:.3}", -slope);
    for (fs, e) in RATES.iter().zip(&errors) {
        println!("{fs:9} Hz {:10} ticks {e:12.3e} m", num(cases[0], "seconds") * fs);
    }
    (errors, -slope)
}

/// Checks for order 2, and the error at 48 kHz \[m\].
#[track_caller]
fn second_order(name: &str, should_be: f64) {
    let (errors, order) = errors(name);
    within(&format!("{name}: order 2"), (order - 2.0).abs(), 0.15);
    within(&format!("{name} at 48 kHz"), off(errors[2], should_be), 0.002);
}

/// Checks for order 1, or more while the error of the springs dominates, and the error at 48 kHz \[m\].
#[track_caller]
fn damped(name: &str, should_be: f64) {
    let (errors, order) = errors(name);
    assert!((0.95..2.15).contains(&order), "{name}: order {order}");
    within(&format!("{name} at 48 kHz"), off(errors[2], should_be), 0.002);
}

#[test]
fn an_elastic_pendulum() {
    second_order("pendulum", 2.505e-8);
}

#[test]
fn a_spinning_tetrahedron() {
    second_order("tetrahedron", 3.007e-8);
}

#[test]
fn a_spinning_tetrahedron_with_dampers() {
    // dampers on the projected velocity instead of the change of length would have over three times this error
    damped("tetrahedron_damped", 3.145e-8);
}

#[test]
fn a_pyramid_that_falls_on_a_plane() {
    second_order("pyramid", 2.431e-7);
}

#[test]
fn a_pyramid_that_falls_on_a_viscous_plane() {
    damped("pyramid_damped", 3.921e-6);
}

#[test]
fn a_ball_between_a_core_and_a_shell() {
    second_order("rattle", 3.787e-7);
}
