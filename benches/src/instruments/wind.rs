//! What is drawn on and blown.

use super::{BUILT, Claim, Instrument, Stroke};
use crate::acoustics::{flatness, velocity};

pub static ALL: &[Instrument] = &[
    Instrument {
        probes: &["pendulum"],
        claims: &[Claim {
            says: "every swell costs the pendulum some of its swing",
            shows: "swing from 4 to 6 s over that of the first 2 s: {}",
            measure: |p| {
                let swing = |t: f64| crate::acoustics::peak(&p.probe("pendulum", BUILT.at(t, t + 2.0)));
                swing(4.0) / swing(0.0)
            },
            keeps: [0.0, 0.8],
        }],
        ..Instrument::new("physical_lfo")
    },
    Instrument {
        soft: BUILT.slower(2.0).at(2.0, 6.0),
        loud: BUILT.at(1.0, 5.0),
        decay: BUILT.at(5.8, 7.0),
        probes: &["air[13]"],
        stroke: Stroke { script: "bow", rest: &[0.0], depth: 0.0095, speed: 0.02, ..Stroke::DEFAULT },
        claims: &[
            Claim {
                says: "the sound is near white noise",
                shows: "flatness of the velocity of a mass between 100 Hz and 2 kHz (1 is white): {}",
                measure: |p| {
                    let (x, rate) = (p.probe("air[13]", BUILT.at(1.0, 5.0)), p.play(BUILT).rate);
                    flatness(&velocity(&x, rate), rate, 100.0, 2000.0)
                },
                keeps: [0.7, 1.0],
            },
            Claim {
                says: "The faster the bow, the stronger and brighter the wind",
                shows: "level above that of half the speed: {} dB",
                measure: |p| p.level(BUILT.at(1.0, 5.0)) - p.level(BUILT.slower(2.0).at(2.0, 10.0)),
                keeps: [1.0, f64::INFINITY],
            },
        ],
        ..Instrument::new("wind")
    },
];
