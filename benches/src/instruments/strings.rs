//! Plucked, struck, bowed and touched strings.

use super::{BUILT, Claim, Instrument, Pitch, Plays, Stroke, Take};
use crate::acoustics::{peak, velocity};

const NEVER_MORE: f64 = f64::INFINITY;
/// Position of the bow at `low[11]` of 100 masses, as a share of the string.
const BOWED_AT: f64 = 12.0 / 101.0;

/// Returns the least and the largest fall of these partials \[dB\].
fn falls(p: &Plays, partials: &[f64], before: super::Cut, after: super::Cut) -> [f64; 2] {
    let all = partials.iter().map(|f| p.partial(*f, before) - p.partial(*f, after));
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |m, f| [m[0].min(f), m[1].max(f)])
}

/// One stroke of the plectrum with the least pull on the string.
const SOFT_PLUCK: Take =
    BUILT.moved(&[("pick.key", &[[0.0, -4e-3], [0.1, -4e-3], [0.13, 4e-3]]), ("depth", &[[0.0, -8e-3]])]).seconds(0.6);
/// A key that rises at 0.04 m/s.
const SLOW_KEY: Take = BUILT.moved(&[("key", &[[0.0, -8e-3], [0.1, -8e-3], [0.3, 0.0]])]).seconds(0.6);

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 146.83, cut: BUILT.at(2.7, 3.4) }),
        soft: BUILT.at(4.5, 5.2),
        loud: BUILT.at(2.8, 3.5),
        decay: BUILT.at(5.3, 6.0),
        probes: &["low[11]"],
        // the hair moves back and forth over the string, pressed by the other key
        claims: &[
            Claim {
                sentence: "The string slips once a period (Helmholtz motion)",
                shows: "share of the time in which it sticks to the hair, 1 − β = 0.881 in theory, in the strong down-bow: {}",
                measure: |p| {
                    let (x, rate) = (p.probe("low[11]", BUILT.at(2.9, 3.5)), p.play(BUILT).rate);
                    let sticks = velocity(&x, rate).iter().filter(|v| **v < 0.0).count();
                    sticks as f64 / (x.len() - 1) as f64
                },
                range: [1.0 - BOWED_AT - 0.05, 1.0 - BOWED_AT + 0.05],
            },
            Claim {
                sentence: "Loudness grows with speed",
                shows: "the down-bow at 0.3 m/s above the soft bow at 0.05 m/s: {} dB",
                measure: |p| p.level(BUILT.at(2.8, 3.5)) - p.level(BUILT.at(4.5, 5.2)),
                range: [10.0, 25.0],
            },
            Claim {
                sentence: "the hair stays on the string and stops it",
                shows: "fall of the level within half a second: {} dB",
                measure: |p| p.level(BUILT.at(4.8, 5.2)) - p.level(BUILT.at(5.6, 5.9)),
                range: [10.0, NEVER_MORE],
            },
        ],
        remark: "Helmholtz motion over a wide range of speed and force, in tune; the body is ten modes and no more.",
        ..Instrument::new("bowed_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(3.5, 5.5) }),
        soft: BUILT.at(0.1, 0.5),
        loud: BUILT.at(3.3, 3.7),
        decay: BUILT.at(3.3, 6.0),
        probes: &["strike"],
        claims: &[
            Claim {
                sentence: "five strokes, soft to loud",
                shows: "least ratio of the forces of two successive blows: {}",
                measure: |p| {
                    let blow = |i: f64| peak(&p.probe("strike", BUILT.at(0.1 + 0.8 * i, 0.3 + 0.8 * i)));
                    (1..5).map(|i| blow(f64::from(i)) / blow(f64::from(i - 1))).fold(f64::INFINITY, f64::min)
                },
                range: [1.1, NEVER_MORE],
            },
            Claim {
                sentence: "strikes once and falls back on the arm",
                shows: "contacts of hammer and string in the five strokes: {}",
                measure: |p| p.contacts("strike", BUILT.whole()),
                range: [5.0, 5.0],
            },
            Claim {
                sentence: "a faster key is louder and brighter",
                shows: "centroid of the last stroke over the centroid of the first: {}",
                measure: |p| p.colour(BUILT.at(3.28, 3.7)) / p.colour(BUILT.at(0.08, 0.5)),
                range: [1.4, NEVER_MORE],
            },
            Claim {
                sentence: "A key that rises slowly is silent",
                shows: "force on the string of a key at 0.04 m/s: {} N",
                measure: |p| peak(&p.probe("strike", SLOW_KEY.whole())),
                range: [0.0, 0.0],
            },
        ],
        remark: "One clean contact per stroke, and the sound becomes brighter with the speed of the key; one string without a body is dry.",
        stroke: Stroke { slower: 2.0, ..Stroke::DEFAULT },
        ..Instrument::new("hammered_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 200.0, cut: BUILT.at(0.11, 0.5) }),
        soft: BUILT.at(0.1, 0.5),
        loud: BUILT.at(1.2, 4.0),
        decay: BUILT.at(4.6, 5.4),
        probes: &["string4[12]"],
        claims: &[
            Claim {
                sentence: "each sample repeats exactly after 2 (N + 1) samples",
                shows: "largest difference of two samples 240 apart, as a part of the largest sample: {}",
                measure: |p| {
                    let x = p.probe("string4[12]", BUILT.at(1.2, 4.4));
                    let worst = x.iter().zip(&x[240..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    worst / peak(&x)
                },
                range: [0.0, 1e-12],
            },
            Claim {
                sentence: "`still` stops them",
                shows: "fall of the level from 4.4 to 5.5 s: {} dB",
                measure: |p| p.level(BUILT.at(4.2, 4.4)) - p.level(BUILT.at(5.5, 5.7)),
                range: [20.0, NEVER_MORE],
            },
        ],
        remark: "Exactly periodic, so it lacks the change of a string that loses its high partials first; a demonstration more than an instrument.",
        ..Instrument::new("harmonic_chain")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 196.0, cut: BUILT.at(2.4, 4.8) }),
        soft: BUILT.at(0.1, 0.6),
        loud: BUILT.at(2.0, 2.5),
        decay: BUILT.at(2.0, 5.0),
        probes: &["hoop[0]"],
        claims: &[
            Claim {
                sentence: "a stroke also pushes the whole of it away",
                shows: "displacement of the top from 1 to 1.9 s over its amplitude then: {}",
                measure: |p| {
                    let swing = |t: f64| {
                        let x = p.probe("hoop[0]", BUILT.at(t, t + 0.1));
                        (x.iter().sum::<f64>() / x.len() as f64, crate::acoustics::rms(&x))
                    };
                    (swing(1.9).0 - swing(1.0).0).abs() / swing(1.9).1
                },
                range: [3.0, NEVER_MORE],
            },
            Claim {
                sentence: "which the difference of two places does not hear",
                shows: "mean of the sound from 1 to 1.9 s: {} dBFS",
                measure: |p| {
                    let (x, _) = p.loudest_channel(BUILT.at(1.0, 1.9));
                    crate::acoustics::db((x.iter().sum::<f64>() / x.len() as f64).abs())
                },
                range: [f64::NEG_INFINITY, -60.0],
            },
        ],
        remark: "Partials nearly harmonic, a little flat, since the ring has tension and no bending: smoother than a hoop of wood or metal.",
        ..Instrument::new("hoop")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 330.0, cut: BUILT.at(1.4, 2.3) }),
        soft: BUILT.set(&["strength.x=0.1"]).seconds(0.8).at(0.1, 0.8),
        loud: BUILT.at(0.1, 0.8),
        decay: BUILT.at(7.7, 10.0),
        claims: &[
            Claim {
                sentence: "partials that move where it touches die",
                shows: "least fall of partials 1, 2, 4 and 5 at a third: {} dB",
                measure: |p| falls(p, &[110.0, 220.0, 440.0, 550.0], BUILT.at(0.3, 0.8), BUILT.at(1.4, 2.1))[0],
                range: [40.0, NEVER_MORE],
            },
            Claim {
                sentence: "those with a node there stay",
                shows: "largest fall of partials 3, 6 and 9 there in 1.2 s: {} dB",
                measure: |p| falls(p, &[330.0, 660.0, 990.0], BUILT.at(0.3, 0.8), BUILT.at(1.4, 2.1))[1],
                range: [0.0, 20.0],
            },
            Claim {
                sentence: "then at a half, at a quarter and at a fifth",
                shows: "partial 5 at a fifth above partial 4: {} dB",
                measure: |p| p.partial(550.0, BUILT.at(8.0, 9.5)) - p.partial(440.0, BUILT.at(8.0, 9.5)),
                range: [30.0, NEVER_MORE],
            },
        ],
        remark: "Harmonics are clean and in tune, the touch itself is silent; no weakness is known.",
        ..Instrument::new("natural_harmonic")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 65.406, cut: BUILT.at(2.2, 6.0) }),
        soft: BUILT.at(0.15, 1.2),
        loud: BUILT.at(2.0, 3.0),
        decay: BUILT.at(2.0, 8.0),
        probes: &["strike"],
        claims: &[
            Claim {
                sentence: "the high ones are sharp (the seventh by 47 cents)",
                shows: "deviation of partial 7 from 7 times the first: {} cents",
                measure: |p| {
                    let cut = BUILT.at(2.2, 4.2);
                    47.0 + p.cents(7.0 * 65.406 * 2f64.powf(47.0 / 1200.0), cut) - p.cents(65.406, cut)
                },
                range: [44.0, 51.0],
            },
            Claim {
                sentence: "Each stroke is one contact",
                shows: "contacts of the hammer in two strokes: {}",
                measure: |p| p.contacts("strike", BUILT.whole()),
                range: [2.0, 2.0],
            },
            Claim {
                sentence: "louder is brighter",
                shows: "centroid of the loud stroke over the centroid of the soft one: {}",
                measure: |p| p.colour(BUILT.at(2.0, 2.6)) / p.colour(BUILT.at(0.15, 0.75)),
                range: [1.3, NEVER_MORE],
            },
        ],
        remark: "Inharmonic like thick wire, with two slopes of decay; without a soundboard it lacks the noise of a bass key.",
        ..Instrument::new("piano_wire")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(0.3, 1.15) }),
        soft: BUILT.set(&["strength.x=0.1"]).seconds(1.0).at(0.1, 1.0),
        loud: BUILT.at(0.1, 1.0),
        decay: BUILT.at(0.1, 1.2),
        claims: &[
            Claim {
                sentence: "the longer part sounds a fifth higher",
                shows: "interval of pinched to open, 702 for a fifth: {} cents",
                measure: |p| {
                    1200.0 * 1.5f64.log2() + p.cents(165.0, BUILT.at(2.0, 3.1)) - p.cents(110.0, BUILT.at(0.3, 1.15))
                },
                range: [697.0, 704.0],
            },
            Claim {
                sentence: "(a soft grip: flatter than the fifth",
                shows: "interval with it: {} cents",
                measure: |p| {
                    let soft = BUILT.set(&["tip=20 kN/m"]).seconds(3.1);
                    1200.0 * 1.5f64.log2() + p.cents(165.0, soft.at(2.0, 3.1)) - p.cents(110.0, BUILT.at(0.3, 1.15))
                },
                range: [660.0, 685.0],
            },
            Claim {
                sentence: "one of the two alone is a fret that buzzes",
                shows: "power above 2 kHz of the pluck against the thumb over the power of the open string: {} dB",
                measure: |p| p.band(2e3, 2e4, BUILT.at(4.2, 4.9)) - p.band(2e3, 2e4, BUILT.at(0.1, 0.8)),
                range: [3.0, NEVER_MORE],
            },
        ],
        remark: "A clean stop and a fret that buzzes; the flesh of a finger is one spring and one loss.",
        ..Instrument::new("pinched_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 146.83, cut: BUILT.at(5.3, 7.8) }),
        soft: SOFT_PLUCK.at(0.1, 0.6),
        loud: BUILT.at(5.1, 5.6),
        decay: BUILT.at(5.2, 8.0),
        probes: &["pick.pluck"],
        claims: &[
            Claim {
                sentence: "12 dB from soft to loud",
                shows: "the loud pluck above the soft one: {} dB",
                measure: |p| p.level(BUILT.at(5.1, 5.6)) - p.level(SOFT_PLUCK.at(0.1, 0.6)),
                range: [11.0, 13.0],
            },
            Claim {
                sentence: "one note a passage",
                shows: "number of releases of the plectrum from more than 0.5 N in seven passages: {}",
                measure: |p| {
                    let x = p.probe("pick.pluck", BUILT.whole());
                    x.windows(2).filter(|w| w[0].abs() > 0.5 && w[1] == 0.0).count() as f64
                },
                range: [7.0, 7.0],
            },
            Claim {
                sentence: "as loud when it is slow as when it is fast",
                shows: "the slow passage above the first: {} dB",
                measure: |p| p.peak(BUILT.at(2.5, 3.5)) - p.peak(BUILT.at(0.1, 0.6)),
                range: [-1.5, 1.5],
            },
        ],
        remark: "The displacement of the pluck changes the loudness over 12 dB, in tune; no weakness is known.",
        ..Instrument::new("plucked_string")
    },
    Instrument {
        soft: BUILT.at(0.1, 0.6),
        loud: BUILT.at(1.1, 1.6),
        decay: BUILT.at(7.0, 10.5),
        probes: &["rattle", "loose.ring", "hammer.strike"],
        claims: &[
            Claim {
                sentence: "it rattles while the string swings wide",
                shows: "contacts of the screw in the loud stroke over its contacts in the soft one: {}",
                measure: |p| {
                    let of = |a: f64, b: f64| {
                        p.probe("rattle", BUILT.at(a, b)).windows(2).filter(|w| w[0] == 0.0 && w[1] != 0.0).count()
                    };
                    of(3.6, 4.6) as f64 / of(2.6, 3.6) as f64
                },
                range: [1.5, NEVER_MORE],
            },
            Claim {
                sentence: "hops on it: 1 mm high when soft",
                shows: "highest place of the ring after the first stroke: {} mm",
                measure: |p| 1e3 * p.probe("loose.ring", BUILT.at(0.1, 1.1)).into_iter().fold(0.0, f64::max),
                range: [0.6, 1.6],
            },
            Claim {
                sentence: "2 cm when loud",
                shows: "after the loud one: {} mm",
                measure: |p| 1e3 * p.probe("loose.ring", BUILT.at(1.1, 2.6)).into_iter().fold(0.0, f64::max),
                range: [16.0, 26.0],
            },
            Claim {
                sentence: "which are no longer harmonic",
                shows: "third partial over the first, after the soft free stroke: {}",
                measure: |p| {
                    let (x, rate) = p.loudest_channel(BUILT.at(0.3, 1.1));
                    let at = |f: f64| crate::acoustics::partial(&x, rate, f, 0.03 * f).0;
                    at(392.5) / at(125.7)
                },
                range: [3.05, 3.25],
            },
        ],
        remark: "Loud strokes are brighter because the screw rattles; the screw is a point that chatters, without a thread to grip the string.",
        stroke: Stroke { slower: 2.0, ..Stroke::DEFAULT },
        ..Instrument::new("prepared_string")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 82.41 / 0.9, cut: BUILT.at(0.2, 0.5) }),
        soft: BUILT.at(1.9, 2.4),
        loud: BUILT.at(0.1, 0.5),
        decay: BUILT.at(4.3, 8.0),
        claims: &[
            Claim {
                sentence: "the part towards the bridge sounds, at f / (1 - place), within 4 cents",
                shows: "pitch with the bar at 0.4 from there: {} cents",
                measure: |p| p.cents(p.number("neck.f") / 0.6, BUILT.at(2.7, 3.2)),
                range: [-4.0, 4.0],
            },
            Claim {
                sentence: "slides up a fifth",
                shows: "interval between the places before and after the slide, 702 for a fifth: {} cents",
                measure: |p| {
                    let f = p.number("neck.f");
                    1200.0 * 1.5f64.log2() + p.cents(f / 0.6, BUILT.at(2.7, 3.2)) - p.cents(f / 0.9, BUILT.at(0.2, 0.5))
                },
                range: [695.0, 709.0],
            },
        ],
        remark: "A smooth glide in tune, but dark.",
        ..Instrument::new("slide_guitar")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(0.4, 2.9) }),
        soft: BUILT.moved(&[("strength", &[[0.0, 0.6]])]).seconds(1.0).at(0.1, 1.0),
        loud: BUILT.at(0.1, 1.0),
        decay: BUILT.at(0.2, 2.9),
        claims: &[
            Claim {
                sentence: "the odd partials die",
                shows: "least fall of partials 1, 3 and 5: {} dB",
                measure: |p| falls(p, &[110.0, 330.0, 550.0], BUILT.at(3.2, 3.65), BUILT.at(4.3, 4.9))[0],
                range: [40.0, NEVER_MORE],
            },
            Claim {
                sentence: "an octave above remains",
                shows: "partial 2 then: {} dBFS",
                measure: |p| p.partial(220.0, BUILT.at(4.3, 4.9)),
                range: [-45.0, -15.0],
            },
        ],
        remark: "Cheap and harmonic; a plectrum much stiffer than this one is refused, because the margin of stability at the junction is 1.05.",
        ..Instrument::new("wave_guitar")
    },
];
