//! RING: modes against the closed form λ_j = 4a sin²(jπ/n), tuning, limit of stability, and moving points around it.

use crate::play::{PI, mat, mats, model, off, scene, within};
use ca_compile::{Options, analysis::modes::modes, compile};
use ca_core::{Level, tick};
use ca_tests::catalog;

const FS: f64 = 48_000.0;

fn ring(args: &str) -> String {
    format!("[RING]\nhoop = {{ {args} }}\n[SOX]\nout = {{ from = \"hoop[0]\", dc = 0 }}\n")
}

/// Frequency of mode `j` of `n` with warping, for a = kT²/m.
fn warped(a: f64, j: usize, n: usize) -> f64 {
    FS / PI * (a.sqrt() * (PI * j as f64 / n as f64).sin()).asin()
}

/// The modes in order of pitch: the rigid motion, then each twice, and the last once if `n` is even.
#[test]
fn its_modes_are_those_of_the_closed_form_each_twice() {
    for n in [3, 4, 9, 16] {
        let text = ring(&format!("n = {n}, m = 1, k = {:e}", 0.3 * FS * FS));
        let network = ca_compile::linear(&model(&text), &catalog(), &Options::default()).expect("it compiles");
        let found = modes(&network).expect("they are found").list;
        assert_eq!(found.len(), n);
        assert_eq!(found[0].heard, 0.0, "nothing holds it");
        for (at, mode) in found.iter().enumerate().skip(1) {
            within(&format!("{n}: mode {at}"), off(mode.heard, warped(0.3, at.div_ceil(2), n)), 1e-10);
        }
    }
}

/// The engine advances cos and sin around the ring by the same angle and keeps their shape.
#[test]
fn cos_and_sin_around_it_sound_the_same() {
    let n = 9;
    let scene = scene(&ring(&format!("n = {n}, m = 1, k = {:e}", 0.3 * FS * FS)));
    let places = mats(&scene, "hoop");
    assert_eq!(places.len(), n);
    for j in [1, 2] {
        let theta = 2.0 * PI * warped(0.3, j, n) / FS;
        for quarter in [0.0, 0.25] {
            let at = |i: usize| (2.0 * PI * (j as f64 * i as f64 / n as f64 - quarter)).cos();
            let mut s = scene.state();
            for (i, p) in places.iter().enumerate() {
                (s.x[*p], s.d[*p]) = (at(i), 2.0 * at(i) * (0.5 * theta).sin().powi(2));
            }
            for t in 0..4800 {
                let cos = (f64::from(t) * theta).cos();
                let worst = places.iter().enumerate().fold(0.0f64, |w, (i, p)| w.max((s.x[*p] - at(i) * cos).abs()));
                within(&format!("mode {j} from {quarter}, tick {t}"), worst, 1e-9);
                tick(&scene, &mut s);
            }
        }
    }
}

#[test]
fn a_pitch_that_is_asked_for_is_that_of_the_first_mode() {
    for (n, t60) in [(3, ""), (10, ""), (25, ", t60 = 0.5")] {
        let text = ring(&format!("n = {n}, m = \"1 g\", f = 440{t60}"));
        let network = ca_compile::linear(&model(&text), &catalog(), &Options::default()).expect("it compiles");
        let found = modes(&network).expect("they are found").list;
        within(&format!("{n}: first"), off(found[1].heard, 440.0), 1e-10);
        within(&format!("{n}: the mode of equal frequency"), off(found[2].heard, 440.0), 1e-10);
        if t60.is_empty() && n > 4 {
            let a = ((PI * 440.0 / FS).sin() / (PI / n as f64).sin()).powi(2);
            within(&format!("{n}: second"), off(found[3].heard, warped(a, 2, n)), 1e-10);
        }
    }
}

/// An even ring is refused at the limit, where its wave moves one mass per tick. One mass less is proven stable.
#[test]
fn at_the_limit_it_is_refused_and_what_is_advised_is_stable() {
    let text = |n: usize| ring(&format!("n = {n}, m = 1, f = 480, t60 = 4"));
    let said = compile(&model(&text(100)), &catalog(), &Options::default()).expect_err("at the limit");
    let said = said.list.iter().map(|d| format!("{} {}\n", d.title, d.help.clone().unwrap_or_default()));
    assert!(said.collect::<String>().contains("use at most 99 masses"));
    let scene = scene(&text(99));
    assert!(scene.findings.list.is_empty(), "{}", scene.findings);
    assert_eq!(scene.certificate.level, Level::Proven, "{:?}", scene.certificate);
}

/// The positions of a moving point cover the last link and end at the first mass again.
#[test]
fn its_way_is_closed() {
    let at = |s: &str| {
        format!(
            "[RING]\nhoop = {{ n = 4, m = 1, k = 1 }}\n[MAS]\nbob = {{ m = 1 }}\n[RES]\nr = {{ between = [\"bob\", \"hoop@{s}\"], k = 1 }}\n[SOX]\nout = {{ from = \"hoop@{s}\", dc = 0 }}\n"
        )
    };
    for (s, shares) in [("0", [1.0, 0.0]), ("0.875", [0.5, 0.5]), ("1", [1.0, 0.0])] {
        let scene = scene(&at(s));
        let mut state = scene.state();
        let [first, last] = ["hoop[0]", "hoop[3]"].map(|n| mat(&scene, n));
        (state.x[first], state.x[last]) = (0.01, 0.03);
        tick(&scene, &mut state);
        let want = 0.01 * shares[0] + 0.03 * shares[1];
        within(&format!("hoop@{s}"), (state.output[0] - want).abs(), 1e-12);
    }
}
