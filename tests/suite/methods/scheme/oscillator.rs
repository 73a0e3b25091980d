//! One oscillator: solution, start, warping, limit, damping.

use super::test_models::{FS, at, bob, mode, warped_frequency};
use crate::play::{PI, TURN, case, list, mat, num, off, rows, scene, within};
use ca_core::internal::tuning::retune;
use ca_core::{Level, tick};

#[test]
fn a01_the_oscillator_is_its_own_exact_solution() {
    let c = case("A01");
    let (m, k) = (num(c, "setup/m"), num(c, "values/k"));
    let scene = scene(&bob(FS, m, k, 0.0));
    let theta = 2.0 * (PI * num(c, "setup/f0") / FS).asin();
    let half = (0.5 * theta).sin();
    let i = mat(&scene, "bob");
    // x₀ − x₋₁ = 1 − cos θ, written without cancellation
    let mut s = at(&scene, i, 1.0, 2.0 * half * half);
    let (mut worst, mut turns) = (0.0f64, Vec::new());
    for n in 0..=48000u32 {
        worst = worst.max((s.x[i] - (f64::from(n) * theta).cos()).abs());
        for (key, when) in [("values/x_1000", 1000), ("values/x_48000", 48000)] {
            if n == when {
                within(key, (s.x[i] - num(c, key)).abs(), num(c, "tolerance/x_abs"));
            }
        }
        let before = s.x[i];
        tick(&scene, &mut s);
        if before < 0.0 && s.x[i] >= 0.0 {
            turns.push(f64::from(n) + before / (before - s.x[i]));
        }
    }
    within("A01 x against cos nθ", worst, num(c, "tolerance/x_abs"));
    let (lambda, _) = mode(&scene, &[i], &[1.0]);
    within("A01 f_sim", off(warped_frequency(lambda, FS), num(c, "values/f_sim")), num(c, "tolerance/f_rel"));
    let cycles = (turns.len() - 1) as f64 / (turns[turns.len() - 1] - turns[0]);
    within("A01 counted cycles", off(cycles * FS, num(c, "values/f_sim")), 1e-6);
}

#[test]
fn a01_a_start_at_rest_is_of_second_order() {
    let c = case("A01");
    let text = bob(FS, 1e-3, num(c, "values/k"), 0.0).replace("m = 0.001 }", "m = 0.001, dx0 = 1 }");
    let scene = scene(&text);
    let half = PI * 440.0 / FS;
    let s = scene.state();
    within("A01 d₀ of a start at rest", off(s.d[mat(&scene, "bob")], 2.0 * half * half), 1e-12);
}

#[test]
fn a02_warping() {
    let c = case("A02");
    let tolerance = num(c, "tolerance/rel");
    for row in rows(c, "values/rows_f0_fsim_cents") {
        let k = 1e-3 * (TURN * row[0]).powi(2);
        let linked = scene(&bob(FS, 1e-3, k, 0.0));
        let cell = scene(&format!("[CEL]\nbob = {{ m = 0.001, k = {k:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"));
        for scene in [&linked, &cell] {
            let f = warped_frequency(mode(scene, &[mat(scene, "bob")], &[1.0]).0, FS);
            within(&format!("A02 {} Hz", row[0]), off(f, row[1]), tolerance);
            let cents = 1200.0 * (f / row[0]).log2();
            within(&format!("A02 {} Hz in cents", row[0]), (cents - row[2]).abs(), 1e-9);
        }
        // a cell with `f` is not warped
        let asked =
            scene(&format!("[CEL]\nbob = {{ m = 0.001, f = {:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n", row[0]));
        let f = warped_frequency(mode(&asked, &[mat(&asked, "bob")], &[1.0]).0, FS);
        within(&format!("A02 {} Hz asked", row[0]), off(f, row[0]), tolerance);
    }
    // the highest frequency: a = 4
    within("A02 f_max", off(FS / PI, num(c, "values/f_max")), tolerance);
}

#[test]
fn a03_the_limit_and_who_says_so() {
    let c = case("A03");
    for (a, key) in [(3.99, "values/max_abs_a_3_99"), (4.0, "values/max_abs_a_4_0")] {
        let scene = scene(&bob(FS, 1.0, a * FS * FS, 0.0));
        let i = mat(&scene, "bob");
        let mut s = at(&scene, i, 1.0, 0.0);
        let mut largest = 0.0f64;
        for _ in 0..48000 {
            tick(&scene, &mut s);
            largest = largest.max(s.x[i].abs());
        }
        within(&format!("A03 max at a = {a}"), off(largest, num(c, key)), num(c, "tolerance/max_rel"));
    }
    let growing = scene(&bob(FS, 1.0, 4.01 * FS * FS, 0.0));
    let i = mat(&growing, "bob");
    let mut s = at(&growing, i, 1.0, 0.0);
    let mut last = 1.0;
    for _ in 0..5000 {
        last = s.x[i];
        tick(&growing, &mut s);
    }
    let growth = num(c, "values/growth_per_sample_a_4_01");
    within("A03 growth", off((s.x[i] / last).abs(), growth), num(c, "tolerance/growth_rel"));

    // one hertz, one kilogram: `a` is the stiffness itself
    for (a, level) in [(3.99, Level::Proven), (4.0, Level::Unstable), (4.01, Level::Unstable)] {
        let scene = scene(&bob(1.0, 1.0, a, 0.0));
        assert_eq!((scene.certificate.level, scene.certificate.bound), (level, a));
        let reported = scene.findings.list.iter().any(|d| d.code == "W103" && d.title.contains("`bob`"));
        assert_eq!(reported, level == Level::Unstable, "{}", scene.findings);
    }
}

#[test]
fn a04_the_damped_triangle() {
    let c = case("A04");
    let rho = list(c, "values/rho");
    for (row, rho) in rows(c, "setup/points_ab").iter().zip(rho) {
        let (a, b) = (row[0], row[1]);
        let linked = bob(FS, 1e-3, a * 1e-3 * FS * FS, b * 1e-3 * FS);
        let cell = format!(
            "[CEL]\nbob = {{ m = 0.001, k = {:?}, z = {:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n",
            a * 1e-3 * FS * FS,
            b * 1e-3 * FS
        );
        for text in [linked, cell] {
            let scene = scene(&text);
            let i = mat(&scene, "bob");
            let column = |x, d| {
                let mut s = at(&scene, i, x, d);
                tick(&scene, &mut s);
                (s.x[i], s.d[i])
            };
            let ((p, r), (q, t)) = (column(1.0, 0.0), column(0.0, 1.0));
            let (half, det) = (0.5 * (p + t), p * t - q * r);
            let under = half * half - det;
            let radius = if under < 0.0 { det.sqrt() } else { half.abs() + under.sqrt() };
            within(&format!("A04 ρ at a = {a}, b = {b}"), (radius - rho).abs(), num(c, "tolerance/rho_abs"));
            let level = if a + 2.0 * b < 4.0 { Level::Proven } else { Level::Unstable };
            assert_eq!(scene.certificate.level, level, "a = {a}, b = {b}");
        }
    }
}

#[test]
fn a05_a_cell_sounds_as_asked() {
    let c = case("A05");
    let tolerance = num(c, "tolerance/rel");
    for row in rows(c, "values/rows") {
        let [f, t60, m, fs, k, z] = row[..] else { panic!("six columns") };
        let tick_dt = 1.0 / fs;
        let (a, b) = retune(f, t60, tick_dt);
        within(&format!("A05 k at {f} Hz"), off(a * m / (tick_dt * tick_dt), k), tolerance);
        within(&format!("A05 z at {f} Hz"), off(b * m / tick_dt, z), tolerance);
        let scene = scene(&format!(
            "[rate]\nsound = {fs:?}\n[CEL]\nbar = {{ m = {m:?}, f = {f:?}, t60 = {t60:?} }}\n[SOX]\nout = {{ from = \"bar\" }}\n"
        ));
        let s = scene.state();
        let [p, q, mobility] = [0, 1, 2].map(|i| s.coef[i * scene.counts.n_mat + mat(&scene, "bar")]);
        within(&format!("A05 compiled m at {f} Hz"), off(tick_dt * tick_dt / mobility, m), tolerance);
        within(&format!("A05 compiled k at {f} Hz"), off(-q / mobility, k), tolerance);
        // P holds 1 − b, so b is exact only to half a unit in the last place of 1
        within(&format!("A05 compiled z at {f} Hz"), ((1.0 - p) - z * tick_dt / m).abs(), 0.5 * f64::EPSILON);
        assert_eq!(p, 1.0 - b);
    }
}
