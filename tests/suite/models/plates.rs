//! Membranes, plates and gongs: modes of meshes.

use super::heard::play;
use crate::acoustics::{
    centroid, cents, damping, db, density, mode, partial, peak, rms, sin2, stiffness, t60, velocity,
};

/// λ of mode (p, q) of a closed (+1 on both sides) or open mesh, over a.
pub fn mesh(p: usize, q: usize, nx: usize, ny: usize) -> f64 {
    4.0 * (sin2(p, nx) + sin2(q, ny))
}

pub fn membrane() {
    let h = play("membrane", &[]);
    let (nx, ny) = (h.number("skin", "nx") as usize - 1, h.number("skin", "ny") as usize - 1);
    let zo = damping(h.number("skin", "t60"), h.rate);
    let z = h.number("skin", "z") / (h.number("skin", "m") * h.rate);
    let a = stiffness(h.number("skin", "f"), zo, h.rate) / mesh(1, 1, nx, ny);
    let tone = |p, q| mode(a * mesh(p, q, nx, ny), zo + z * mesh(p, q, nx, ny), h.rate);
    let modes = [(1, 1), (2, 1), (1, 2), (2, 2), (3, 1)].map(|(p, q)| tone(p, q).0);
    h.stands(0, [2.3, 3.3], modes, 6.0, 3.0);
    // strings have 2, 3, 4; a skin has not
    assert!((modes[1] / modes[0] - 2.0).abs() > 0.3);
    let measured = t60(h.at(0, 2.4, 3.6), h.rate, modes[0]);
    assert!((measured / tone(1, 1).1 - 1.0).abs() < 0.03, "T60 {measured:.3} s, analytic {:.3} s", tone(1, 1).1);
    let colour = |t: f64| centroid(&velocity(h.at(0, t, t + 0.2), h.rate), h.rate);
    assert!(colour(1.88) > 1.3 * colour(0.15), "rim {:.0} Hz, centre {:.0} Hz", colour(1.88), colour(0.15));
}

pub fn plate() {
    let h = play("plate", &["sheet[0,0]"]);
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
    // no border holds it: the lowest mode has the long side as half a wave, λ ∝ nx alone
    assert!(cents(tone(1, 0), h.number("sheet", "f")).abs() < 0.5);
    let (before, after) = (rms(h.at(0, 4.0, 4.2)), rms(h.at(0, 4.6, 4.8)));
    assert!(db(before / after) > 15.0, "the palm takes only {:.1} dB", db(before / after));
    let strokes = [0.1, 1.2, 2.3].map(|t| peak(h.at(0, t, t + 0.3)));
    assert!(strokes[0] < strokes[1] && strokes[1] < strokes[2], "{strokes:?}");
}

pub fn gong() {
    let h = play("gong", &[]);
    let both: Vec<f64> = h.sound[0].iter().zip(&h.sound[1]).map(|(a, b)| a + b).collect();
    let colour = |t: f64| centroid(h.cut(&both, t, t + 0.15), h.rate);
    let (blow, bloom, late) =
        (colour(1.52), (0..4).map(|i| colour(1.7 + 0.1 * f64::from(i))).fold(0.0, f64::max), colour(4.5));
    assert!(bloom > 1.2 * blow, "blow {blow:.0} Hz, bloom {bloom:.0} Hz");
    assert!(late < 0.8 * bloom, "bloom {bloom:.0} Hz, late {late:.0} Hz");
    // energy has climbed: the share of cells the mallet cannot reach grows after it has gone
    let high = |t: f64| {
        let (d, bin) = density(h.cut(&both, t, t + 0.15), h.rate, 4800);
        d[(900.0 / bin) as usize..(3000.0 / bin) as usize].iter().sum::<f64>() / d.iter().sum::<f64>()
    };
    assert!(high(1.85) > 1.5 * high(1.52), "{} {}", high(1.52), high(1.85));
    // a soft stroke wakes little
    assert!(colour(0.2) < 0.7 * bloom, "soft {:.0} Hz", colour(0.2));
}
