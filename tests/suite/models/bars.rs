//! Bars: modes of struck bars, and their decay.

use super::closed_forms::eigenvalues;
use super::rendering::{by_hand, count_contacts, load, perform, play, scene};
use crate::acoustics::{centroid, cents, damping, mode, partial, peak, rms, t60};

pub fn iron_bar() {
    let h = play("iron_bar", &["hammer.strike"]);
    let n = h.number("bar", "n") as usize;
    let (m, bend) = (h.number("bar", "m"), h.number("bar", "kb"));
    // ½ B Σ (x_{i−1} − 2x_i + x_{i+1})² over inner nodes, and the felts
    let mut k = vec![vec![0.0; n]; n];
    for i in 1..n - 1 {
        for (a, wa) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
            for (b, wb) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                k[a][b] += bend * wa * wb / (m * h.rate * h.rate);
            }
        }
    }
    let free: Vec<f64> = eigenvalues(k.clone()).into_iter().map(|l| mode(l.max(0.0), 0.0, h.rate).0).collect();
    for (i, ratio) in [(3, 2.757), (4, 5.404), (5, 8.933)] {
        assert!((free[i] / free[2] / ratio - 1.0).abs() < 0.04, "{}", free[i] / free[2]);
    }
    for i in [5, 19] {
        k[i][i] += h.number("felts", "k") / (m * h.rate * h.rate);
    }
    let zo = damping(h.number("bar", "t60"), h.rate);
    let tones: Vec<f64> = eigenvalues(k).into_iter().map(|l| mode(l, zo, h.rate).0).collect();
    let mut bare = load("iron_bar");
    assert!(bare.set("felts.z", "0") && bare.set("bar.z", "0"));
    let scene = scene(&bare, &[]);
    perform(bare, &scene, None, 4.5).assert_partials(0, [2.5, 4.4], tones[2..8].iter().copied(), 8.0, 1.0);
    // with losses the first mode stays, near B2
    let first = partial(h.at(1, 2.5, 3.6), h.rate, tones[2], 12.0).0;
    assert!(cents(first, tones[2]).abs() < 15.0);
    // three strokes of one contact each; a louder one is brighter
    assert_eq!(count_contacts(&h.probe[0], h.rate), 3);
    let strokes = [0.1, 1.2, 2.3].map(|t| peak(h.at(0, t, t + 0.3)));
    assert!(strokes[1] > 1.2 * strokes[0] && strokes[2] > 1.2 * strokes[1], "{strokes:?}");
    let colour = [0.1, 1.2, 2.3].map(|t| centroid(h.at(0, t + 0.03, t + 0.3), h.rate));
    assert!(colour[2] > 1.1 * colour[0], "{colour:.0?} Hz");
    // the felts hardly damp the first mode but shorten the others
    let last = [2, 3, 4].map(|i| t60(h.at(1, 2.5, 4.0), h.rate, tones[i]));
    assert!(last[0] > 2.0 * last[1] && last[0] > 2.0 * last[2], "{last:.2?} s");
}

pub fn marimba() {
    let strikes: Vec<String> = (0..12).map(|i| format!("key[{i}].strike[0]")).collect();
    let h = play("marimba", &strikes.iter().map(String::as_str).collect::<Vec<_>>());
    let press = |time: f64| [(0.0, -8e-3), (0.1, -8e-3), (0.1 + time, 0.0), (0.15 + time, 0.0), (0.19 + time, -8e-3)];
    let scale = [196.0, 220.0, 246.942, 261.626, 293.665, 329.628, 349.228, 391.995, 440.0, 493.883, 523.251, 587.330];
    for (i, f) in scale.into_iter().enumerate() {
        let (key, bar) = (format!("key[{i}].key"), format!("bar[{i}]"));
        let names = [format!("{bar}.wood[0]"), format!("{bar}.tube"), strikes[i].clone()];
        let g = by_hand(&h.model, &names.each_ref().map(String::as_str), &[(&key, &press(0.015))], 1.4);
        for (ratio, to) in [(1.0, 1.3), (4.0, 0.6), (10.0, 0.4)] {
            let found = partial(g.at(0, 0.15, to), h.rate, ratio * f, 0.05 * ratio * f).0;
            assert!(cents(found, ratio * f).abs() < 2.0, "{bar}: {found:.2} Hz, not {:.2} Hz", ratio * f);
        }
        // the air moves more than the bar that drives it, and takes its energy: the bar decays faster than alone
        assert!(rms(g.probed(1, 0.3, 0.6)) > 2.0 * rms(g.probed(0, 0.3, 0.6)), "{bar}: the air is still");
        let (with, without) = (t60(g.probed(0, 0.3, 1.2), h.rate, f), h.numbers(&format!("{bar}.wood"), "t60")[0]);
        assert!(with < 0.8 * without, "{bar}: T60 {with:.2} s, alone {without:.2} s");
        assert_eq!(count_contacts(&g.probe[2], h.rate), 1, "{bar} is struck once");
    }
    let struck = [0.03, 0.013, 0.008].map(|time| {
        let g = by_hand(&h.model, &[&strikes[0]], &[("key[0].key", &press(time))], 0.6);
        (peak(&g.probe[0]), centroid(g.at(0, 0.15, 0.55), h.rate))
    });
    assert!(struck.windows(2).all(|w| w[1].0 > 1.3 * w[0].0 && w[1].1 > w[0].1), "{struck:.1?}");
    let climb =
        [(0, 0.1), (2, 0.45), (4, 0.8), (7, 1.15), (9, 1.5), (11, 1.85)].map(|(i, t)| peak(h.probed(i, t, t + 0.1)));
    assert!(climb.windows(2).all(|w| w[1] > w[0]), "{climb:.2?} N");
}

pub fn kalimba() {
    let tines: Vec<String> = (0..7).map(|i| format!("tine[{i}].pluck[0]")).collect();
    let h = play("kalimba", &tines.iter().map(String::as_str).collect::<Vec<_>>());
    // the tune, one tine at a time: number and time
    let scale = [261.6256, 293.6648, 329.6276, 349.2282, 391.9954, 440.0, 523.2511];
    for (tine, t) in [(0, 0.1), (2, 0.5), (4, 0.9), (6, 1.3), (5, 1.9), (3, 2.1), (1, 3.3)] {
        let (c, f) = (tine % 2, scale[tine]);
        let pitch_is = partial(h.at(c, t + 0.06, t + 0.39), h.rate, f, 8.0).0;
        // a tine is held on the way up and released; on its way back after 50 to 130 ms the pick touches it for about a
        // millisecond with a quarter of the force
        let pluck = peak(h.probed(tine, t, t + 0.04));
        let back = h.probed(tine, t + 0.05, t + 0.19);
        assert!(cents(pitch_is, f).abs() < 5.0, "tine {tine} sounds {pitch_is:.2} Hz");
        // `depth` rises from −6 mm to 2 mm in 2.3 s
        let depth = (-6e-3 + 8e-3 * t / 2.3).min(2e-3);
        let most = pluck / (3e3 * (0.1e-3 + 0.4e-3 * (depth + 8e-3) / 16e-3));
        assert!((0.9..1.25).contains(&most), "tine {tine} is plucked with {pluck} N, {most:.2} of what it takes");
        assert!(peak(back) < 0.3 * pluck, "tine {tine} is plucked with {pluck} N and then with {} N", peak(back));
        let touched = 1e3 * back.iter().filter(|f| **f != 0.0).count() as f64 / h.rate;
        assert!(touched < 1.6, "tine {tine} is touched for {touched:.2} ms on the way back");
    }
    // the second and third modes agree with a clamped bar
    for (ratio, to) in [(6.267, 0.4), (17.55, 0.25)] {
        let over = partial(h.at(0, 0.12, to), h.rate, ratio * scale[0], 40.0).0;
        assert!(cents(over, ratio * scale[0]).abs() < 60.0, "{over}");
    }
    let loud = [0.1, 3.1].map(|t| peak(h.probed(0, t, t + 0.04)));
    assert!(loud[1] > 1.5 * loud[0], "{loud:.2?} N");
    // the box couples the tines, so the others ring too
    assert!(rms(h.at(0, 5.0, 5.5)) > 1e-4);
}
