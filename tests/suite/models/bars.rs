//! Bars: modes of what is struck, and how long each lasts.

use super::heard::{load, perform, play, scene};
use crate::acoustics::{centroid, cents, damping, db, eigenvalues, envelope, mode, partial, peak, rms, t60};

pub fn iron_bar() {
    let h = play("iron_bar", &[]);
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
    for (i, ratio) in [(3, 2.757), (4, 5.404)] {
        assert!((free[i] / free[2] / ratio - 1.0).abs() < 0.04, "{}", free[i] / free[2]);
    }
    for i in [5, 19] {
        k[i][i] += h.number("felts", "k") / (m * h.rate * h.rate);
    }
    let zo = damping(h.number("bar", "t60"), h.rate);
    let tones: Vec<f64> = eigenvalues(k).into_iter().map(|l| mode(l, zo, h.rate).0).collect();
    // without the losses of felts and bar the modes are exactly those of the matrix
    let mut bare = load("iron_bar");
    assert!(bare.set("felts.z", "0") && bare.set("bar.z", "0"));
    let scene = scene(&bare, &[]);
    perform(bare, &scene, None, 4.0).stands(0, [2.4, 4.0], tones[2..8].iter().copied(), 8.0, 1.0);
    // with them the first mode stays put
    assert!(cents(partial(h.at(1, 2.5, 3.3), h.rate, tones[2], 12.0).0, tones[2]).abs() < 15.0);
    let strokes = [0.1, 1.2, 2.3].map(|t| peak(h.at(0, t, t + 0.3)));
    assert!(strokes[0] < strokes[1] && strokes[1] < strokes[2], "{strokes:?}");
}

pub fn glass() {
    let h = play("glass", &["rim[0]", "rim[1]", "rim[2]"]);
    for (i, (f, t)) in h.numbers("rim", "f").into_iter().zip([0.1, 1.2, 2.4]).enumerate() {
        // silent before its finger moves, steady while it circles, dying when it stops
        assert!(peak(h.probed(i, 0.0, t)) < 1e-9, "rim {i} sounds before its time");
        let held = h.probed(i, 3.9, 4.4);
        let (note, size) = partial(held, h.rate, f, 15.0);
        assert!(cents(note, f).abs() < 12.0, "rim {i} is at {note:.2} Hz, not {f:.2} Hz");
        assert!(size > 5.0 * partial(held, h.rate, 2.0 * f, 15.0).1, "rim {i} is not pure");
        let steady = envelope(held, 4800);
        assert!(steady.iter().all(|v| (v / steady[0] - 1.0).abs() < 0.05), "rim {i}: {steady:?}");
        assert!(db(rms(held) / rms(h.probed(i, 6.6, 7.0))) > 20.0, "rim {i} goes on without its finger");
    }
}

pub fn marimba() {
    let h = play("marimba", &["low_bar[0]", "low_tube"]);
    let near = |x: &[f64], f: f64| cents(partial(x, h.rate, f, 20.0).0, f);
    assert!(near(h.at(0, 0.15, 0.65), 196.0).abs() < 15.0 && near(h.at(1, 0.75, 1.25), 293.66).abs() < 15.0);
    assert!(near(h.at(0, 0.13, 0.4), 784.0).abs() < 5.0, "the second partial is two octaves up");
    // the air swings wider than the wood that drives it
    assert!(rms(h.probed(1, 0.3, 0.6)) > 2.0 * rms(h.probed(0, 0.3, 0.6)));
    // and takes its energy: the bar dies sooner than by itself
    let alone = h.numbers("low_bar", "t60")[0];
    let with = t60(h.probed(0, 0.3, 1.2), h.rate, 196.0);
    assert!(with < 0.8 * alone, "T60 {with:.2} s, alone {alone:.2} s");
    assert!(centroid(h.at(0, 0.12, 0.22), h.rate) > centroid(h.at(0, 0.5, 0.8), h.rate));
}

pub fn kalimba() {
    let tines: Vec<String> = (0..7).map(|i| format!("tine[{i}].pluck[0]")).collect();
    let h = play("kalimba", &tines.iter().map(String::as_str).collect::<Vec<_>>());
    // the tune, one tine at a time: number and moment
    let scale = [261.6256, 293.6648, 329.6276, 349.2282, 391.9954, 440.0, 523.2511];
    for (tine, t) in [(0, 0.1), (2, 0.5), (4, 0.9), (6, 1.3), (5, 1.9), (3, 2.1), (1, 3.3)] {
        let (c, f) = (tine % 2, scale[tine]);
        let pitch_is = partial(h.at(c, t + 0.06, t + 0.39), h.rate, f, 8.0).0;
        assert!(cents(pitch_is, f).abs() < 5.0, "tine {tine} sounds {pitch_is:.2} Hz");
        // it holds on the way up, lets go, and on its way back 50 to 130 ms later is no more than brushed by what rings
        let pluck = peak(h.probed(tine, t, t + 0.04));
        assert!(pluck > 0.5, "tine {tine} is plucked with {pluck} N");
        let brushed = peak(h.probed(tine, t + 0.07, t + 0.19));
        assert!(brushed < 0.35 * pluck, "tine {tine} is plucked with {pluck} N and then with {brushed} N");
    }
    // the second mode is that of a clamped bar
    let over = partial(h.at(0, 0.12, 0.4), h.rate, 6.267 * scale[0], 40.0).0;
    assert!(cents(over, 6.267 * scale[0]).abs() < 60.0, "{over}");
    // a tine rings on in the others: the box joins them
    assert!(rms(h.at(0, 5.0, 5.5)) > 1e-4);
}
