//! STIFFSTRING: partials against f_k = k f √((1 + b k²)/(1 + b)), their known error, decay; also piano strings.

use crate::play::{PI, model, off, within};
use ca_compile::analysis::modes::modes;
use ca_compile::{Options, linear};
use ca_tests::catalog;

/// Pitch [Hz] and T60 [s] of all modes of a model text, lowest first.
fn tones(text: &str) -> Vec<(f64, f64)> {
    let network = linear(&model(text), &catalog(), &Options::default()).expect("it compiles");
    modes(&network).expect("they are found").list.iter().map(|m| (m.heard, m.t60)).collect()
}

fn string(args: &str) -> Vec<(f64, f64)> {
    tones(&format!("[STIFFSTRING]\nwire = {{ {args} }}\n[SOX]\nout = {{ from = \"wire[0]\", dc = 0 }}\n"))
}

fn partial(f: f64, b: f64, k: usize) -> f64 {
    let square = (k * k) as f64;
    k as f64 * f * ((1.0 + b * square) / (1.0 + b)).sqrt()
}

fn cents(is: f64, wanted: f64) -> f64 {
    1200.0 * (is / wanted).log2()
}

/// From the lowest piano note up to the limit of the masses: partials 1 and 2 exact, others with the known error.
#[test]
fn partials_are_stretched_as_b_says_and_flat_by_as_much_as_is_said() {
    for (n, f, b) in [
        (40, 27.5, 4e-4),
        (40, 130.81, 4e-4),
        (40, 490.0, 4e-4),
        (64, 65.41, 1.2e-3),
        (40, 55.0, 0.0),
        (100, 100.0, 1e-3),
    ] {
        let is = string(&format!("n = {n}, m = \"0.15 g\", f = {f}, b = {b}"));
        for k in [1, 2] {
            within(&format!("{n} masses, {f} Hz, b {b}: partial {k}"), off(is[k - 1].0, partial(f, b, k)), 1e-10);
        }
        // flat by ½ (8/45 + 2β/3) φ⁴ (k² − 1)(k² − 4) at a low pitch, φ = π/(2(n + 1)), β = b/φ²; by less at a high one
        let phi = PI / (2.0 * (n as f64 + 1.0));
        let most = |k: usize| {
            let square = (k * k) as f64;
            600.0 / 2f64.ln()
                * (8.0 / 45.0 + 2.0 * b / (3.0 * phi * phi))
                * phi.powi(4)
                * (square - 1.0)
                * (square - 4.0)
        };
        for k in 3..=n / 4 {
            let flat = -cents(is[k - 1].0, partial(f, b, k));
            assert!(
                flat > 0.0 && flat < 1.05 * most(k),
                "{n}, {f} Hz, b {b}: partial {k} is {flat:.3} cents flat, {:.3}",
                most(k)
            );
        }
        if f < 100.0 && b > 0.0 {
            let flat = -cents(is[n / 4 - 1].0, partial(f, b, n / 4));
            assert!(flat > 0.7 * most(n / 4), "the formula is more than a bound: {flat:.3}, {:.3} cents", most(n / 4));
        }
    }
}

/// The first partial is exact even if bending cannot stretch the second that far, or if the second is not audible.
#[test]
fn the_first_partial_is_exact_at_any_b() {
    for (n, f, b) in [(3, 1000.0, 1e6), (3, 5500.0, 0.0), (12, 200.0, 10.0), (40, 20.0, 1e4)] {
        let is = string(&format!("n = {n}, m = \"1 g\", f = {f}, b = {b}"));
        within(&format!("{n} masses, b {b}"), off(is[0].0, f), 1e-9);
        assert!(is.windows(2).all(|w| w[1].0 > w[0].0), "{n} masses, b {b}: {is:?}");
    }
}

/// `t60` damps all partials alike. The viscosity `z` of the links adds (z/m) 2 sin²(kπ/(2(n + 1))), independent of `b`.
#[test]
fn decay_is_as_stated() {
    let (n, m, z, t60) = (40, 0.15e-3, 0.5e-3, 14.0);
    let is = string(&format!("n = {n}, m = {m}, f = 55, b = 4e-4, t60 = {t60}, z = {z}"));
    for k in 1..=10 {
        let s = (k as f64 * PI / (2.0 * (n as f64 + 1.0))).sin();
        let rate = 3.0 * 10f64.ln() / t60 + z / m * 2.0 * s * s;
        within(&format!("partial {k}"), off(is[k - 1].1, 3.0 * 10f64.ln() / rate), 2e-3);
    }
}

/// Two piano strings of equal pitch on one pin. Modes in opposition leave the pin at rest and decay like a single
/// string. Modes in phase lose energy to the pin; up to 60 Hz each partial decays faster than the one below.
#[test]
fn strings_of_a_piano_are_inharmonic_and_ring_as_their_part_says() {
    for (f, tie) in [(27.5, 440.0), (55.0, 1250.0), (130.81, 4600.0)] {
        let is = tones(&format!(
            "[use]\ns = {{ part = \"piano_strings\", with = {{ f = {f}, f2 = {f}, tie = {tie} }} }}\n[SOX]\nout = {{ from = \"s.pin\", dc = 0 }}\n"
        ));
        let (m, z, b) = (0.15e-3, 0.5e-3, 4e-4);
        let mut first = 0.0;
        let mut together = f64::MAX;
        for k in 1..=8 {
            let s = (k as f64 * PI / 82.0).sin();
            let alone = 3.0 * 10f64.ln() / (3.0 * 10f64.ln() / 14.0 + z / m * 2.0 * s * s);
            let near: Vec<_> = is.iter().filter(|t| cents(t.0, partial(f, b, k)).abs() < 60.0).collect();
            assert_eq!(near.len(), 2, "{f} Hz, partial {k}: {near:?}");
            let opposed = near.iter().copied().max_by(|x, y| x.1.total_cmp(&y.1)).unwrap();
            within(&format!("{f} Hz, partial {k} in opposition"), off(opposed.1, alone), 3e-3);
            if k == 1 {
                first = opposed.0;
            }
            // the tie sharpens all partials of a string by nearly the same amount
            let stretched = cents(opposed.0, partial(first, b, k));
            assert!(stretched.abs() < 4.0, "{f} Hz: partial {k} is {stretched:.2} cents from where b puts it");
            let sounds = near.iter().map(|t| t.1).fold(f64::MAX, f64::min);
            assert!(
                f > 60.0 || sounds < together,
                "{f} Hz: partial {k} rings {sounds:.2} s, the one below {together:.2} s"
            );
            together = sounds;
        }
    }
}
