//! Instruments in space: the rattle in two manipulations, maracas, wind chimes, and a dropped jack.

use super::closed_forms::eigenvalues;
use super::plates::share;
use super::rendering::{Rendering, by_hand, count_contacts, load, perform, play, scene};
use crate::acoustics::{cents, db, mode, partial, peak, rms};
use ca_core::{Location, Scene};
use ca_io::gesture::{Gesture, Track};
use ca_model::Model;

/// Absolute positions [m] of the modules `names` over time, from probes of the same names in the same order.
struct Motion<'a> {
    rendering: &'a Rendering,
    rest: Vec<[f64; 3]>,
}

impl<'a> Motion<'a> {
    fn new(rendering: &'a Rendering, scene: &Scene, names: &[String]) -> Motion<'a> {
        let rest = names.iter().map(|n| {
            let symbol = scene.symbols.iter().find(|s| s.name == *n).unwrap_or_else(|| panic!("no `{n}`"));
            let Location::Mat(at) = symbol.location else { panic!("`{n}` is a link") };
            [0, 1, 2].map(|k| scene.places.rest[at as usize + k])
        });
        Motion { rest: rest.collect(), rendering }
    }

    fn at(&self, i: usize, n: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| self.rest[i][k] + self.rendering.probe[3 * i + k][n])
    }

    fn apart(&self, i: usize, j: usize, n: usize) -> f64 {
        let (a, b) = (self.at(i, n), self.at(j, n));
        (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
    }

    fn ticks(&self) -> usize {
        self.rendering.probe[0].len()
    }
}

fn played(name: &str) -> Rendering {
    let corners = ["low", "mid", "high"].iter().flat_map(|p| (0..4).map(move |i| format!("toy.{p}[{i}]")));
    let names: Vec<String> = std::iter::once("toy.ball".to_string()).chain(corners).collect();
    let mut probes: Vec<&str> = names.iter().map(String::as_str).collect();
    probes.push("keep[*]");
    let h = play(name, &probes);
    let scene = scene(&h.model, &[]);
    let motion = Motion::new(&h, &scene, &names);
    let keep = &h.probe[3 * names.len()..];
    let mut bent: f64 = 0.0;
    for n in 0..motion.ticks() {
        for corner in 1..13 {
            // a blow presses a corner in by less than a tenth of a millimetre per newton that a softer shell would give
            assert!(motion.apart(0, corner, n) < 46e-3, "{name}: a corner is outside, tick {n}");
        }
        for body in 0..3 {
            for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                let edge = motion.apart(1 + 4 * body + i, 1 + 4 * body + j, n);
                bent = bent.max((edge / 20e-3 - 1.0).abs());
            }
        }
    }
    // flying and turning are silent: no sound before the first blow
    let first = (0..motion.ticks()).find(|n| keep.iter().any(|f| f[*n] != 0.0)).expect("a blow");
    let loudest = peak(&h.sound[0]);
    assert!(first > 200 && peak(&h.sound[0][..first]) < 1e-9 * loudest, "{name}: a sound of nothing");
    let count: usize = keep.iter().map(|f| count_contacts(f, h.rate)).sum();
    assert!((60..5000).contains(&count), "{name}: {count} blows");
    let level = |t0: f64, t1: f64| db(rms(h.at(0, t0, t1)));
    assert!(bent < 0.016, "{name}: an edge bends by {bent}");
    assert!(level(0.5, 4.7) > level(6.0, 7.0) + 12.0, "{name}: {} dB, {} dB", level(0.5, 4.7), level(6.0, 7.0));
    // blows of a fifth of a millisecond give a sharp sound
    let mut lengths: Vec<f64> = keep.iter().flat_map(|f| lengths(f)).map(|n| n as f64 / h.rate).collect();
    lengths.sort_by(f64::total_cmp);
    let middle = lengths[lengths.len() / 2];
    assert!((1e-4..4e-4).contains(&middle), "{name}: half of the blows are shorter than {middle} s");
    h
}

/// Length of each contact in ticks.
fn lengths(force: &[f64]) -> Vec<usize> {
    let runs = force.split(|f| *f == 0.0).map(<[f64]>::len);
    runs.filter(|n| *n > 0).collect()
}

pub fn rattle() {
    let h = played("rattle");
    // the blows are so short that most of the power is high
    let high = share(h.at(0, 0.5, 5.0), h.rate, 3e3, 24e3);
    assert!((high - 0.83).abs() < 0.06, "{high:.3} of the power is above 3 kHz");
    // the degraded experiments: without force feedback the sound of a given gesture is the same and no force is sent;
    // with a latency of 30 frames of 16 ticks the key moves 480 ticks later
    let push = || {
        let x = Track::points("key_x", vec![(0.0, 0.0), (0.1, 30e-3), (0.2, -30e-3), (0.3, 0.0)]).unwrap();
        let y = Track::points("key_y", vec![(0.0, 0.0), (0.15, 20e-3), (0.3, 0.0)]).unwrap();
        Gesture::new(vec![x, y]).unwrap()
    };
    let played = |key: &str, value: &str| {
        let mut m = load("rattle");
        assert!(m.set(key, value));
        let scene = scene(&m, &["key_x", "key_y"]);
        perform(m, &scene, Some(&push()), 0.4)
    };
    let (plain, numb, late) =
        (played("rate.latency", "0"), played("rate.feedback", "false"), played("rate.latency", "30"));
    assert!(peak(&plain.sound[0]) > 0.0);
    assert_eq!(numb.sound, plain.sound);
    for key in 0..2 {
        let n = plain.probe[key].len() - 480;
        assert_eq!(late.probe[key][480..], plain.probe[key][..n]);
    }
    assert!(late.sound != plain.sound);
}

pub fn rattle_stick() {
    let (stick, keys) = (played("rattle_stick"), load("rattle"));
    // the same motion of the sphere sounds the same
    let way = [vec![(0.0, 0.0), (0.1, 30e-3), (0.2, -30e-3), (0.3, 0.0)], vec![(0.0, 0.0), (0.15, 20e-3), (0.3, 0.0)]];
    let by_stick = by_hand(&stick.model, &[], &[("toy.stick.x", &way[0]), ("toy.stick.y", &way[1])], 0.5);
    let by_keys = by_hand(&keys, &[], &[("key_x", &way[0]), ("key_y", &way[1])], 0.5);
    assert!(peak(&by_keys.sound[0]) > 0.0);
    assert_eq!(by_stick.sound, by_keys.sound, "the manipulation differs, the instrument does not");
    let hands = ["key_x", "key_y", "toy.stick"];
    let ties = ["hold_x", "hold_y"];
    let body = |m: &Model| {
        let all = m.items.iter().filter(|i| !hands.contains(&i.name.as_str()) && !ties.contains(&i.name.as_str()));
        let bare = |i: &ca_model::Item| {
            let args: Vec<_> = i.args.iter().map(|e| (e.key.clone(), plain(&e.value))).collect();
            (i.kind.clone(), i.name.clone(), args)
        };
        all.map(bare).collect::<Vec<_>>()
    };
    assert_eq!(body(&stick.model), body(&keys));
}

/// A value without its source places.
fn plain(v: &ca_model::Value) -> String {
    use ca_model::Value;
    match v {
        Value::List(l) => format!("[{}]", l.iter().map(|e| plain(&e.value)).collect::<Vec<_>>().join(", ")),
        other => format!("{other:?}"),
    }
}

pub fn maracas() {
    let names: Vec<String> =
        std::iter::once("room.gourd".to_string()).chain((0..80).map(|i| format!("room.seeds[{i}]"))).collect();
    let probes: Vec<&str> = names.iter().map(String::as_str).collect();
    let h = play("maracas", &probes);
    let scene = scene(&h.model, &[]);
    let motion = Motion::new(&h, &scene, &names);
    for n in 0..motion.ticks() {
        for seed in 1..names.len() {
            assert!(motion.apart(0, seed, n) < 36e-3, "a seed has left the gourd, tick {n}");
        }
    }
    let high = share(h.at(0, 0.1, 3.5), h.rate, 3e3, 24e3);
    assert!((high - 0.95).abs() < 0.03, "{high:.3} of the power is above 3 kHz");
    // differences of the sound, to suppress contacts at rest on the skin
    let swing = |t0: f64, t1: f64| {
        let x = h.at(0, t0, t1);
        let d: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        db(rms(&d))
    };
    assert!(swing(0.3, 1.9) > swing(2.15, 2.4) + 4.0, "{} dB, {} dB", swing(0.3, 1.9), swing(2.15, 2.4));
    assert!(swing(2.5, 3.4) > swing(4.0, 4.5) + 12.0, "{} dB, {} dB", swing(2.5, 3.4), swing(4.0, 4.5));
}

pub fn chimes() {
    let tubes = ["a", "b", "c", "d", "e"];
    let knocks: Vec<String> = tubes.iter().map(|t| format!("knock_{t}")).collect();
    let probes: Vec<&str> = knocks.iter().map(String::as_str).collect();
    let h = play("chimes", &probes);
    let struck: Vec<usize> = (0..5).filter(|i| count_contacts(&h.probe[*i], h.rate) > 0).collect();
    assert!(struck.len() >= 3, "the wind reaches {struck:?}");
    for i in struck {
        // at its pitch, in the second after its last blow
        let last = h.probe[i].iter().rposition(|f| *f != 0.0).unwrap() as f64 / h.rate + 0.01;
        let to = (last + 1.0).min(h.sound[0].len() as f64 / h.rate);
        let f = h.number(&format!("tube_{}", tubes[i]), "f");
        let found = partial(h.at(i % 2, last, to), h.rate, f, 15.0).0;
        assert!(cents(found, f).abs() < 8.0, "tube {}: {found:.2} Hz, not {f}", tubes[i]);
    }
    // air damps the threads, and the tubes have decayed
    let end = (0..2).map(|c| db(peak(h.at(c, 10.9, 11.0)) / peak(&h.sound[c]))).fold(f64::MIN, f64::max);
    assert!(end < -50.0, "{end:.1} dB");
}

pub fn jack() {
    let names: Vec<String> = (0..7).map(|i| format!("room.jack[{i}]")).collect();
    let mut probes: Vec<&str> = names.iter().map(String::as_str).collect();
    probes.push("land[*]");
    let h = play("jack", &probes);
    let scene = scene(&h.model, &[]);
    let motion = Motion::new(&h, &scene, &names);
    for n in 0..motion.ticks() {
        for tip in 1..7 {
            assert!((motion.apart(0, tip, n) / 0.01 - 1.0).abs() < 0.02, "it is bent, tick {n}");
        }
    }
    let land = &h.probe[21..];
    let any: Vec<f64> = (0..motion.ticks()).map(|n| land.iter().map(|f| f[n]).sum()).collect();
    let struck = land.iter().filter(|f| f.iter().any(|f| *f != 0.0)).count();
    assert!(struck >= 4 && count_contacts(&any, h.rate) >= 20, "{struck} tips, {} blows", count_contacts(&any, h.rate));
    // it falls from 9 cm and ends on the skin with its weight alone
    let first = any.iter().position(|f| *f != 0.0).unwrap() as f64 / h.rate;
    assert!((0.13..0.14).contains(&first), "{first}");
    let weight = 7.0 * h.number("room.jack", "m") * 9.81;
    let end = any[any.len() - 1000..].iter().sum::<f64>() / 1000.0;
    assert!((-end / weight - 1.0).abs() < 0.02, "{end} N, {weight} N");
    // while it is in the air the skin sounds at its pitch
    let f = h.number("drum", "f");
    let found = partial(h.at(0, first + 0.01, first + 0.15), h.rate, f, 20.0).0;
    assert!(cents(found, f).abs() < 20.0, "{found:.2} Hz");
    assert!(rms(h.at(0, 3.0, 4.0)) < 1e-2 * rms(h.at(0, 0.0, 1.0)));
}

/// Eigenvalues of the stiffness of springs of 1 N/m on all edges of `length` between masses of 1 kg at `points`.
fn stretching(points: &[[f64; 3]], length: f64) -> Vec<f64> {
    let n = 3 * points.len();
    let mut k = vec![vec![0.0; n]; n];
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            let d = [0, 1, 2].map(|k| b[k] - a[k]);
            let l = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            if (l / length - 1.0).abs() > 1e-3 {
                continue;
            }
            let row: Vec<(usize, f64)> = (0..3).flat_map(|k| [(3 * i + k, -d[k] / l), (3 * j + k, d[k] / l)]).collect();
            for (p, u) in &row {
                for (q, v) in &row {
                    k[*p][*q] += u * v;
                }
            }
        }
    }
    eigenvalues(k)
}

pub fn crystal() {
    let h = play("crystal", &["hit[0]", "room.crystal[0]", "room.crystal[5]"]);
    let phi = f64::midpoint(1.0, 5f64.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [(1.0, phi), (1.0, -phi), (-1.0, phi), (-1.0, -phi)] {
        corners.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    let (k, m) = (h.number("room.crystal", "k"), h.number("room.crystal", "m"));
    let mut pitches: Vec<f64> = stretching(&corners, 2.0)
        .into_iter()
        .filter(|l| *l > 1e-6)
        .map(|l| mode(l * k / (m * h.rate * h.rate), 0.0, h.rate).0)
        .collect();
    pitches.sort_by(f64::total_cmp);
    assert_eq!(pitches.len(), 30, "{pitches:?}");
    // every strong partial of the ringing crystal is one of its modes
    let x = h.at(0, 0.3, 1.3);
    let mut heard = 0;
    for f in &pitches {
        let (found, strength) = partial(x, h.rate, *f, 10.0);
        if strength > 1e-3 * peak(x) {
            heard += 1;
            assert!(cents(found, *f).abs() < 5.0, "{found:.2} Hz, not {f:.2} Hz");
        }
    }
    assert!(heard >= 5, "{heard} modes are heard");
    // the body flies away: the middle of two opposite corners moves on
    let middle = |t: f64| {
        let n = (t * h.rate) as usize;
        [1, 2, 3].map(|k| 0.5 * (h.probe[k][n] + h.probe[k + 3][n]))
    };
    let far = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    assert!(far(middle(2.9), middle(0.1)) > 0.3, "it stays where it was");
}

pub fn tossed_grains() {
    let tubes: Vec<String> = (0..12).map(|i| format!("bar[{i}].tube.bar[1]")).collect();
    let mut probes: Vec<&str> = tubes.iter().map(String::as_str).collect();
    probes.push("toss[*]");
    let h = play("tossed_grains", &probes);
    let both = |a: f64, b: f64| rms(&[h.at(0, a, b), h.at(1, a, b)].concat());
    let loud = [(1.0, 2.2), (2.2, 3.4), (3.4, 4.6)].map(|(a, b)| db(both(a, b)));
    assert!(loud[1] > loud[0] && loud[2] > loud[1] && (loud[2] - loud[0] - 8.5).abs() < 1.5, "{loud:.1?} dB");
    // grains fall on all bars, which sound at their pitches
    for (i, note) in [4, 7, 9, 12, 14, 16, 19, 21, 24, 26, 28, 31].into_iter().enumerate() {
        let f = 440.0 * 2f64.powf((f64::from(note) - 9.0) / 12.0);
        let x = h.probed(i, 1.0, 6.0);
        let found = partial(x, h.rate, f, 15.0).0;
        assert!(peak(x) > 0.0 && cents(found, f).abs() < 8.0, "bar {i}: {found:.2} Hz, not {f:.2} Hz");
    }
    // the comb carries the weight of the grains when it lifts them
    let way = [(0.0, -40e-3), (0.5, -40e-3), (1.5, 25e-3), (3.0, 25e-3)];
    let lifted = by_hand(&h.model, &["toss[*]"], &[("key", &way)], 3.0);
    let mean = |p: &Vec<f64>| lifted.cut(p, 2.7, 3.0).iter().sum::<f64>() / (0.3 * h.rate);
    let (felt, weight) = (lifted.probe.iter().map(mean).sum::<f64>().abs(), 32.0 * 0.3e-3 * 9.81);
    assert!((felt / weight - 1.0).abs() < 0.1, "{felt} N of {weight} N");
}
