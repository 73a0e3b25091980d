//! Struck, plucked, touched and stopped strings: partials, decay, and the effects of playing.

use super::closed_forms::sin2;
use super::rendering::{Rendering, by_hand, count_contacts, perform, play, scene};
use crate::acoustics::{centroid, cents, damping, db, mode, partial, peak, period, rms, stiffness, t60};
use crate::play::PI;

pub fn hammered_string() {
    let h = play("hammered_string", &["strike"]);
    h.assert_partials(0, [4.2, 6.8], (1..=8).map(|j| h.string("low", j).0), 20.0, 1.0);
    let (f, t) = h.string("low", 1);
    let measured = t60(h.at(0, 4.2, 6.9), h.rate, f);
    assert!((measured / t - 1.0).abs() < 0.01, "T60 {measured:.3} s, analytic {t:.3} s");
    // five strokes of one contact each, each harder than the last
    let strokes = [0.1, 0.9, 1.7, 2.5, 3.3];
    assert_eq!(count_contacts(&h.probe[0], h.rate), 5);
    let force = strokes.map(|t| peak(h.probed(0, t, t + 0.2)));
    assert!(force.windows(2).all(|w| w[1] > 1.1 * w[0]), "{force:?}");
    let colour = strokes.map(|t| centroid(h.at(0, t + 0.05, t + 0.25), h.rate));
    assert!(colour[4] > 1.5 * colour[0], "{colour:.0?} Hz");
    // a key that rises slowly is silent; with a weakly damped arm the hammer strikes twice
    let slow = by_hand(&h.model, &[], &[("key", &[(0.0, -8e-3), (0.5, 0.0)])], 1.0);
    assert_eq!(peak(&slow.sound[0]), 0.0);
    let mut lively = h.model.clone();
    assert!(lively.set("rest", "2 N s/m"));
    let scene = scene(&lively, &["strike"]);
    assert!(count_contacts(&perform(lively, &scene, None, 7.0).probe[0], h.rate) > 5);
}

pub fn plucked_string() {
    let h = play("plucked_string", &["pick.pluck"]);
    let tones: Vec<(f64, f64)> = (0..=20).map(|j| if j == 0 { (0.0, 0.0) } else { h.string("low", j) }).collect();
    h.assert_partials(1, [5.7, 7.8], tones[1..=8].iter().map(|t| t.0), 20.0, 1.0);
    assert!(cents(tones[1].0, 146.8324).abs() < 0.1, "D3");
    for j in [1, 10, 20] {
        let (f, t) = tones[j];
        let measured = t60(h.at(1, 5.3, 7.9), h.rate, f);
        assert!((measured / t - 1.0).abs() < 0.02, "partial {j}: T60 {measured:.3} s, analytic {t:.3} s");
    }
    // it lets go at k d, then the force is zero until the plectrum returns
    let drawn = |depth: f64| 0.275e-3 + 0.825e-3 * (depth + 8e-3) / 16e-3;
    for (from, to, depth) in
        [(0.1, 0.2, 3e-3), (1.4, 1.5, 3e-3), (2.5, 3.1, 3e-3), (3.9, 4.0, -8e-3), (4.3, 4.4, -3e-3), (5.1, 5.2, 8e-3)]
    {
        let most = peak(h.probed(0, from, to)) / (h.number("pick.pluck", "k") * drawn(depth));
        assert!((0.95..1.1).contains(&most), "{from} s: {most}");
        assert_eq!(peak(h.probed(0, to, to + 0.2)), 0.0, "{from} s");
    }
    assert_eq!(peak(h.probed(0, 5.2, 8.0)), 0.0);
    // up, down and slowly up are equally loud; four times the draw is 12 dB
    let loud = |from: f64, to: f64| {
        let held = h.probed(0, from, to).iter().rposition(|f| *f != 0.0).unwrap() as f64 / h.rate;
        db(rms(h.at(0, from + held, from + held + 0.3)))
    };
    let same = [(0.1, 0.2), (1.4, 1.5), (2.5, 3.1)].map(|(from, to)| loud(from, to));
    assert!(same.iter().all(|l| (l - same[0]).abs() < 1.0), "{same:?}");
    let plucked = |depth: f64| {
        let way = [(0.0, -4e-3), (0.1, -4e-3), (0.13, 4e-3), (0.8, 4e-3)];
        let deep = [(0.0, depth), (0.8, depth)];
        let h = by_hand(&h.model, &["pick.pluck"], &[("pick.key", &way), ("depth", &deep)], 0.8);
        let held = h.probed(0, 0.0, 0.8).iter().rposition(|f| *f != 0.0).unwrap() as f64 / h.rate;
        db(rms(h.at(0, held, held + 0.3)))
    };
    let swell = plucked(8e-3) - plucked(-8e-3);
    assert!((swell - 12.0).abs() < 1.0, "{swell:.2} dB");
}

pub fn natural_harmonic() {
    let h = play("natural_harmonic", &[]);
    let level = |j: usize, t0: f64, t1: f64| db(partial(h.at(0, t0, t1), h.rate, h.string("low", j).0, 15.0).1);
    for (n, touch) in [(3, 0.85), (2, 3.15), (4, 5.15), (5, 7.15)] {
        let (before, after) = ([touch - 0.5, touch - 0.05], [touch + 0.5, touch + 0.95]);
        for j in 1..=10 {
            let fell = level(j, before[0], before[1]) - level(j, after[0], after[1]);
            if j % n == 0 {
                assert!(fell < 15.0, "partial {j} has a node under the finger at 1/{n} and fell by {fell:.1} dB");
            } else {
                assert!(fell > 20.0, "partial {j} moves under the finger at 1/{n} and fell by only {fell:.1} dB");
            }
        }
        let loudest = (1..=10).max_by(|a, b| level(*a, after[0], after[1]).total_cmp(&level(*b, after[0], after[1])));
        assert_eq!(loudest.map(|j| j % n), Some(0), "1/{n}: {loudest:?}");
        h.assert_partials(0, after, [n, 2 * n].map(|j| h.string("low", j).0), 15.0, 1.0);
    }
    let pitch_is = partial(h.at(0, 1.4, 2.3), h.rate, 330.0, 30.0).0;
    assert!(cents(pitch_is, 330.0).abs() < 2.0);
}

pub fn pinched_string() {
    let h = play("pinched_string", &["from_below", "from_above"]);
    let pitch = |t0: f64, t1: f64, near: f64| partial(h.at(1, t0, t1), h.rate, near, 20.0).0;
    let (open, held, again) = (pitch(0.3, 1.1, 110.0), pitch(2.0, 3.15, 165.0), pitch(5.5, 7.8, 110.0));
    assert!(cents(open, h.string("low", 1).0).abs() < 1.0, "{open}");
    assert!(cents(again, h.string("low", 1).0).abs() < 1.0, "{again}");
    // a third of the string is cut off: a fifth, slightly less because fingers yield
    let fifth = cents(held / open, 1.5);
    assert!((-15.0..0.5).contains(&fifth), "{held} Hz: {fifth:.1} cents from a fifth");
    let low = partial(h.at(1, 2.0, 3.15), h.rate, 110.0, 20.0).1;
    assert!(low < 0.05 * partial(h.at(1, 2.0, 3.15), h.rate, 165.0, 20.0).1);
    // both sides press while it is held, neither when open
    assert!(h.probed(0, 2.0, 3.15).iter().chain(h.probed(1, 2.0, 3.15)).all(|f| *f != 0.0));
    assert_eq!(peak(h.probed(0, 3.4, 3.8)) + peak(h.probed(1, 3.4, 3.8)), 0.0);
    assert_eq!(peak(h.probed(0, 5.4, 8.0)) + peak(h.probed(1, 5.4, 8.0)), 0.0);
    // the thumb alone is a fret: the string leaves it and returns, which buzzes
    assert_eq!(peak(h.probed(1, 4.2, 5.2)), 0.0);
    assert!(touches(h.probed(0, 4.3, 5.0)) > 20, "{} touches", touches(h.probed(0, 4.3, 5.0)));
    let bright = |t0: f64, t1: f64| centroid(h.at(1, t0, t1), h.rate);
    assert!(bright(4.3, 4.8) > 1.2 * bright(0.2, 0.7), "{:.0} Hz, {:.0} Hz", bright(4.3, 4.8), bright(0.2, 0.7));
}

/// Number of times a force begins.
fn touches(force: &[f64]) -> usize {
    force.windows(2).filter(|w| w[0] == 0.0 && w[1] != 0.0).count()
}

pub fn wave_guitar() {
    let h = play("wave_guitar", &["pick.pluck"]);
    let f = h.number("low", "f");
    // harmonic except for the junctions: a bead m at β lowers partial j by m sin²(jπβ) over the mass of the string
    let (at, m) = (h.numbers("low", "at"), h.number("low", "m"));
    let whole = (h.number("low", "tension") * h.number("low", "mu")).sqrt() / (2.0 * f);
    let slower = |j: f64| at.iter().map(|b| m * (j * PI * b).sin().powi(2)).sum::<f64>() / whole;
    let partials = (1..=12).map(f64::from).map(|j| j * f * (1.0 + slower(1.0) - slower(j)));
    h.assert_partials(0, [1.0, 2.9], partials, 20.0, 0.3);
    let measured = t60(h.at(0, 0.2, 2.9), h.rate, f);
    assert!((measured / h.number("low", "t60") - 1.0).abs() < 0.01, "T60 {measured:.3} s");
    // beads reflect high partials slightly, which changes their decay; near 4.4 kHz the mean decay is the one given
    let rate: f64 = (36..=44).map(|j| 1.0 / t60(h.at(0, 0.2, 1.0), h.rate, f64::from(j) * f)).sum();
    let high = 9.0 / rate;
    assert!((high / h.number("low", "t60_high") - 1.0).abs() < 0.2, "T60 about partial 40: {high:.3} s");
    assert!(peak(h.probed(0, 0.0, 0.2)) > 0.5 && peak(h.probed(0, 0.2, 2.9)) == 0.0);
    // touched at half its length it sounds the octave: odd partials decay, even ones stay
    let level = |j: usize, t0: f64, t1: f64| db(partial(h.at(0, t0, t1), h.rate, j as f64 * f, 15.0).1);
    for j in 1..=6 {
        let fell = level(j, 3.2, 3.6) - level(j, 4.4, 4.8);
        assert!(if j % 2 == 0 { fell < 15.0 } else { fell > 20.0 }, "partial {j} fell by {fell:.1} dB");
    }
}

pub fn slide_guitar() {
    let h = play("slide_guitar", &[]);
    let f0 = h.string("neck", 1).0;
    let pitch = |t0: f64, t1: f64, near: f64| partial(h.at(0, t0, t1), h.rate, near, 12.0).0;
    // f / (1 − slide), slightly less because the bar yields
    for (slide, t0, t1) in [(0.1, 0.2, 0.5), (0.4, 1.9, 2.4), (0.4, 2.75, 3.15), (0.1, 4.4, 5.8)] {
        let ideal = f0 / (1.0 - slide);
        let off = cents(pitch(t0, t1, ideal), ideal);
        assert!((-25.0..5.0).contains(&off), "{t0} s: {off:+.1} cents from {ideal:.2} Hz");
    }
    // on the way it passes every pitch between
    let way: Vec<f64> = (0..5)
        .map(|i| 0.55 + 0.11 * f64::from(i))
        .map(|t| {
            let (p, _) = period(h.at(0, t, t + 0.08), h.rate, 1.0 / 145.0, 1.0 / 85.0);
            1.0 / p
        })
        .collect();
    assert!(way.windows(2).all(|w| w[1] > w[0]), "{way:?}");
}

pub fn harmonic_chain() {
    let names = ["string4", "string5", "string6"];
    let h = play("harmonic_chain", &["string4[12]", "string5[12]", "string6[12]"]);
    for (i, name) in names.iter().enumerate() {
        let samples = 2 * (h.number(name, "n") as usize + 1);
        // free between the last push and the damper: every sample repeats after 2(N + 1)
        let x = h.probed(i, 1.2, 4.4);
        let size = peak(x);
        let worst = x.iter().zip(&x[samples..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(size > 0.0 && worst < 1e-12 * size, "{name}: {worst:e} of {size:e} in {samples} samples");
        let f = h.rate / samples as f64;
        for j in 1..=20 {
            let (found, level) = partial(&x[..96_000], h.rate, f64::from(j) * f, 20.0);
            if db(level / size) > -50.0 {
                assert!((found / (f64::from(j) * f) - 1.0).abs() < 1e-6, "{name}, partial {j}: {found}");
            }
        }
    }
    let pitch = |name: &str| h.rate / (2.0 * (h.number(name, "n") + 1.0));
    assert!((pitch("string5") / pitch("string4") - 1.25).abs() < 1e-12, "a pure third");
    assert!((pitch("string6") / pitch("string4") - 1.5).abs() < 1e-12, "a pure fifth");
    assert!(db(rms(h.at(0, 4.0, 4.4)) / rms(h.at(0, 5.8, 6.0))) > 30.0, "the damper does not stop it");
}

pub fn hoop() {
    let h = play("hoop", &[]);
    let n = h.number("hoop", "n") as usize;
    let zo = damping(h.number("hoop", "t60"), h.rate);
    let z = h.number("hoop", "z") / (h.number("hoop", "m") * h.rate);
    let shape = |j: usize| 4.0 * sin2(2 * j, n);
    let a = stiffness(h.number("hoop", "f"), zo, h.rate) / shape(1);
    let tone = |j: usize| mode(a * shape(j), zo + z * shape(j), h.rate);
    h.assert_partials(0, [0.4, 1.9], [1, 2, 4, 5].map(|j| tone(j).0), 6.0, 3.0);
    let measured = t60(h.at(0, 2.4, 4.8), h.rate, tone(1).0);
    assert!((measured / tone(1).1 - 1.0).abs() < 0.03, "T60 {measured:.3} s, analytic {:.3} s", tone(1).1);
    let strokes = [0.1, 2.0].map(|t| peak(h.at(1, t, t + 0.3)));
    assert!(strokes[1] > 1.2 * strokes[0], "{strokes:?}");
}

pub fn prepared_string() {
    let h = play("prepared_string", &["hammer.strike", "rattle", "hop", "loose.ring"]);
    // free; with the screw; with screw and rubber, each soft and loud; and free again
    let strokes = [0.1, 1.1, 2.6, 3.6, 5.1, 6.1, 7.0];
    assert_eq!(count_contacts(&h.probe[0], h.rate), strokes.len(), "one contact a stroke");
    let rattles = strokes.map(|t| touches(h.probed(1, t, if t < 6.6 { (t + 0.9).min(6.6) } else { t + 0.9 })));
    assert_eq!([rattles[0], rattles[1], rattles[6]], [0; 3], "the screw is away");
    assert!(rattles[2..6].iter().all(|n| *n > 5), "the screw rattles: {rattles:?}");
    let height = strokes.map(|t| 1e3 * h.probed(3, t, t + 0.9).iter().fold(0.0, |m: f64, v| m.max(*v)));
    assert!((0.4..3.0).contains(&height[0]) && (8.0..40.0).contains(&height[6]), "{height:.2?} mm");
    // without the ring: louder is brighter, and attached objects spread the partials
    let stroke = |washer: &str, time: f64, rubber: f64| {
        let mut m = h.model.clone();
        assert!(m.set("washer.m", washer) && m.set("loose.ring.x", "20 m"));
        let way = [(0.0, -8e-3), (0.1, -8e-3), (0.1 + time, 0.0), (0.2, 0.0), (0.3, -8e-3)];
        by_hand(&m, &["hop"], &[("hammer.key", &way), ("rubber", &[(0.0, rubber)])], 2.0)
    };
    let [soft, loud] = [0.025, 0.007].map(|time| stroke("1.5 g", time, 0.0));
    assert_eq!(peak(&loud.probe[0]), 0.0);
    let colour = [&soft, &loud].map(|g| centroid(g.at(0, 0.1, 0.6), h.rate));
    assert!(colour[1] > 1.2 * colour[0], "{colour:.0?} Hz");
    let fall = |g: &Rendering| db(rms(g.at(0, 0.2, 0.3)) / rms(g.at(0, 0.8, 0.9)));
    let (with, without) = (fall(&stroke("1.5 g", 0.007, 8e-3)), fall(&loud));
    assert!(with > without + 10.0, "{with:.1} dB with the rubber, {without:.1} dB without");
    let spread = |g: &Rendering| {
        let tones = (1..=8).map(|j| h.string("low", j).0);
        tones.map(|f| cents(partial(g.at(0, 0.4, 1.9), h.rate, f, 0.06 * f).0, f).abs()).fold(0.0, f64::max)
    };
    let (with, without) = (spread(&loud), spread(&stroke("10 mg", 0.007, 0.0)));
    assert!(with > 25.0 && without < 5.0, "{with:.1} cents with the washer, {without:.1} without");
}
