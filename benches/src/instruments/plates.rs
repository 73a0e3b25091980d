//! Skins, sheets and gongs.

use super::{BUILT, Claim, Instrument, Pitch};

pub static ALL: &[Instrument] = &[
    Instrument {
        soft: BUILT.at(0.1, 1.4),
        loud: BUILT.at(1.6, 2.4),
        decay: BUILT.at(1.5, 6.0),
        claims: &[Claim {
            says: "the sound grows brighter for half a second after the blow",
            shows: "brightest 0.15 s in the half second after the blow over the blow, by their centroids: {}",
            measure: |p| {
                let colour = |t: f64| p.centroid(BUILT.at(t, t + 0.15));
                (0..4).map(|k| colour(1.7 + 0.1 * f64::from(k))).fold(0.0, f64::max) / colour(1.52)
            },
            keeps: [1.02, f64::INFINITY],
        }],
        ..Instrument::new("gong")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 147.0, cut: BUILT.at(2.3, 3.3) }),
        soft: BUILT.at(0.1, 0.4),
        loud: BUILT.at(1.85, 2.2),
        decay: BUILT.at(1.85, 4.0),
        claims: &[
            Claim {
                says: "the pitch stays",
                shows: "from the first stroke to the last: {} cents",
                measure: |p| p.cents(147.0, BUILT.at(2.0, 2.6)) - p.cents(147.0, BUILT.at(0.2, 0.6)),
                keeps: [-10.0, 10.0],
            },
            Claim {
                says: "the colour opens",
                shows: "centroid of the last stroke over that of the first: {}",
                measure: |p| p.centroid(BUILT.at(1.88, 2.08)) / p.centroid(BUILT.at(0.15, 0.35)),
                keeps: [1.1, f64::INFINITY],
            },
        ],
        ..Instrument::new("membrane")
    },
    Instrument {
        soft: BUILT.at(0.1, 1.1),
        loud: BUILT.at(2.3, 3.3),
        decay: BUILT.at(2.3, 4.2),
        claims: &[Claim {
            says: "damps the last",
            shows: "fall of the level by the palm in half a second: {} dB",
            measure: |p| p.level(BUILT.at(4.0, 4.2)) - p.level(BUILT.at(4.6, 4.8)),
            keeps: [15.0, f64::INFINITY],
        }],
        ..Instrument::new("plate")
    },
];
