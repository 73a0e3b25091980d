//! Plucked, struck, bowed and touched strings.

use super::{BUILT, Claim, Instrument, Pitch, Stroke};
use crate::acoustics::{peak, velocity};

const NEVER_MORE: f64 = f64::INFINITY;
/// Where `low[5]` of 40 masses is bowed, as a part of the string.
const BOWED_AT: f64 = 6.0 / 41.0;

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 98.0, cut: BUILT.at(0.8, 1.8) }),
        soft: BUILT.at(0.1, 0.4),
        loud: BUILT.at(0.8, 1.8),
        decay: BUILT.at(4.0, 5.0),
        probes: &["low[5]"],
        // the hair goes there and back over the string, which the other key presses
        stroke: Stroke { script: "bow", rest: &[0.0, 0.008], depth: 0.0099, speed: 0.02, ..Stroke::DEFAULT },
        claims: &[Claim {
            says: "the string sticks for most of a period and slips once: Helmholtz motion",
            shows: "share of the time it moves with the hair, of 1 − β = 0.854: {}",
            measure: |p| {
                let (x, rate) = (p.probe("low[5]", BUILT.at(0.8, 1.8)), p.play(BUILT).rate);
                let v = velocity(&x, rate);
                // the hand goes 0.49 m in 1.9 s
                let sticks = v.iter().filter(|v| (**v - 0.49 / 1.9).abs() < p.number("hair.v0")).count();
                sticks as f64 / v.len() as f64
            },
            keeps: [1.0 - BOWED_AT - 0.1, 1.0 - BOWED_AT + 0.1],
        }],
        ..Instrument::new("bowed_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(3.5, 5.5) }),
        soft: BUILT.at(0.1, 0.8),
        loud: BUILT.at(3.3, 4.0),
        decay: BUILT.at(3.3, 6.0),
        probes: &["strike"],
        claims: &[
            Claim {
                says: "five strokes, soft to loud",
                shows: "least ratio of the force of a blow to that of the one before: {}",
                measure: |p| {
                    let blow = |i: f64| peak(&p.probe("strike", BUILT.at(0.1 + 0.8 * i, 0.3 + 0.8 * i)));
                    (1..5).map(|i| blow(f64::from(i)) / blow(f64::from(i - 1))).fold(f64::INFINITY, f64::min)
                },
                keeps: [1.1, NEVER_MORE],
            },
            Claim {
                says: "flies on, strikes and falls back",
                shows: "force between hammer and string from 0.2 s after the last stroke to the end: {} N",
                measure: |p| peak(&p.probe("strike", BUILT.at(3.6, 6.0))),
                keeps: [0.0, 0.0],
            },
        ],
        ..Instrument::new("hammered_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 200.0, cut: BUILT.at(0.11, 0.5) }),
        soft: BUILT.at(0.1, 0.5),
        loud: BUILT.at(1.2, 4.0),
        decay: BUILT.at(4.2, 6.0),
        probes: &["string4[12]"],
        claims: &[Claim {
            says: "each sample repeats exactly after 2 (N + 1) samples",
            shows: "largest difference of two samples 240 apart, as a part of the largest sample: {}",
            measure: |p| {
                let x = p.probe("string4[12]", BUILT.at(1.2, 4.4));
                let worst = x.iter().zip(&x[240..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                worst / peak(&x)
            },
            keeps: [0.0, 1e-12],
        }],
        ..Instrument::new("harmonic_chain")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 196.0, cut: BUILT.at(2.4, 4.8) }),
        soft: BUILT.at(0.1, 1.9),
        loud: BUILT.at(2.0, 4.0),
        decay: BUILT.at(2.0, 5.0),
        claims: &[Claim {
            says: "struck twice",
            shows: "second stroke above the first: {} dB",
            measure: |p| p.peak(BUILT.at(2.0, 2.3)) - p.peak(BUILT.at(0.1, 0.4)),
            keeps: [1.5, 10.0],
        }],
        ..Instrument::new("hoop")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 330.0, cut: BUILT.at(1.5, 2.3) }),
        soft: BUILT.way(0.7).at(0.1, 0.5),
        loud: BUILT.at(0.1, 0.5),
        decay: BUILT.at(3.6, 5.0),
        claims: &[Claim {
            says: "At a third remain 3 f, 6 f, 9 f",
            shows: "what partials 1, 2, 4 and 5 fall by, at least: {} dB",
            measure: |p| {
                let fell = |j: f64| {
                    let f = j * p.number("low.f");
                    p.partial(f, BUILT.at(0.4, 0.9)) - p.partial(f, BUILT.at(1.6, 2.1))
                };
                [1.0, 2.0, 4.0, 5.0].into_iter().map(fell).fold(f64::INFINITY, f64::min)
            },
            keeps: [20.0, NEVER_MORE],
        }],
        ..Instrument::new("natural_harmonic")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 65.406, cut: BUILT.at(2.2, 3.9) }),
        soft: BUILT.at(0.13, 0.4),
        loud: BUILT.at(2.02, 2.3),
        decay: BUILT.at(2.0, 4.0),
        claims: &[
            Claim {
                says: "partial j stands at j f sqrt(1 + b j²)",
                shows: "partial 10 from there, less the pitch: {} cents",
                measure: |p| {
                    let (f, b, cut) = (p.number("wire.f"), p.number("wire.b"), BUILT.at(2.2, 3.9));
                    let at = |j: f64| j * f * ((1.0 + b * j * j) / (1.0 + b)).sqrt();
                    p.cents(at(10.0), cut) - p.cents(f, cut)
                },
                // 47 masses lack something to a continuum
                keeps: [-35.0, 5.0],
            },
            Claim {
                says: "lays the damper on",
                shows: "fall of the level within a second: {} dB",
                measure: |p| p.level(BUILT.at(3.9, 4.0)) - p.level(BUILT.at(4.7, 5.0)),
                keeps: [30.0, NEVER_MORE],
            },
        ],
        ..Instrument::new("piano_wire")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(0.3, 1.4) }),
        soft: BUILT.way(0.8).at(0.1, 1.0),
        loud: BUILT.at(0.1, 1.0),
        decay: BUILT.at(0.1, 1.5),
        claims: &[Claim {
            says: "the longer part sounds a fifth higher",
            shows: "interval of pinched to open: {} cents",
            measure: |p| {
                1200.0 * 1.5f64.log2() + p.cents(165.0, BUILT.at(2.0, 3.3)) - p.cents(110.0, BUILT.at(0.3, 1.4))
            },
            keeps: [685.0, 703.0],
        }],
        ..Instrument::new("pinched_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 146.83, cut: BUILT.at(3.2, 4.8) }),
        soft: BUILT.at(2.9, 4.9),
        loud: BUILT.at(0.1, 1.3),
        decay: BUILT.at(2.9, 5.0),
        probes: &["pluck"],
        claims: &[
            Claim {
                says: "one note per passage, however slow",
                shows: "times the plectrum takes hold in the gesture of three passages: {}",
                measure: |p| {
                    [[0.1, 1.3], [1.4, 2.4], [2.5, 5.0]]
                        .iter()
                        .filter(|[a, b]| peak(&p.probe("pluck", BUILT.at(*a, *b))) > 1.0)
                        .count() as f64
                },
                keeps: [3.0, 3.0],
            },
            Claim {
                says: "until it is drawn out by `d`",
                shows: "largest force over k d: {}",
                measure: |p| {
                    let most = peak(&p.probe("pluck", BUILT.at(0.0, 1.0)));
                    most / (p.number("pluck.k") * p.number("pluck.d"))
                },
                keeps: [0.9, 1.2],
            },
        ],
        ..Instrument::new("plucked_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 82.41 / 0.9, cut: BUILT.at(0.2, 0.5) }),
        soft: BUILT.way(0.8).at(0.1, 0.5),
        loud: BUILT.at(0.1, 0.5),
        decay: BUILT.at(2.7, 6.0),
        claims: &[Claim {
            says: "the part towards the bridge sounds, at f / (1 - slide)",
            shows: "pitch at 0.4 from there: {} cents",
            measure: |p| p.cents(p.number("neck.f") / 0.6, BUILT.at(1.9, 2.4)),
            keeps: [-25.0, 5.0],
        }],
        ..Instrument::new("slide_guitar")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(0.2, 2.9) }),
        soft: BUILT.way(0.7).at(0.1, 1.0),
        loud: BUILT.at(0.1, 1.0),
        decay: BUILT.at(0.1, 2.9),
        claims: &[
            Claim {
                says: "an octave above remains",
                shows: "what partials 1, 3 and 5 fall by, at least: {} dB",
                measure: |p| {
                    let fell = |j: f64| {
                        let f = j * p.number("low.f");
                        p.partial(f, BUILT.at(3.2, 3.6)) - p.partial(f, BUILT.at(4.4, 4.8))
                    };
                    [1.0, 3.0, 5.0].into_iter().map(fell).fold(f64::INFINITY, f64::min)
                },
                keeps: [20.0, NEVER_MORE],
            },
            Claim {
                says: "all but harmonic",
                shows: "partial 12 from 12 times the first: {} cents",
                measure: |p| {
                    let (f, cut) = (p.number("low.f"), BUILT.at(1.0, 2.9));
                    p.cents(12.0 * f, cut) - p.cents(f, cut)
                },
                keeps: [-5.0, 5.0],
            },
        ],
        ..Instrument::new("wave_guitar")
    },
];
