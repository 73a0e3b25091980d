//! Junctions: springs of any stiffness, and the propagation of waves.

use super::{poles, radius, string};
use crate::play::{audited, case, list, mat, num, off, scene, within};
use ca_core::{Level, tick};

const FS: f64 = 48e3;

/// A lossless string of 20 + 50 samples and impedance 1, with a spring of stiffness `k` from its junction to ground.
fn sprung(k: f64, m: &str) -> String {
    let more = format!("[SOL]\nwall = {{}}\n[RES]\nspring = {{ between = [\"w[0]\", \"wall\"], k = {k:e} }}\n");
    string(&format!("f = {:?}, z = 1, at = {:?}{m}", FS / 70.0, 20.0 / 70.0), &more)
}

/// Springs up to a hundred times the impedance keep all poles in the unit circle, with the default mass of the junction
/// and with slightly more than the smallest. The certificate agrees.
#[test]
fn g02_any_spring_is_passive() {
    let c = case("G02");
    let tolerance = num(c, "tolerance/mass_loaded_abs");
    for r in list(c, "setup/kT_over_Z").into_iter().chain([100.0]) {
        let k = r * FS;
        let least = 0.25 * k / (FS * FS);
        for m in [String::new(), format!(", m = {:e}", 1.01 * least)] {
            let s = scene(&sprung(k, &m));
            assert_eq!(s.certificate.level, Level::Proven, "{r} {m}");
            within("G02 radius", (radius(&poles(&s)) - 1.0).abs(), tolerance);
        }
        // below that mass nothing is proven; it is called unstable only if even the returning waves could not hold it
        let s = scene(&sprung(k, &format!(", m = {:e}", 0.99 * least)));
        assert_eq!(s.certificate.level, Level::NotProven, "{r}");
        let s = scene(&sprung(k, &format!(", m = {:e}", 0.5 * least)));
        let radius = radius(&poles(&s));
        assert_eq!(s.certificate.level == Level::Unstable, r > 8.0, "{r}");
        assert!(s.certificate.level == Level::NotProven || radius > 1.01, "{r}: {radius}");
    }
}

#[test]
fn g03_the_energy_of_a_sprung_junction_is_constant() {
    let c = case("G03");
    let k = 0.5 * FS;
    let scene = audited(&sprung(k, &format!(", m = {:e}", 0.5 * k / (FS * FS))));
    assert_eq!([scene.waves.delays[0].len, num(c, "setup/D1") as usize], [20, 20]);
    let mut s = scene.state();
    s.d[mat(&scene, "w[0]")] = 1e-5;
    tick(&scene, &mut s);
    tick(&scene, &mut s);
    let h0 = s.ledger.as_ref().expect("a ledger").h;
    assert!(h0 > 0.0);
    let mut drift = 0.0f64;
    for _ in 0..num(c, "setup/steps") as usize {
        tick(&scene, &mut s);
        drift = drift.max(off(s.ledger.as_ref().expect("a ledger").h, h0));
    }
    within("G03 drift", drift, num(c, "tolerance/rel"));
}

/// A push at one junction reaches the other after exactly the ticks between them; the near end echoes on time.
#[test]
fn waves_take_their_time() {
    let scene = scene(&string(
        "f = 100, z = 1, at = [0.25, 0.5], m = 2.0833e-5",
        "far = { from = \"w[1]\" }\n[ENF]\nhand = { to = \"w[0]\" }\n",
    ));
    let mut s = scene.state();
    let mut moved = Vec::new();
    for n in 0..400 {
        s.input[0] = if n == 0 { 1.0 } else { 0.0 };
        tick(&scene, &mut s);
        moved.push([s.d[mat(&scene, "w[0]")], s.d[mat(&scene, "w[1]")]]);
    }
    let first = |j: usize, from: usize| moved.iter().skip(from).position(|d| d[j].abs() > 1e-12).map(|n| n + from);
    // 480 samples up and down, junctions at 1/4 and 1/2: 60 samples apart, 120 from the first to the end and back
    assert_eq!([first(0, 0), first(1, 0)], [Some(0), Some(60)]);
    assert_eq!(first(0, 4), Some(120));
    // F = 2Z v: half a newton second per kilogram for a tick, in each direction
    let step: f64 = moved[..100].iter().map(|d| d[1]).sum();
    within("as far as the push", off(step, 0.5 / FS), 1e-4);
}

#[test]
fn it_comes_back_to_where_it_was() {
    let scene = scene(&string(
        "f = 440, t60 = 0.2, t60_high = 0.05, z = 1, at = 0.3, m = 1e-6",
        "[ENF]\nhand = { to = \"w[0]\" }\n",
    ));
    let mut s = scene.state();
    let (mut most, w) = (0.0f64, mat(&scene, "w[0]"));
    for n in 0..96_000 {
        s.input[0] = if n < 400 { 1.0 } else { 0.0 };
        tick(&scene, &mut s);
        most = most.max(s.x[w].abs());
    }
    assert!(most > 1e-5, "it was never moved: {most}");
    within("what is left of the displacement", s.x[w].abs() / most, 1e-12);
}

/// Under a steady push the string yields like its near part: 2Z/(D T).
#[test]
fn a_steady_push_is_held_by_the_near_end() {
    let scene = scene(&string(
        "f = 480, t60 = 0.1, t60_high = 0.05, z = 1, at = 0.5, m = 1e-6",
        "[ENF]\nhand = { to = \"w[0]\" }\n",
    ));
    let mut s = scene.state();
    s.input[0] = 1.0;
    for _ in 0..96_000 {
        tick(&scene, &mut s);
    }
    let near = 2.0 * FS / 50.0;
    within("the give of the near part", off(s.x[mat(&scene, "w[0]")], 1.0 / near), 1e-9);
}
