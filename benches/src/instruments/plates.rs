//! Skins, sheets and gongs.

use super::{BUILT, Claim, Instrument, Pitch, Stroke, Take};

const NEVER_MORE: f64 = f64::INFINITY;

/// Returns the share of the power of the gong above 900 Hz, in 80 ms from `t` \[s\] on.
fn high(p: &super::Plays, t: f64) -> f64 {
    p.above(900.0, BUILT.at(t, t + 0.08))
}

/// Bow of the plate at 0.2 m/s and 0.8 N; the key has 24 N/m, so 6 N are at 0.25 m.
const LIGHT: Take = BUILT
    .moved(&[
        ("bow.draw", &[[0.0, -0.22], [0.2, -0.22], [2.2, 0.18]]),
        ("bow.press", &[[0.0, 0.0], [0.15, 0.8 / 24.0]]),
    ])
    .seconds(2.0);
/// The same at 1.2 N.
const FIRM: Take = BUILT
    .moved(&[
        ("bow.draw", &[[0.0, -0.22], [0.2, -0.22], [2.2, 0.18]]),
        ("bow.press", &[[0.0, 0.0], [0.15, 1.2 / 24.0]]),
    ])
    .seconds(2.0);
/// The same at 3 N.
const STRONG: Take = BUILT
    .moved(&[
        ("bow.draw", &[[0.0, -0.22], [0.2, -0.22], [2.2, 0.18]]),
        ("bow.press", &[[0.0, 0.0], [0.15, 3.0 / 24.0]]),
    ])
    .seconds(2.0);
/// The same at 5 N.
const HEAVY: Take = BUILT
    .moved(&[
        ("bow.draw", &[[0.0, -0.22], [0.2, -0.22], [2.2, 0.18]]),
        ("bow.press", &[[0.0, 0.0], [0.15, 5.0 / 24.0]]),
    ])
    .seconds(2.0);

/// Returns the period \[s\] with the largest autocorrelation in the second half of a stroke, and that correlation.
fn repeats(p: &super::Plays, take: Take) -> (f64, f64) {
    let (x, rate) = p.loudest_channel(take.at(1.2, 2.0));
    crate::acoustics::period(&x, rate, 1.0 / 400.0, 1.0 / 200.0)
}

/// The hard stroke alone, on a sheet with springs that do not harden.
const LINEAR: Take = BUILT
    .set(&["along.k3=0", "across.k3=0"])
    .moved(&[("hand", &[[0.0, -9e-3], [0.05, -9e-3], [0.065, 9e-3], [0.1, -9e-3]])])
    .seconds(0.3);

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 309.0, cut: FIRM.at(1.0, 2.0) }),
        soft: FIRM.at(1.0, 2.0),
        loud: BUILT.at(2.6, 3.6),
        decay: BUILT.at(5.2, 6.5),
        // the hair moves back and forth
        claims: &[
            Claim {
                sentence: "at 0.2 m/s 1.2 N gives 309 Hz",
                shows: "inverse of the period with the highest autocorrelation: {} Hz",
                measure: |p| 1.0 / repeats(p, FIRM).0,
                range: [307.0, 311.0],
            },
            Claim {
                sentence: "3 N adds a strong ninth harmonic at 2.7 kHz",
                shows: "partial there above the first: {} dB",
                measure: |p| p.partial(2717.0, STRONG.at(1.0, 2.0)) - p.partial(302.0, STRONG.at(1.0, 2.0)),
                range: [-6.0, 6.0],
            },
            Claim {
                sentence: "5 N is raucous, without a pitch",
                shows: "autocorrelation after the best period, 1 if the sound repeats: {}",
                measure: |p| repeats(p, HEAVY).1,
                range: [0.0, 0.5],
            },
            Claim {
                sentence: "below about 1 N nothing starts",
                shows: "level at 1.2 N above that at 0.8 N: {} dB",
                measure: |p| p.level(FIRM.at(1.0, 2.0)) - p.level(LIGHT.at(1.0, 2.0)),
                range: [20.0, NEVER_MORE],
            },
        ],
        remark: "One mode locks to the bow, and the force selects the mode; the sheet has tension and no bending \
                 stiffness, so it has the modes of a membrane with a free edge.",
        ..Instrument::new("bowed_plate")
    },
    Instrument {
        soft: BUILT.at(0.1, 0.5),
        loud: BUILT.at(1.6, 2.4),
        decay: BUILT.at(1.5, 6.0),
        claims: &[
            Claim {
                sentence: "the share of the sound above 900 Hz grows by half in the 0.15 s after the blow",
                shows: "that share 0.12 to 0.2 s after the blow over the share in its first 80 ms: {}",
                measure: |p| high(p, 1.64) / high(p, 1.52),
                range: [1.4, 1.8],
            },
            Claim {
                sentence: "a strong stroke becomes brighter",
                shows: "that share then over the share at the same time after the soft stroke: {}",
                measure: |p| high(p, 1.64) / high(p, 0.25),
                range: [1.5, NEVER_MORE],
            },
            Claim {
                sentence: "strikes softly, then strongly, and damps",
                shows: "fall of the level by the palm: {} dB",
                measure: |p| p.level(BUILT.at(6.8, 7.0)) - p.level(BUILT.at(7.5, 7.7)),
                range: [15.0, NEVER_MORE],
            },
        ],
        remark: "Strong strokes become a little brighter after the blow, with little above 2 kHz; `tam_tam` becomes brighter still.",
        ..Instrument::new("gong")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 147.0, cut: BUILT.at(2.3, 3.3) }),
        soft: BUILT.at(0.1, 0.4),
        loud: BUILT.at(1.83, 2.13),
        decay: BUILT.at(2.25, 4.0),
        claims: &[
            Claim {
                sentence: "the pitch stays",
                shows: "from the first stroke to the last: {} cents",
                measure: |p| p.cents(147.0, BUILT.at(2.3, 2.9)) - p.cents(147.0, BUILT.at(0.2, 0.7)),
                range: [-2.0, 2.0],
            },
            Claim {
                sentence: "centroid 680 Hz at the centre",
                shows: "of the first stroke: {} Hz",
                measure: |p| p.colour(BUILT.at(0.08, 0.48)),
                range: [640.0, 720.0],
            },
            Claim {
                sentence: "1 kHz near the rim",
                shows: "of the stroke before the last: {} Hz",
                measure: |p| p.colour(BUILT.at(1.83, 2.2)),
                range: [980.0, 1100.0],
            },
        ],
        remark: "Pitch exact, brighter towards the rim; 37 by 33 masses have no modes above 3.2 kHz, so the click of a hard stick is missing.",
        stroke: Stroke { slower: 2.0, ..Stroke::DEFAULT },
        ..Instrument::new("membrane")
    },
    Instrument {
        soft: BUILT.at(0.1, 0.6),
        loud: BUILT.at(2.3, 2.8),
        decay: BUILT.at(2.3, 4.2),
        claims: &[
            Claim {
                sentence: "strikes three times, each harder",
                shows: "least rise from one stroke to the next: {} dB",
                measure: |p| {
                    let blow = |t: f64| p.peak(BUILT.at(t, t + 0.3));
                    (blow(1.2) - blow(0.1)).min(blow(2.3) - blow(1.2))
                },
                range: [1.0, NEVER_MORE],
            },
            Claim {
                sentence: "damps the last by 22 dB in 0.6 s",
                shows: "fall of the level: {} dB",
                measure: |p| p.level(BUILT.at(4.1, 4.2)) - p.level(BUILT.at(4.75, 4.85)),
                range: [20.0, 26.0],
            },
            Claim {
                sentence: "Half of the power is above 3 kHz",
                shows: "share of it, of the whole sound: {}",
                measure: |p| p.above(3000.0, BUILT.at(0.0, 5.0)),
                range: [0.4, 0.65],
            },
        ],
        remark: "Dense and bright; louder is only a little brighter, and a sheet under tension lacks the dispersion of \
                 bending, so the shimmer of thin metal is missing.",
        stroke: Stroke { slower: 2.0, ..Stroke::DEFAULT },
        ..Instrument::new("plate")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 180.0, cut: BUILT.at(5.02, 5.5) }),
        soft: BUILT.at(3.28, 3.5),
        loud: BUILT.at(0.18, 0.4),
        decay: BUILT.at(5.0, 5.8),
        claims: &[
            Claim {
                sentence: "With the wires up each stroke has a noisy tail",
                shows: "power above 1 kHz from 20 to 120 ms after the stroke, above the power with the wires down: {} dB",
                measure: |p| p.band(1e3, 2e4, BUILT.at(0.23, 0.33)) - p.band(1e3, 2e4, BUILT.at(3.33, 3.43)),
                range: [10.0, NEVER_MORE],
            },
            Claim {
                sentence: "with them down it is a tom",
                shows: "part of the power above 1 kHz in the 0.2 s after 20 ms, with the wires down: {}",
                measure: |p| p.above(1e3, BUILT.at(3.33, 3.53)),
                range: [0.0, 0.1],
            },
        ],
        remark: "The wires rattle and stop within 0.4 s; the centroid of a stroke at the edge is only some 50 Hz \
                 higher than in the middle, and 11 by 11 masses give the skin few modes.",
        // the raised strainer presses with 2.8 N
        stroke: Stroke { clear: 0.3, ..Stroke::DEFAULT },
        ..Instrument::new("snare")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(5.6, 7.2) }),
        soft: BUILT.at(0.1, 0.3),
        loud: BUILT.at(3.4, 3.6),
        decay: BUILT.at(3.4, 7.2),
        stroke: Stroke { seconds: 1.5, ..Stroke::DEFAULT },
        claims: &[
            Claim {
                sentence: "8798 modules in all",
                shows: "MAT and LIA that are computed: {}",
                measure: |p| p.play(BUILT).modules.iter().sum::<usize>() as f64,
                range: [8798.0, 8798.0],
            },
            Claim {
                sentence: "the centroid of the first 0.2 s is at 370 Hz after the soft stroke",
                shows: "after the soft stroke: {} Hz",
                measure: |p| p.colour(BUILT.at(0.12, 0.34)),
                range: [340.0, 400.0],
            },
            Claim {
                sentence: "at 1.6 kHz after the hard one",
                shows: "after the hard one: {} Hz",
                measure: |p| p.colour(BUILT.at(3.4, 3.62)),
                range: [1500.0, 1750.0],
            },
            Claim {
                sentence: "glides from 127 Hz to 110 Hz",
                shows: "from 0.1 s after the hard stroke: {} Hz",
                measure: |p| {
                    let (x, rate) = p.loudest_channel(BUILT.at(3.5, 3.9));
                    crate::acoustics::partial(&x, rate, 124.0, 12.0).0
                },
                range: [118.0, 132.0],
            },
            Claim {
                sentence: "(a linear membrane)",
                shows: "centroid of the hard stroke without hardening: {} Hz",
                measure: |p| p.colour(LINEAR.at(0.05, 0.3)),
                range: [100.0, 300.0],
            },
        ],
        remark: "A hard stroke becomes noise within 0.1 s and its pitch glides; the modes of the linear sheet end at \
                 3.1 kHz, and only hardening makes higher frequencies, so the hiss of a real tam-tam is missing.",
        ..Instrument::new("tam_tam")
    },
];
