//! Bowed models: string, plate and glasses under a hand, and two strings under a pendulum.

use super::rendering::{Rendering, by_hand, play};
use crate::acoustics::{centroid, cents, db, envelope, partial, peak, period, rms, velocity};
use ca_model::Model;

/// Position of the bow on the string, and its pitch, D3.
const BETA: f64 = 12.0 / 101.0;
const D3: f64 = 146.832_4;

/// Slips per period, share of time that the string sticks, pitch [Hz] and periodicity.
struct Motion {
    slips: f64,
    sticks: f64,
    pitch: f64,
    like: f64,
}

/// Motion of the bowed mass from its positions `x`, under hair of speed `bow` [m/s].
fn motion(x: &[f64], rate: f64, bow: f64) -> Motion {
    let v = velocity(x, rate);
    let (p, like) = period(&v, rate, 0.8 / D3, 1.2 / D3);
    let slips = v.windows(2).filter(|w| w[0] * bow >= 0.0 && w[1] * bow < 0.0).count() as f64;
    let sticks = v.iter().filter(|v| *v * bow > 0.0).count() as f64 / v.len() as f64;
    Motion { slips: slips * rate / (v.len() as f64 * D3), sticks, pitch: 1.0 / p, like }
}

/// A steady stroke of `speed` [m/s] with `force` [N] for two seconds.
fn stroke(model: &Model, probes: &[&str], speed: f64, force: f64) -> Rendering {
    let draw = [(0.0, -0.22), (0.1, -0.22), (2.1, -0.22 + 2.0 * speed)];
    let press = [(0.0, 0.0), (0.1, force / 24.0)];
    by_hand(model, probes, &[("bow.draw", &draw), ("bow.press", &press)], 2.0)
}

pub fn bowed_string() {
    let h = play("bowed_string", &["low[11]"]);
    // up, down, and slow and soft: the string slips once per period and otherwise moves with the hair
    for (t0, t1, bow) in [(1.15, 1.7, 0.3), (2.95, 3.5, -0.3), (4.7, 5.2, 0.05)] {
        let m = motion(h.probed(0, t0, t1), h.rate, bow);
        assert!((m.slips - 1.0).abs() < 0.05, "{t0} s: {:.2} slips a period", m.slips);
        assert!((m.sticks - (1.0 - BETA)).abs() < 0.05, "{t0} s: sticks {:.3} of the time", m.sticks);
        assert!(cents(m.pitch, D3).abs() < 5.0 && m.like > 0.98, "{t0} s: {:.2} Hz, {:.3}", m.pitch, m.like);
    }
    assert!(db(rms(h.at(0, 5.85, 6.0)) / rms(h.at(0, 4.9, 5.2))) < -20.0, "it goes on under still hair");
    // force between the two limits gives Helmholtz motion from 0.03 to 0.6 m/s, louder with speed
    let mut levels = Vec::new();
    for speed in [0.03, 0.1, 0.3, 0.6] {
        let h = stroke(&h.model, &["low[11]"], speed, 0.6 + 6.0 * speed);
        let m = motion(h.probed(0, 1.4, 2.0), h.rate, speed);
        assert!((m.slips - 1.0).abs() < 0.05 && m.like > 0.98, "{speed} m/s: {:.2} slips a period", m.slips);
        levels.push(db(rms(h.at(0, 1.4, 2.0))));
    }
    assert!(levels.windows(2).all(|l| l[1] > l[0] + 3.0), "{levels:.1?} dB");
    // with less force it no longer slips once per period; with more it is raucous
    for speed in [0.1, 0.3] {
        let h = stroke(&h.model, &["low[11]"], speed, 0.6 + 1.2 * speed);
        let m = motion(h.probed(0, 1.4, 2.0), h.rate, speed);
        assert!((m.slips - 1.0).abs() > 0.5, "{speed} m/s with too little force: {:.2} slips a period", m.slips);
    }
    let hard = stroke(&h.model, &["low[11]"], 0.1, 5.0);
    let m = motion(hard.probed(0, 1.4, 2.0), hard.rate, 0.1);
    assert!(m.like < 0.95 || cents(m.pitch, D3).abs() > 20.0, "{:.2} Hz, likeness {:.3}", m.pitch, m.like);
    // force flattens the pitch and brightens the sound of the bridge
    let [light, firm] = [1.9, 3.4].map(|force| {
        let h = stroke(&h.model, &["low[11]", "bridge"], 0.3, force);
        let bridge = velocity(h.probed(1, 1.4, 2.0), h.rate);
        (motion(h.probed(0, 1.4, 2.0), h.rate, 0.3).pitch, centroid(&bridge, h.rate))
    });
    assert!(cents(firm.0, light.0) < -0.5, "{:.2} cents", cents(firm.0, light.0));
    assert!(firm.1 > 1.1 * light.1, "{:.0} Hz, {:.0} Hz", light.1, firm.1);
}

pub fn bowed_plate() {
    let h = play("bowed_plate", &[]);
    let steady = |speed: f64, force: f64| stroke(&h.model, &[], speed, force).at(0, 1.0, 2.0).to_vec();
    // force selects the mode; the other partials are harmonic to it
    let light = steady(0.2, 1.2);
    let (f, size) = partial(&light, h.rate, 309.0, 250.0);
    assert!((f / 309.0 - 1.0).abs() < 0.02, "{f:.1} Hz");
    let ninth = |x: &[f64]| partial(x, h.rate, 9.0 * f, 60.0).1 / partial(x, h.rate, f, 20.0).1;
    let firm = steady(0.2, 3.0);
    assert!(ninth(&firm) > 2.0 * ninth(&light), "{:.3}, {:.3}", ninth(&light), ninth(&firm));
    for (k, x) in [(2.5, &light), (3.5, &light)] {
        assert!(partial(x, h.rate, k * f, 40.0).1 < 0.1 * size, "{:.0} Hz is not harmonic", k * f);
    }
    let squeal = partial(&steady(0.2, 5.0), h.rate, 1300.0, 1200.0).0;
    assert!((squeal / 1240.0 - 1.0).abs() < 0.03, "{squeal:.0} Hz");
    // below about 1 N it is silent; a faster bow is louder
    let level = |x: &[f64]| db(rms(x));
    assert!(level(&steady(0.2, 0.6)) < level(&light) - 20.0, "{:.1} dB", level(&steady(0.2, 0.6)));
    assert!(level(&steady(0.4, 2.0)) > level(&steady(0.1, 2.0)) + 3.0);
}

pub fn glass() {
    let h = play("glass", &["rim[0]", "rim[1]", "rim[2]"]);
    let pitches = h.numbers("rim", "f");
    for (i, (f, t)) in pitches.iter().copied().zip([0.1, 1.2, 2.4]).enumerate() {
        assert!(peak(h.probed(i, 0.0, t)) < 1e-9, "rim {i} sounds before its time");
        let held = h.probed(i, 4.0, 4.5);
        let (note, size) = partial(held, h.rate, f, 15.0);
        assert!(cents(note, f).abs() < 12.0, "rim {i} is at {note:.2} Hz, not {f:.2} Hz");
        assert!(size > 5.0 * partial(held, h.rate, 2.0 * f, 15.0).1, "rim {i} is not pure");
        assert!(db(rms(held) / rms(h.probed(i, 6.8, 7.0))) > 20.0, "rim {i} goes on without its finger");
    }
    // from 0.02 to 0.3 m/s: a faster finger is louder and excites more of the stem, at three times the pitch
    let circle = |m: &Model, speed: f64| {
        let way = [(0.0, -0.3), (0.1, -0.3), (6.0, -0.3 + speed * 5.9)];
        let g = by_hand(m, &["rim[0]", "stem[0]"], &[("finger1", &way)], 6.0);
        let swell = envelope(g.probed(0, 5.0, 6.0), 9600);
        let wavers = swell.iter().map(|v| (v / swell[0] - 1.0).abs()).fold(0.0, f64::max);
        assert!(speed < 0.1 || wavers < 0.1, "{speed} m/s: it is not steady: {swell:?}");
        [0, 1].map(|i| partial(g.probed(i, 5.0, 6.0), h.rate, [1.0, 3.0][i] * pitches[0], [15.0, 45.0][i]).1)
    };
    let sizes = [0.02, 0.1, 0.3].map(|speed| circle(&h.model, speed));
    assert!(sizes[0][0] > 1e-6, "{sizes:?}");
    assert!(sizes.windows(2).all(|w| w[1][0] > 2.0 * w[0][0]), "{sizes:?}");
    let stem = sizes.map(|s| s[1] / s[0]);
    assert!(stem[1] > stem[0] && stem[2] > stem[1] && stem[2] > 3.0 * stem[0], "{stem:.3?}");
    // a rim that loses more than friction feeds does not start
    let mut short = h.model.clone();
    assert!(short.set("rim.t60", "0.5 s"));
    let still =
        rms(by_hand(&short, &[], &[("finger1", &[(0.0, -0.3), (0.1, -0.3), (6.0, 0.29)])], 6.0).at(0, 5.0, 6.0));
    assert!(still < 0.01 * rms(h.at(0, 4.0, 4.5)), "{still:e}");
}

pub fn physical_lfo() {
    let h = play("physical_lfo", &["pendulum", "low[36]"]);
    let f = h.number("pendulum", "f");
    let level = envelope(&velocity(h.probed(1, 0.0, 9.0), h.rate), 960);
    let (swell, like) = period(&level[..400], h.rate / 960.0, 0.3 / f, 0.7 / f);
    assert!((swell * 2.0 * f - 1.0).abs() < 0.03 && like > 0.6, "a swell every {swell:.3} s ({like:.2})");
    let slow: Vec<f64> = h.probed(0, 0.0, 10.0).iter().step_by(480).copied().collect();
    let (swing, like) = period(&slow, 100.0, 1.0, 3.0);
    assert!((swing * f - 1.0).abs() < 0.02 && like > 0.9, "swings every {swing:.3} s ({like:.2})");
    // sounding costs the pendulum more of its swing than its own losses
    let fall = |x: &[f64]| {
        let size = |t: f64| peak(h.cut(x, t, t + 2.0));
        1.0 - (size(8.0) / size(0.0)).powf(1.0 / 8.0)
    };
    let mut free = h.model.clone();
    assert!(free.set("rub.f", "0 N") && free.set("rub.fd", "0 N"));
    let free = by_hand(&free, &["pendulum"], &[], 10.0);
    let (with, without) = (fall(&h.probe[0]), fall(&free.probe[0]));
    assert!((with - 0.13).abs() < 0.015 && with > without + 0.01, "{with:.4} a second, {without:.4} by itself");
    for name in ["low", "fifth"] {
        let (note, _) = partial(h.at(0, 0.2, 0.8), h.rate, h.number(name, "f"), 8.0);
        assert!(cents(note, h.number(name, "f")).abs() < 35.0, "{name} sounds {note:.1} Hz");
    }
}
