//! Wind and rain stick: noise and rhythm from colliding masses.

use super::rendering::{by_hand, play};
use crate::acoustics::{cents, db, flatness, partial, peak, period, rms, slope, velocity};

pub fn wind() {
    let h = play("wind", &["air[13]", "air[4]"]);
    // the row of colliding masses is noise: its velocity is far flatter than a tone and is not periodic
    for i in 0..2 {
        let v = velocity(h.probed(i, 1.0, 5.0), h.rate);
        let flat = flatness(&v, h.rate, 100.0, 2000.0);
        let beat = period(&v[..24_000], h.rate, 0.002, 0.02).1;
        assert!(flat > 0.5, "flatness {flat:.3}");
        assert!(beat < 0.5, "it repeats itself: {beat:.2}");
    }
    // so is the sound, over the band of the twelve oscillators
    for c in 0..2 {
        let flat = flatness(h.at(c, 0.5, 5.5), h.rate, 211.0, 7030.0);
        assert!(flat > 0.2, "flatness {flat:.3}");
        assert!(rms(h.at(c, 6.6, 7.0)) < 0.1 * rms(h.at(c, 1.0, 5.0)), "no bow, no wind");
    }
    // faster is louder, by 15 dB from 0.05 to 2 m/s
    let level = |speed: f64| {
        let turn = 0.6 / speed;
        let mut way = vec![(0.0, -0.6)];
        let strokes = (3.0 / (2.0 * turn)).ceil() as usize + 1;
        way.extend((1..=strokes).map(|i| (i as f64 * 2.0 * turn, if i % 2 == 1 { 0.6 } else { -0.6 })));
        let g = by_hand(&h.model, &[], &[("hand", &way)], 3.0);
        db(rms(g.at(0, 1.0, 3.0)))
    };
    let levels = [0.05, 0.2, 0.6, 2.0].map(level);
    assert!(levels.windows(2).all(|l| l[1] > l[0]), "{levels:.1?}");
    assert!((levels[3] - levels[0] - 15.0).abs() < 3.0, "{levels:.1?}");
}

pub fn rain_stick() {
    let h = play("rain_stick", &["hop[4]", "hop[9]"]);
    // the first bead falls for √(2h/g), then hops, each hop shorter by the same factor
    let x0 = h.number("beads.e", "x");
    let mut strikes: Vec<f64> = Vec::new();
    for (i, w) in h.probe[0].windows(2).enumerate() {
        let t = (i + 1) as f64 / h.rate;
        if w[0] == 0.0 && w[1] != 0.0 && strikes.last().is_none_or(|last| t - last > 0.01) {
            strikes.push(t);
        }
    }
    let fall = (2.0 * x0 / 9.81).sqrt();
    assert!((strikes[0] / fall - 1.0).abs() < 0.002, "strikes at {} s, falls in {fall:.4} s", strikes[0]);
    let hops: Vec<f64> = strikes.windows(2).map(|w| w[1] - w[0]).take(8).collect();
    assert!(hops.len() == 8 && hops[7] < 0.8 * hops[0], "{hops:?}");
    let line: Vec<[f64; 2]> = hops.iter().enumerate().map(|(i, h)| [i as f64, h.ln()]).collect();
    assert!(slope(&line) < -0.01, "{hops:?}");
    for (i, f) in h.numbers("chime", "f").into_iter().enumerate() {
        let found = partial(h.at(i % 2, 0.1, 3.0), h.rate, f, 20.0).0;
        assert!(cents(found, f).abs() < 5.0, "chime {i}: {found:.2} Hz, not {f:.2} Hz");
    }
    // the hops end, and the last is inaudible
    let end = (0..2).map(|c| db(peak(h.at(c, 6.9, 7.0)) / peak(&h.sound[c]))).fold(f64::MIN, f64::max);
    assert!(end < -60.0, "{end:.1} dB");
}
