//! Membranes, plates and gongs: modes of meshes, and the effect of hardening springs.

use super::closed_forms::sin2;
use super::rendering::{Rendering, by_hand, count_contacts, play, scene};
use crate::acoustics::{centroid, cents, damping, db, density, mode, partial, peak, rms, stiffness, t60};
use ca_tests::long_form::long_form;

/// λ of mode (p, q) of a closed (+1 on both sides) or open mesh, over a.
pub fn mesh(p: usize, q: usize, nx: usize, ny: usize) -> f64 {
    4.0 * (sin2(p, nx) + sin2(q, ny))
}

/// Share of the power below `hi` that is between `lo` and `hi` [Hz].
pub fn share(x: &[f64], rate: f64, lo: f64, hi: f64) -> f64 {
    let (d, bin) = density(x, rate, 4800);
    let sum = |lo: f64| d[(lo / bin) as usize..((hi / bin) as usize).min(d.len())].iter().sum::<f64>();
    sum(lo) / sum(0.0)
}

pub fn membrane() {
    let h = play("membrane", &["strike"]);
    let (nx, ny) = (h.number("skin", "nx") as usize - 1, h.number("skin", "ny") as usize - 1);
    let zo = damping(h.number("skin", "t60"), h.rate);
    let z = h.number("skin", "z") / (h.number("skin", "m") * h.rate);
    let a = stiffness(h.number("skin", "f"), zo, h.rate) / mesh(1, 1, nx, ny);
    let tone = |p, q| mode(a * mesh(p, q, nx, ny), zo + z * mesh(p, q, nx, ny), h.rate);
    let modes = [(1, 1), (2, 1), (1, 2), (2, 2), (3, 1)].map(|(p, q)| tone(p, q).0);
    h.assert_partials(0, [2.4, 3.4], modes, 6.0, 3.0);
    assert!(cents(modes[0], 147.0).abs() < 0.1);
    // strings have ratios 2, 3, 4; a skin does not
    assert!((modes[1] / modes[0] - 2.0).abs() > 0.3);
    let measured = t60(h.at(0, 2.5, 3.8), h.rate, modes[0]);
    assert!((measured / tone(1, 1).1 - 1.0).abs() < 0.03, "T60 {measured:.3} s, analytic {:.3} s", tone(1, 1).1);
    let colour = [0.1, 0.8, 1.5, 1.85].map(|t| centroid(h.at(0, t + 0.01, t + 0.3), h.rate));
    assert!((colour[0] / 470.0 - 1.0).abs() < 0.2 && (colour[3] / 900.0 - 1.0).abs() < 0.2, "{colour:.0?} Hz");
    // five strokes; a stick that rests on the skin mutes it
    assert_eq!(count_contacts(&h.probe[0], h.rate), 5);
    let way = |up: f64| [(0.0, -9e-3), (0.1, -9e-3), (0.112, 3e-3), (0.124, up), (1.0, up)];
    let level = |up: f64| rms(by_hand(&h.model, &[], &[("stick", &way(up))], 1.0).at(0, 0.6, 0.9));
    assert!(level(3e-3) < 0.4 * level(-9e-3), "{:.1} dB", db(level(3e-3) / level(-9e-3)));
}

pub fn plate() {
    let h = play("plate", &["sheet[0,0]", "strike"]);
    let (nx, ny) = (h.number("sheet", "nx") as usize, h.number("sheet", "ny") as usize);
    let zo = damping(h.number("sheet", "t60"), h.rate);
    let z = h.number("sheet", "z") / (h.number("sheet", "m") * h.rate);
    let a = stiffness(h.number("sheet", "f"), zo, h.rate) / mesh(1, 0, nx, ny);
    let tone = |p, q| mode(a * mesh(p, q, nx, ny), zo + z * mesh(p, q, nx, ny), h.rate).0;
    let modes = [(1, 0), (0, 1), (1, 1), (2, 0), (2, 1), (3, 0), (1, 2)].map(|(p, q)| tone(p, q));
    for f in modes {
        let found = partial(h.probed(0, 2.5, 4.1), h.rate, f, 6.0).0;
        assert!(cents(found, f).abs() < 3.0, "{found:.2} Hz is {:+.2} cents from {f:.2} Hz", cents(found, f));
    }
    // free edges: the lowest mode has half a wave along the long side, λ ∝ nx alone
    assert!(cents(tone(1, 0), h.number("sheet", "f")).abs() < 0.5);
    // half of the power is above 3 kHz; the palm takes 22 dB in 0.6 s
    let high = share(h.at(0, 0.1, 4.2), h.rate, 3e3, 24e3);
    assert!((high - 0.5).abs() < 0.15, "{high:.3}");
    let fell = db(rms(h.at(0, 4.1, 4.2)) / rms(h.at(0, 4.75, 4.85)));
    assert!((fell - 22.0).abs() < 4.0, "the palm takes {fell:.1} dB");
    let strokes = [0.1, 1.2, 2.3].map(|t| peak(h.at(0, t, t + 0.3)));
    assert_eq!(count_contacts(&h.probe[1], h.rate), 3);
    assert!(strokes[0] < strokes[1] && strokes[1] < strokes[2], "{strokes:?}");
}

fn both(h: &Rendering) -> Vec<f64> {
    h.sound[0].iter().zip(&h.sound[1]).map(|(a, b)| a + b).collect()
}

pub fn gong() {
    let h = play("gong", &[]);
    let all = both(&h);
    let colour = |t: f64| centroid(h.cut(&all, t, t + 0.15), h.rate);
    let (blow, bloom, late) =
        (colour(1.52), (0..4).map(|i| colour(1.7 + 0.1 * f64::from(i))).fold(0.0, f64::max), colour(4.5));
    assert!(bloom > 1.05 * blow, "blow {blow:.0} Hz, bloom {bloom:.0} Hz");
    assert!(late < 0.8 * bloom, "bloom {bloom:.0} Hz, late {late:.0} Hz");
    // energy moves to cells that the mallet does not reach: the share above 900 Hz doubles in 0.3 s
    let high = |t: f64| share(h.cut(&all, t, t + 0.15), h.rate, 900.0, 24e3);
    assert!((high(1.85) / high(1.52) - 2.0).abs() < 0.5, "{:.3} {:.3}", high(1.52), high(1.85));
    // a soft stroke excites few modes, and the palm damps
    assert!(colour(0.2) < 0.7 * bloom, "soft {:.0} Hz", colour(0.2));
    let fell = db(rms(h.cut(&all, 6.5, 7.0)) / rms(h.cut(&all, 7.7, 8.0)));
    assert!(fell > 15.0, "the palm takes {fell:.1} dB");
    // without the cubic springs the bells do not exchange energy
    let mut apart = h.model.clone();
    assert!(["next", "over", "leap"].iter().all(|l| apart.set(&format!("{l}.k3"), "0 N/m^3")));
    let g = by_hand(&apart, &[], &[("hand", &h.gesture("hand"))], 2.2);
    let alone = both(&g);
    assert!(share(g.cut(&alone, 1.85, 2.0), h.rate, 900.0, 24e3) < 0.2 * high(1.85));
}

pub fn tam_tam() {
    // the claims of its header are measured for the page of instruments
    if !long_form("spectra of the tam-tam") {
        return;
    }
    let h = play("tam_tam", &[]);
    let s = scene(&h.model, &[]);
    assert_eq!(s.mats() + s.lias(), 8798);
    let all = both(&h);
    let colour = |t: f64| centroid(h.cut(&all, t, t + 0.2), h.rate);
    for (t, f) in [(0.13, 320.0), (1.62, 840.0), (3.41, 1600.0)] {
        assert!((colour(t) / f - 1.0).abs() < 0.25, "{t} s: {:.0} Hz, not {f} Hz", colour(t));
    }
    let short = |t: f64| centroid(h.cut(&all, t, t + 0.05), h.rate);
    let way = [3.415, 3.515, 4.5].map(short);
    assert!(way[1] > 1.05 * way[0] && way[2] < 0.9 * way[1], "{way:.0?} Hz");
    let lowest = |t: f64| partial(h.cut(&all, t, t + 0.3), h.rate, 118.0, 14.0).0;
    assert!(
        (lowest(3.45) - 127.0).abs() < 3.0 && (lowest(6.8) - 110.0).abs() < 1.5,
        "{:.1} {:.1}",
        lowest(3.45),
        lowest(6.8)
    );
    let fell = db(rms(h.cut(&all, 6.9, 7.2)) / rms(h.cut(&all, 8.2, 9.0)));
    assert!(fell > 15.0, "the palm takes {fell:.1} dB");
}

pub fn snare() {
    let h = play("snare", &["centre.strike", "edge.strike", "wire[2].rattle[5]"]);
    assert_eq!([0, 1].map(|i| count_contacts(&h.probe[i], h.rate)), [8, 12], "one contact a stroke");
    // the same strokes with and without wires: a noisy tail, and a tom of the given pitch
    for t in [0.2, 0.7] {
        let tail = |t: f64| share(h.at(0, t + 0.06, t + 0.23), h.rate, 1500.0, 24e3);
        let (with, without) = (tail(t), tail(t + 3.1));
        assert!(with > 5.0 * without, "{t} s: {with:.4} of the power is high, without wires {without:.4}");
    }
    assert!(peak(h.probed(2, 0.2, 0.4)) > 0.0);
    assert_eq!(peak(h.probed(2, 3.25, 6.0)), 0.0, "the wires are down");
    let found = partial(h.at(0, 5.1, 5.9), h.rate, h.number("skin", "f"), 20.0).0;
    assert!(cents(found, h.number("skin", "f")).abs() < 5.0, "{found:.2} Hz");
}
