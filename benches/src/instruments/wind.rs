//! Bowed hairs and wind instruments.

use super::bars::loss_a_second;
use super::{BUILT, Claim, Instrument, Stroke, Take};
use crate::acoustics::{envelope, flatness, period};

/// Hairs at 0.05 m/s, and at 2 m/s.
const SLOW: Take = BUILT.moved(&[("hand", &[[0.0, -0.65], [2.0, -0.55]])]).seconds(2.0);
const QUICK: Take = BUILT.moved(&[("hand", &[[0.0, -0.65], [0.65, 0.65]])]).seconds(0.65);

/// A push in each direction, at the period of the pendulum.
const PUSHED: &[[f64; 2]] =
    &[[0.0, 0.0], [0.5, -9e-3], [1.0, 0.0], [1.5, 9e-3], [2.0, 0.0], [2.5, -9e-3], [3.0, 0.0], [3.5, 9e-3], [4.0, 0.0]];

pub static ALL: &[Instrument] = &[
    Instrument {
        soft: BUILT.at(8.0, 10.0),
        loud: BUILT.at(0.0, 2.0),
        probes: &["pendulum"],
        stroke: Stroke { motions: &[(0, PUSHED)], ..Stroke::DEFAULT },
        claims: &[
            Claim {
                sentence: "the sound swells once a second",
                shows: "period with the highest autocorrelation of the level: {} s",
                measure: |p| {
                    let (x, rate) = p.loudest_channel(BUILT.at(0.5, 6.5));
                    let len = (0.02 * rate) as usize;
                    period(&envelope(&x, len), rate / len as f64, 0.7, 1.3).0
                },
                range: [0.95, 1.05],
            },
            Claim {
                sentence: "every swell costs the pendulum some of its swing: 12 % a second",
                shows: "loss per second from 0 to 4 s: {}",
                measure: |p| {
                    loss_a_second(&|a, b| p.probe("pendulum", BUILT.at(a.max(0.0), b)), &[0.0, 1.0, 2.0, 3.0, 4.0])
                },
                range: [0.1, 0.145],
            },
        ],
        remark: "It swells and fades as its header says; the two strings are short and dark, and a push is needed to keep it going for longer than 10 s.",
        ..Instrument::new("physical_lfo")
    },
    Instrument {
        soft: SLOW.at(0.5, 2.0),
        loud: QUICK.at(0.15, 0.6),
        decay: BUILT.at(6.0, 7.0),
        claims: &[
            Claim {
                sentence: "15 dB from 0.05 to 2 m/s",
                shows: "level at 2 m/s above that at 0.05 m/s: {} dB",
                measure: |p| p.level(QUICK.at(0.15, 0.6)) - p.level(SLOW.at(0.5, 2.0)),
                range: [12.0, 18.0],
            },
            Claim {
                sentence: "collide between two walls: noise",
                shows: "flatness between 150 Hz and 8 kHz (1 is white): {}",
                measure: |p| {
                    let (x, rate) = p.loudest_channel(BUILT.at(1.0, 5.0));
                    flatness(&x, rate, 150.0, 8000.0)
                },
                range: [0.15, 1.0],
            },
        ],
        remark: "A coloured noise whose loudness follows the hand; its timbre does not change with speed.",
        ..Instrument::new("wind")
    },
];
