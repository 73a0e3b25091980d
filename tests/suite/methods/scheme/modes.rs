//! Modes of chains and meshes, up to the limit.

use super::test_models::{FS, mode, string, warped_frequency};
use crate::play::{PI, Random, TURN, apart, case, list, mat, mats, num, off, scene, within};
use ca_core::{Level, State, tick};

#[test]
fn a07_modes_of_a_chain() {
    let c = case("A07");
    let n = num(c, "setup/N") as usize;
    let scene = scene(&string(n, 1e-3, num(c, "setup/a") * 1e-3 * FS * FS, 0.0));
    let masses = mats(&scene, "s");
    assert_eq!(masses.len(), n);
    for (j, f) in list(c, "values/j").into_iter().zip(list(c, "values/f")) {
        let shape: Vec<f64> = (1..=n).map(|i| (i as f64 * j * PI / (n as f64 + 1.0)).sin()).collect();
        let (lambda, stray) = mode(&scene, &masses, &shape);
        within(&format!("A07 mode {j}"), off(warped_frequency(lambda, FS), f), num(c, "tolerance/rel"));
        within(&format!("A07 mode {j} keeps its shape"), stray, 1e-14);
        let theta = TURN * f / FS;
        let mut s = scene.state();
        for (p, v) in masses.iter().zip(&shape) {
            (s.x[*p], s.d[*p]) = (*v, 2.0 * v * (0.5 * theta).sin().powi(2));
        }
        let mut worst = 0.0f64;
        for t in 0..4800u32 {
            let cos = (f64::from(t) * theta).cos();
            worst = masses.iter().zip(&shape).fold(worst, |w, (p, v)| w.max((s.x[*p] - v * cos).abs()));
            tick(&scene, &mut s);
        }
        within(&format!("A07 mode {j} over 0.1 s"), worst, 1e-9);
    }
}

#[test]
fn a08_at_the_limit_a_string_is_exactly_harmonic() {
    let c = case("A08");
    let n = num(c, "setup/N") as usize;
    let period = num(c, "values/period_samples") as usize;
    let tolerance = num(c, "tolerance/period_rel");
    let scene = scene(&string(n, 1e-3, 1e-3 * FS * FS, 0.0));
    let masses = mats(&scene, "s");
    let mut rng = Random(8);
    let start: Vec<f64> = (0..n).map(|_| rng.uniform()).collect();
    let mut s = scene.state();
    let side = |i: usize, k: i64| usize::try_from(i as i64 + k).ok().and_then(|i| start.get(i)).copied().unwrap_or(0.0);
    for (i, p) in masses.iter().enumerate() {
        (s.x[*p], s.d[*p]) = (start[i], -0.5 * (side(i, -1) - 2.0 * start[i] + side(i, 1)));
    }
    let now = |s: &State| masses.iter().map(|p| s.x[*p]).collect::<Vec<f64>>();
    let mirror: Vec<f64> = start.iter().rev().map(|v| -v).collect();
    (0..n + 1).for_each(|_| tick(&scene, &mut s));
    within("A08 half a period mirrors", apart(&now(&s), &mirror), tolerance);
    (0..period - n - 1).for_each(|_| tick(&scene, &mut s));
    within("A08 one period", apart(&now(&s), &start), tolerance);
    (0..99 * period).for_each(|_| tick(&scene, &mut s));
    within("A08 a hundred periods", apart(&now(&s), &start), tolerance);
    let shape: Vec<f64> = (1..=n).map(|i| (i as f64 * PI / (n as f64 + 1.0)).sin()).collect();
    let f = warped_frequency(mode(&scene, &masses, &shape).0, FS);
    within("A08 f₁", off(f, num(c, "values/f1")), tolerance);
}

#[test]
fn a12_a_mesh_at_its_limit() {
    let c = case("A12");
    let (lambda, limit) = (num(c, "values/lambda_max"), num(c, "values/a_limit"));
    let mesh = |a: f64| {
        scene(&format!(
            "[rate]\nsound = 1\n[MESH]\nm = {{ nx = 15, ny = 15, m = 1, k = {a:?} }}\n[SOX]\nout = {{ from = \"m[0,0]\" }}\n"
        ))
    };
    let unit = mesh(1.0);
    assert!(unit.certificate.bound >= lambda && unit.certificate.bound <= num(c, "values/gershgorin"));
    assert!(unit.certificate.lower <= lambda);
    let places: Vec<usize> = (0..225).map(|i| mat(&unit, &format!("m[{},{}]", i / 15, i % 15))).collect();
    let wave = |i: usize| ((i as f64 + 0.5) * 14.0 * PI / 15.0).cos();
    let shape: Vec<f64> = (0..225).map(|i| wave(i / 15) * wave(i % 15)).collect();
    let (measured, stray) = mode(&unit, &places, &shape);
    within("A12 λ of the highest mode", off(measured, lambda), num(c, "tolerance/rel"));
    within("A12 it is a mode", stray, 1e-13);
    for (side, a) in [(-1.0, limit * (1.0 - 1e-6)), (1.0, limit * (1.0 + 1e-6))] {
        let scene = mesh(a);
        let mut s = scene.state();
        places.iter().zip(&shape).for_each(|(p, v)| s.x[*p] = *v);
        (0..20_000).for_each(|_| tick(&scene, &mut s));
        let largest = s.x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        // below: bounded by about 1/√(4 − λ); above: e^(2√1e-6 n)
        assert_eq!(largest > 1e6, side > 0.0, "a = {a}: {largest}");
        // this near the limit the cheap bounds do not decide, so a factorisation does; far below it is not needed
        let level = if side > 0.0 { Level::Unstable } else { Level::Proven };
        assert_eq!((scene.certificate.level, scene.certificate.exact), (level, true));
    }
    assert!(mesh(0.499).certificate.level == Level::Proven && !mesh(0.499).certificate.exact);
}
