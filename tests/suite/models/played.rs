//! What is blown, turned, pressed or tilted: the gesture makes the sound.

use super::heard::{load, perform, play, scene};
use crate::acoustics::{cents, density, envelope, flatness, partial, peak, period, rms, slope, velocity};
use ca_io::gesture::{Gesture, Track};

pub fn wind() {
    let h = play("wind", &["air[13]", "air[4]", "whistle1", "whistle2", "whistle3", "whistle4"]);
    // the row of colliding masses is near white: its velocity is far flatter than any tone
    for i in 0..2 {
        let v = velocity(h.probed(i, 1.0, 5.0), h.rate);
        let flat = flatness(&v, h.rate, 100.0, 2000.0);
        assert!(flat > 0.7, "flatness {flat:.3}");
        let beat = period(&v[..24_000], h.rate, 0.002, 0.02).1;
        assert!(beat < 0.5, "it repeats itself: {beat:.2}");
    }
    // four oscillators sound in it, a little sharp as they harden
    for (i, name) in ["whistle1", "whistle2", "whistle3", "whistle4"].iter().enumerate() {
        let f = h.number(name, "f");
        let (d, bin) = density(h.probed(2 + i, 1.0, 5.0), h.rate, 9600);
        let band = |lo: f64, hi: f64| d[(lo / bin) as usize..(hi / bin) as usize].iter().sum::<f64>() / (hi - lo);
        let top = (50..(3000.0 / bin) as usize).max_by(|a, b| d[*a].total_cmp(&d[*b])).unwrap() as f64 * bin;
        assert!((0.97..1.12).contains(&(top / f)), "{name} is at {top:.0} Hz, not {f:.0} Hz");
        let over = 10.0 * (band(0.95 * f, 1.1 * f) / band(1.5 * f, 2.0 * f)).log10();
        assert!(over > 10.0, "{name} stands out by {over:.1} dB");
        // noise has no steady amplitude
        let swell = envelope(h.probed(2 + i, 1.0, 5.0), 2400);
        let mean = swell.iter().sum::<f64>() / swell.len() as f64;
        assert!(rms(&swell) > 0.1 * mean, "{name} is a tone");
    }
    assert!(rms(h.at(0, 6.8, 7.0)) < 0.1 * rms(h.at(0, 2.0, 5.0)), "no bow, no wind");
}

pub fn physical_lfo() {
    let h = play("physical_lfo", &["pendulum", "low[36]"]);
    let f = h.number("pendulum", "f");
    // two swells per swing, at the rate the pendulum really has
    let audible = velocity(h.probed(1, 0.0, 6.0), h.rate);
    let level = envelope(&audible, 960);
    let (swell, like) = period(&level[..250], h.rate / 960.0, 0.3 / f, 0.7 / f);
    assert!((swell * 2.0 * f - 1.0).abs() < 0.05 && like > 0.6, "a swell every {swell:.3} s ({like:.2})");
    let (swing, like) =
        period(&h.probed(0, 0.0, 6.0).iter().step_by(480).copied().collect::<Vec<_>>(), 100.0, 1.0, 3.0);
    assert!((swing * f - 1.0).abs() < 0.02 && like > 0.9, "swings every {swing:.3} s ({like:.2})");
    // sounding costs it its swing, far more than its own decay would
    let size = |t: f64| peak(h.probed(0, t, t + 2.0));
    assert!(size(4.0) < 0.8 * size(0.0), "{} {}", size(0.0), size(4.0));
    // and it plays the notes of the strings
    let x = h.at(0, 0.2, 0.8);
    for name in ["low", "fifth"] {
        let (note, _) = partial(x, h.rate, h.number(name, "f"), 8.0);
        assert!(cents(note, h.number(name, "f")).abs() < 35.0, "{name} sounds {note:.1} Hz");
    }
}

pub fn piano_key() {
    let h = play("piano_key", &["stop[0]", "strike_c[0]", "strike_e[0]", "strike_g[0]"]);
    // the key meets its bed and is held there; each hammer strikes and is free again
    assert!(h.probed(0, 0.2, 0.55).iter().all(|f| *f != 0.0) && peak(h.probed(0, 0.75, 1.9)) == 0.0);
    for (i, t) in [0.1, 0.5, 0.9].into_iter().enumerate() {
        assert!(peak(h.probed(1 + i, t, t + 0.1)) > 1.0, "hammer {i} does not strike");
        assert_eq!(peak(h.probed(1 + i, t + 0.2, t + 0.6)), 0.0, "hammer {i} stays");
    }
    // the chord on the bridge
    for (f, t) in [(261.63, 0.15), (329.63, 0.55), (392.0, 0.95)] {
        h.stands(0, [t, t + 0.8], [f], 12.0, 8.0);
        h.stands(0, [3.1, 3.9], [f], 12.0, 8.0);
    }
    assert!(peak(h.at(0, 3.0, 3.3)) > 2.0 * peak(h.at(0, 2.0, 2.3)), "a faster key is louder");
    // a key pressed slowly is silent: the hammer never arrives
    let scene = scene(&h.model, &[]);
    let slow = Track::points("c", vec![(0.0, -10e-3), (0.1, -10e-3), (0.6, -0.5e-3), (1.0, -0.5e-3)]).unwrap();
    let still = |name: &str| Track::points(name, vec![(0.0, -10e-3)]).unwrap();
    let gesture = Gesture::new(vec![slow, still("e"), still("g")]).unwrap();
    let quiet = perform(load("piano_key"), &scene, Some(&gesture), 1.0);
    assert_eq!(peak(&quiet.sound[0]), 0.0);
}

pub fn rain_stick() {
    let h = play("rain_stick", &["hop[4]", "hop[9]"]);
    // the first bead falls for √(2h/g), then hops, each hop shorter than the last by the same factor
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
    // chimes are where they are tuned
    for (i, f) in h.numbers("chime", "f").into_iter().enumerate() {
        let found = partial(h.at(i % 2, 0.1, 3.0), h.rate, f, 20.0).0;
        assert!(cents(found, f).abs() < 5.0, "chime {i}: {found:.2} Hz, not {f:.2} Hz");
    }
}
