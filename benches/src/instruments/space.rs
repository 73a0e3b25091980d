//! What flies, falls and collides in space.

use super::{BUILT, Claim, Instrument, Pitch, Stroke};

pub static ALL: &[Instrument] = &[
    Instrument {
        soft: BUILT.way(0.6).whole(),
        decay: BUILT.at(4.3, 8.0),
        // the clapper goes to a tube
        stroke: Stroke { script: "bow", depth: 0.03, speed: 0.15, heard: -50.0, ..Stroke::DEFAULT },
        ..Instrument::new("chimes")
    },
    Instrument { soft: BUILT.set(&["room.pebble.m=1 g"]).whole(), ..Instrument::new("crystal") },
    Instrument {
        pitch: Some(Pitch { hertz: 220.0, cut: BUILT.at(0.145, 0.29) }),
        soft: BUILT.at(0.6, 1.0),
        loud: BUILT.at(0.1, 0.6),
        probes: &["land[*]"],
        claims: &[Claim {
            says: "comes to rest on the skin",
            shows: "level in the last second below that of the first: {} dB",
            measure: |p| p.level(BUILT.at(0.0, 1.0)) - p.level(BUILT.at(3.0, 4.0)),
            keeps: [40.0, f64::INFINITY],
        }],
        ..Instrument::new("jack")
    },
    Instrument {
        soft: BUILT.way(0.6).whole(),
        stroke: Stroke { script: "shake", dof: &[0], depth: 0.012, speed: 0.3, clear: 0.15, ..Stroke::DEFAULT },
        ..Instrument::new("maracas")
    },
    Instrument {
        soft: BUILT.way(0.6).whole(),
        decay: BUILT.at(4.4, 6.0),
        stroke: Stroke { script: "shake", dof: &[0, 1], depth: 0.008, speed: 0.3, clear: 0.1, ..Stroke::DEFAULT },
        ..Instrument::new("rattle")
    },
    Instrument {
        soft: BUILT.way(0.6).whole(),
        decay: BUILT.at(4.4, 6.0),
        stroke: Stroke { script: "shake", dof: &[0], depth: 0.01, speed: 0.2, clear: 0.45, ..Stroke::DEFAULT },
        ..Instrument::new("rattle_stick")
    },
    Instrument {
        soft: BUILT.at(3.0, 5.0),
        loud: BUILT.at(0.1, 1.5),
        probes: &["hop[4]"],
        claims: &[Claim {
            says: "falls by its own weight from its own height",
            shows: "first touch of bead `e` after √(2 h / g), later by: {} %",
            measure: |p| {
                let x = p.probe("hop[4]", BUILT.whole());
                let first = x.iter().position(|f| *f != 0.0).unwrap_or(0) as f64 / p.play(BUILT).rate;
                100.0 * (first / (2.0 * p.number("beads.e.x") / 9.81).sqrt() - 1.0)
            },
            keeps: [-0.2, 0.2],
        }],
        ..Instrument::new("rain_stick")
    },
];
