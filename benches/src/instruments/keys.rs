//! Pianos.

use super::{BUILT, Claim, Instrument, Pitch, Stroke, Take};
use crate::acoustics::peak;

const NEVER_MORE: f64 = f64::INFINITY;
/// Stroke for a key that goes down 9.2 mm.
const KEY: Stroke = Stroke { min_force: 0.5, ..Stroke::DEFAULT };

/// C4 of `hammer_piano` alone, with its key at 0.05 m/s.
const SILENT: Take = BUILT
    .moved(&[
        ("key[0].key", &[[0.0, -8e-3], [0.1, -8e-3], [0.286, 1.3e-3]]),
        ("key[2].key", &[[0.0, -8e-3]]),
        ("key[4].key", &[[0.0, -8e-3]]),
        ("key[5].key", &[[0.0, -8e-3]]),
    ])
    .seconds(0.5);
/// The same at 0.08 m/s.
const SOFT: Take = BUILT
    .moved(&[
        ("key[0].key", &[[0.0, -8e-3], [0.1, -8e-3], [0.216, 1.3e-3]]),
        ("key[2].key", &[[0.0, -8e-3]]),
        ("key[4].key", &[[0.0, -8e-3]]),
        ("key[5].key", &[[0.0, -8e-3]]),
    ])
    .seconds(0.6);
/// The same at 0.58 m/s, released from 0.6 s on.
const LOUD: Take = BUILT
    .moved(&[
        ("key[0].key", &[[0.0, -8e-3], [0.1, -8e-3], [0.116, 1.3e-3], [0.6, 1.3e-3], [0.65, -8e-3]]),
        ("key[2].key", &[[0.0, -8e-3]]),
        ("key[4].key", &[[0.0, -8e-3]]),
        ("key[5].key", &[[0.0, -8e-3]]),
    ])
    .seconds(1.0);
/// First of three keys, pressed at 20 mm/s.
const PRESSED: Take = BUILT.moved(&[("key[0].key", &[[0.0, -8e-3], [0.1, -8e-3], [0.56, 1.2e-3]])]).seconds(0.57);

/// Returns the mean weight of the first key \[N\] between two depths \[m\] while it is pressed slowly.
fn weighs(p: &super::Plays, from: f64, to: f64) -> f64 {
    let cut = PRESSED.at(0.1 + from / 0.02, 0.1 + to / 0.02);
    let of = |name| p.probe(name, cut);
    let all: Vec<f64> = of("key[0].a.lever").iter().zip(of("key[0].a.weight")).map(|(a, b)| (a - b).abs()).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 261.6256, cut: SOFT.at(0.25, 0.58) }),
        soft: SOFT.at(0.2, 0.6),
        loud: LOUD.at(0.1, 0.5),
        decay: BUILT.at(6.0, 7.6),
        probes: &["key[0].strike", "key[0].strike2"],
        stroke: KEY,
        claims: &[
            Claim {
                sentence: "a press of 0.05 m/s is silent",
                shows: "force of the hammer on the string: {} N",
                measure: |p| peak(&p.probe("key[0].strike", SILENT.whole())),
                range: [0.0, 0.0],
            },
            Claim {
                sentence: "spectral centroid of C4 324 Hz at 0.08 m/s, 641 Hz at 0.58",
                shows: "centroid at 0.58 m/s over the centroid at 0.08: {}",
                measure: |p| p.colour(LOUD.at(0.08, 0.58)) / p.colour(SOFT.at(0.1, 0.58)),
                range: [1.5, NEVER_MORE],
            },
            Claim {
                sentence: "Let go, a note is down by 40 dB within 0.3 s",
                shows: "level before the key of C4 is let go, above the level 0.3 s after: {} dB",
                measure: |p| p.level(LOUD.at(0.55, 0.6)) - p.level(LOUD.at(0.95, 1.0)),
                range: [40.0, NEVER_MORE],
            },
            Claim {
                sentence: "leaves the second strings unstruck",
                shows: "force on the second string of C4 in the soft chord: {} N",
                measure: |p| peak(&p.probe("key[0].strike2", BUILT.at(3.6, 4.2))),
                range: [0.0, 0.0],
            },
        ],
        remark: "Hammer, damper and shared pin act as in a piano; partial 7, near whose node the hammer strikes, is \
                 more than 30 dB down, and the landing of a damper is nearly as loud as the softest notes.",
        ..Instrument::new("hammer_piano")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 130.8128, cut: BUILT.at(5.6, 6.6) }),
        soft: BUILT.at(0.1, 0.3),
        loud: BUILT.at(5.4, 6.6),
        decay: BUILT.at(5.4, 6.6),
        stroke: KEY,
        claims: &[
            Claim {
                sentence: "or MIDI notes C3 to B4",
                shows: "E4 of the chord: {} cents",
                measure: |p| p.cents(329.6276, BUILT.at(5.6, 6.6)),
                range: [-4.0, 4.0],
            },
            Claim {
                sentence: "plays all keys from the lowest, ever louder",
                shows: "the last note above the first: {} dB",
                measure: |p| p.peak(BUILT.at(4.7, 4.9)) - p.peak(BUILT.at(0.1, 0.3)),
                range: [3.0, NEVER_MORE],
            },
        ],
        remark: "In tune over two octaves; without a soundboard it is drier than `hammer_piano`, and partial 7 is as weak.",
        ..Instrument::new("piano24")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 261.6256, cut: BUILT.at(0.2, 0.58) }),
        soft: BUILT.at(2.0, 2.5),
        loud: BUILT.at(3.2, 3.7),
        decay: BUILT.at(3.2, 4.4),
        probes: &["key[0].strike", "key[0].a.lever", "key[0].a.weight"],
        stroke: KEY,
        claims: &[
            Claim {
                sentence: "0.55 N at 7.5 mm",
                shows: "from 7.2 to 7.7 mm of a press at 20 mm/s: {} N",
                measure: |p| weighs(p, 7.2e-3, 7.7e-3),
                range: [0.45, 0.65],
            },
            Claim {
                sentence: "the let-off, 1.05 N at 8.8 mm",
                shows: "from 8.7 to 8.75 mm of it: {} N",
                measure: |p| weighs(p, 8.7e-3, 8.75e-3),
                range: [0.9, 1.15],
            },
            Claim {
                sentence: "so slowly that no hammer arrives",
                shows: "force of the hammer on C4 then: {} N",
                measure: |p| peak(&p.probe("key[0].strike", BUILT.at(5.0, 5.65))),
                range: [0.0, 0.0],
            },
            Claim {
                sentence: "five times from half release",
                shows: "number of times the hammer then strikes: {}",
                measure: |p| p.contacts("key[0].strike", BUILT.at(5.65, 6.6)),
                range: [5.0, 5.0],
            },
        ],
        remark: "Weight, let-off and repetition can be felt, in newtons; the sound is of bare strings, without a soundboard.",
        ..Instrument::new("piano_key")
    },
];
