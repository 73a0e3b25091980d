//! Piano keys: forces at the finger, repetition, and the wires they play.

use super::piano::{BED, Finger, UP, felt, one_key};
use super::rendering::{by_hand, count_contacts, play};
use crate::acoustics::{centroid, cents, db, partial, peak, rms};

/// Frequency [Hz] in equal temperament, `steps` from C4.
fn tempered(steps: i32) -> f64 {
    440.0 * 2f64.powf((f64::from(steps) - 9.0) / 12.0)
}

pub fn piano_key() {
    let names = ["key[0].strike", "key[1].strike", "key[2].strike"];
    let h = play("piano_key", &names);
    // one contact per stroke; the slow press at 5 s makes none, and each of the five from half release makes one
    assert_eq!([0, 1, 2].map(|i| count_contacts(&h.probe[i], h.rate)), [8, 3, 3]);
    assert_eq!(peak(h.probed(0, 4.9, 5.6)), 0.0);
    assert_eq!(count_contacts(h.probed(0, 5.65, 6.6), h.rate), 5);
    // the chord at the bridge, one note at a time and together, and louder with speed
    for (key, t) in [(0, 0.2), (4, 0.65), (7, 1.15)] {
        let f = tempered(key);
        h.assert_partials(0, [t, t + 0.4], [f], 12.0, 5.0);
        h.assert_partials(0, [3.4, 4.3], [f], 12.0, 5.0);
    }
    assert!(peak(h.at(0, 3.2, 3.5)) > 2.0 * peak(h.at(0, 2.0, 2.4)), "a faster key is louder");
    // force along the travel: weight, damper and hammer, let-off, drop and bed
    let mut f = Finger::new("piano_key");
    let down = f.line(BED + 1e-3, 0.01);
    for (mm, force) in [(0.5, 0.2), (3.3, 0.3), (7.5, 0.55), (9.1, 0.5)] {
        let is = felt(&down, UP + mm * 1e-3);
        assert!((is - force).abs() < 0.1, "{mm} mm: {is:.3} N, not {force} N");
    }
    let before: Vec<[f64; 2]> = down.iter().filter(|p| p[0] < UP + 9.1e-3).copied().collect();
    let top = before.iter().max_by(|a, b| (-a[1]).total_cmp(&-b[1])).unwrap();
    let (place, most) = (1e3 * (top[0] - UP), -top[1]);
    assert!((place - 8.78).abs() < 0.1 && (most - 1.05).abs() < 0.05, "let-off of {most:.3} N at {place:.2} mm");
    assert!(felt(&down, UP + 10e-3) > 1.5, "no bed");
    // repetition: thrown again from 4.5 mm and below, not from above; ten times a second from 4 mm
    let again = |back: f64| {
        let (up, bed) = (UP + back, 1.3e-3);
        let way = [(0.0, UP), (0.1, UP), (0.131, bed), (0.2, bed), (0.24, up), (0.34, up), (0.36, bed), (0.5, bed)];
        let h = by_hand(&h.model, &["key[0].strike"], &[("key[0].key", &way)], 0.6);
        count_contacts(&h.probe[0], h.rate)
    };
    assert_eq!([4e-3, 4.5e-3, 6e-3].map(again), [2, 2, 1]);
    let mut way = vec![(0.0, UP), (0.1, UP)];
    for i in 0..10 {
        let t = 0.1 + 0.1 * f64::from(i);
        way.extend([(t + 0.02, 1.3e-3), (t + 0.04, 1.3e-3), (t + 0.07, -4e-3), (t + 0.1, -4e-3)]);
    }
    let ten = by_hand(&h.model, &["key[0].strike"], &[("key[0].key", &way)], 1.3);
    assert_eq!(count_contacts(&ten.probe[0], h.rate), 10);
}

/// Sharpness [cents] of partial `j` against harmonics of `first` [Hz], searched near its place for stiffness `b`.
fn sharp(x: &[f64], rate: f64, first: f64, j: u32, b: f64) -> f64 {
    let k = f64::from(j);
    let near = k * first * ((1.0 + b * k * k) / (1.0 + b)).sqrt();
    cents(partial(x, rate, near, 10.0).0, k * first)
}

pub fn piano_wire() {
    let h = play("piano_wire", &["strike"]);
    assert_eq!(count_contacts(&h.probe[0], h.rate), 2, "one contact a stroke");
    let (c2, x) = (tempered(-24), h.at(0, 2.5, 7.9));
    let first = partial(x, h.rate, c2, 4.0).0;
    assert!(cents(first, c2).abs() < 2.0, "{first:.3} Hz");
    let b = h.number("wire.one", "b");
    assert!((sharp(x, h.rate, first, 7, b) - 47.5).abs() < 3.0, "{:.1} cents", sharp(x, h.rate, first, 7, b));
    let way = [2, 4, 7, 10].map(|j| sharp(x, h.rate, first, j, b));
    assert!(way.windows(2).all(|w| w[1] > w[0] + 3.0), "{way:.1?} cents");
    // two slopes of the level, because energy alternates between the two directions
    let level = |t: f64| db(rms(h.at(0, t, t + 0.25)));
    let fall = |t0: f64, t1: f64| 60.0 * (t1 - t0) / (level(t0) - level(t1));
    let (early, late) = (fall(2.1, 3.1), fall(5.1, 7.6));
    assert!((3.0..5.5).contains(&early) && (9.0..16.0).contains(&late), "T60 {early:.2} s, then {late:.2} s");
    let colour = [0.08, 0.25, 0.58].map(|speed| {
        let g = one_key(&h.model, "key", &["strike"], speed, 1.2, 1.2);
        assert_eq!(count_contacts(&g.probe[0], h.rate), 1, "{speed} m/s");
        centroid(g.at(0, 0.1, 1.2), h.rate)
    });
    for (is, f) in colour.into_iter().zip([202.0, 427.0, 545.0]) {
        assert!((is / f - 1.0).abs() < 0.2, "{colour:.0?} Hz");
    }
    assert_eq!(peak(&one_key(&h.model, "key", &["strike"], 0.04, 0.8, 0.8).probe[0]), 0.0);
    let fell = db(rms(h.at(0, 1.1, 1.3)) / rms(h.at(0, 1.75, 1.95)));
    assert!(fell > 25.0, "{fell:.1} dB");
}

pub fn piano24() {
    let names: Vec<String> = (0..24).flat_map(|i| [format!("key[{i}].strike"), format!("key[{i}].s.pin")]).collect();
    let h = play("piano24", &names.iter().map(String::as_str).collect::<Vec<_>>());
    let force: Vec<f64> = (0..24)
        .map(|i| {
            // each key once, and five of them again in the chord
            let strokes = 1 + usize::from([0, 7, 12, 16, 19].contains(&i));
            assert_eq!(count_contacts(&h.probe[2 * i], h.rate), strokes, "key {i}");
            let (f, t) = (tempered(i as i32 - 12), 0.1 + 0.2 * i as f64);
            let found = partial(h.probed(2 * i + 1, t + 0.12, t + 0.5), h.rate, f, 8.0).0;
            assert!(cents(found, f).abs() < 5.0, "key {i}: {found:.2} Hz, not {f:.2} Hz");
            peak(h.probed(2 * i, t, t + 0.15))
        })
        .collect();
    assert!(force.windows(2).all(|w| w[1] > w[0]), "ever louder: {force:.1?} N");
}
