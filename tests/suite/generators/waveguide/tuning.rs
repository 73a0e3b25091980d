//! Pitch and decay of waveguides.

use super::{pole, poles, string};
use crate::acoustics::cents;
use crate::play::{TURN, case, num, off, rows, scene, within};
use ca_core::Scene;
use ca_core::internal::op::layout::Termination;
use ca_core::internal::tuning::wave::Loss;

/// Filters of the only string of a scene, from its near end to the far one, and its total delay in whole samples.
fn loop_of(scene: &Scene) -> (Vec<Loss>, usize) {
    let mut all = (Vec::new(), 0);
    for d in &scene.waves.delays {
        all.1 += d.len;
        if let Termination::Lossy { loss, .. } = d.end {
            all.0.push(loss);
            all.1 -= 3;
        }
    }
    // taps and the allpass of the near end are whole samples too
    all.1 += 2 * (all.0.len() - 1);
    all
}

fn gain(losses: &[Loss], f: f64) -> f64 {
    losses.iter().map(|l| l.a + 2.0 * l.b * (TURN * f / 48e3).cos()).product()
}

/// With a massless junction the string is the loop of the reference: same delay and filter, and a pole at the pitch.
#[test]
fn g01_the_pole_is_at_the_pitch() {
    let c = case("G01");
    for row in rows(c, "values/rows") {
        let [f0, g, a, whole, allpass, f_pole, t60_pole] = [0, 1, 2, 3, 4, 5, 6].map(|i| row[i]);
        let [partial, ratio, t60_partial] = [7, 8, 9].map(|i| row[i]);
        let theirs = [Loss { a: g * (1.0 - 2.0 * a), b: g * a, c: allpass }];
        let t60 = |f: f64| -3.0 / (f0 * gain(&theirs, f).log10());
        let text = string(
            &format!("f = {f0}, t60 = {:?}, t60_high = {:?}, z = 1, at = 0.3, m = 1e-12", t60(f0), t60(5000.0)),
            "",
        );
        let scene = scene(&text);
        let (losses, delay) = loop_of(&scene);
        assert_eq!((delay, losses.len()), (whole as usize, 2), "{f0} Hz");
        within("G01 allpass", (losses[1].c - allpass).abs(), 1e-5);
        within("G01 gain at the pitch", off(gain(&losses, f0), gain(&theirs, f0)), 1e-5);
        // `t60_high` is of the pole, which loses in the allpass too
        within("G01 gain at 5 kHz", off(gain(&losses, 5000.0), gain(&theirs, 5000.0)), 1e-4);
        within("G01 pitch of the reference", cents(f_pole, f0).abs(), num(c, "tolerance/f_cents"));
        // decay of the reference's own pole, which differs slightly from the gain at the pitch
        within("G01 decay of the reference", off(t60(f0), t60_pole), 2e-3);
        // the matrices of longer strings would take too long
        if f0 > 200.0 {
            let (f, t) = pole(&poles(&scene), scene.rate, f0);
            within("G01 pitch", off(f, f0), 1e-11);
            within("G01 decay", off(t, t60(f0)), 1e-7);
            let (f, t) = pole(&poles(&scene), scene.rate, partial * f0);
            within("G01 partial", off(f / (partial * f0), ratio), 1e-4);
            within("G01 decay of the partial", off(t, t60_partial), 0.02);
        }
    }
}

/// Heavy junctions, two or three of them, and fast decays: pitch and decay of the fundamental stay as given.
#[test]
fn junctions_cost_no_pitch() {
    for (f, t60, at, m) in [
        (523.25, 4.0, "[0.11, 0.62]", 3e-5),
        (700.0, 0.1, "[0.2, 0.5, 0.7]", 1e-4),
        (1234.5, 1.0, "0.37", 2e-4),
        (987.7, 0.02, "[0.3]", 1e-9),
    ] {
        let scene = scene(&string(&format!("f = {f}, t60 = {t60}, z = 0.7, at = {at}, m = {m}"), ""));
        let (heard, decay) = pole(&poles(&scene), scene.rate, f);
        within("pitch by its pole", off(heard, f), 1e-11);
        within("decay by its pole", off(decay, t60), 1e-7);
    }
}

/// A partial at `f_high` has the second decay if the junctions are light, also if most of the loss is there; the error
/// is at most m/(zT) for a junction of mass m.
/// The first compilation gives the frequency of the partial, which the second decay moves by less than its width.
#[test]
fn a_partial_at_the_second_frequency_has_the_second_decay() {
    for (f, t60, [about, high], at, m) in [
        (440.0, 4.0, [5280.0, 0.6], "0.3", 1e-13),
        (220.0, 3.0, [5000.0, 0.5], "[0.13, 0.6]", 1e-13),
        (880.0, 1.5, [3500.0, 0.2], "0.21", 1e-13),
        (440.0, 4.0, [5280.0, 0.6], "0.3", 1e-9),
        (880.0, 1.5, [3500.0, 0.2], "0.21", 1e-8),
    ] {
        let asked = |f_high: f64| {
            let text =
                format!("f = {f}, t60 = {t60}, t60_high = {high}, f_high = {f_high:?}, z = 0.7, at = {at}, m = {m}");
            let scene = scene(&string(&text, ""));
            let all = poles(&scene);
            (pole(&all, scene.rate, f), pole(&all, scene.rate, f_high))
        };
        let mut f_high = about;
        for _ in 0..3 {
            f_high = asked(f_high).1.0;
        }
        let (first, second) = asked(f_high);
        within("pitch", off(first.0, f), 1e-10);
        within("T60", off(first.1, t60), 1e-6);
        within("frequency of the partial", off(second.0, f_high), 1e-9);
        within("T60 of the partial", off(second.1, high), 1e-6 + m * 48e3 / 0.7);
    }
}

/// The partial nearest to `f_high` has the second decay as far as its frequency agrees.
#[test]
fn it_decays_as_asked_at_both_frequencies() {
    let scene = scene(&string("f = 440, t60 = 4, t60_high = 0.6, f_high = 5280, z = 1, at = 0.3, m = 1e-9", ""));
    // the decay is of the pole, not of the gain at a real frequency
    within("gain of a round trip", off(gain(&loop_of(&scene).0, 5280.0), 10f64.powf(-3.0 / (440.0 * 0.6))), 1e-3);
    let all = poles(&scene);
    let (f, t) = pole(&all, scene.rate, 5280.0);
    within("T60 at 12 f", off(t, 0.6), 0.01);
    assert!(cents(f, 5280.0).abs() < 1.0, "partial 12 at {f} Hz");
    let decays: Vec<f64> = (1..=40).map(|j| pole(&all, scene.rate, 440.0 * f64::from(j)).1).collect();
    assert!(decays.windows(2).all(|d| d[1] < d[0]), "{decays:?}");
}

#[test]
fn without_t60_it_rings_for_ever() {
    let scene = scene(&string("f = 600, z = 1, at = [0.2, 0.6], m = 1e-5", ""));
    let all = poles(&scene);
    within("radius", (super::radius(&all) - 1.0).abs(), 1e-12);
    within("pitch", off(pole(&all, scene.rate, 600.0).0, 600.0), 1e-11);
}
