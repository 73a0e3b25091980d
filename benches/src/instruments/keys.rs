//! Pianos.

use super::{BUILT, Claim, Instrument, Pitch, Stroke};

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 261.6256, cut: BUILT.at(0.15, 0.38) }),
        soft: BUILT.at(3.72, 4.4),
        loud: BUILT.at(4.52, 5.6),
        decay: BUILT.at(4.52, 7.0),
        stroke: Stroke { depth: 0.0074, felt: 0.5, ..Stroke::DEFAULT },
        claims: &[Claim {
            says: "A key that goes down slowly is silent: the hammer never arrives",
            shows: "largest sample of the same gesture at a tenth of the speed: {}",
            measure: |p| crate::acoustics::peak(&p.heard(BUILT.slower(10.0).seconds(8.0).whole()).0),
            keeps: [0.0, 0.0],
        }],
        ..Instrument::new("hammer_piano")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 261.6256, cut: BUILT.at(0.15, 0.48) }),
        soft: BUILT.at(2.0, 2.9),
        loud: BUILT.at(3.0, 3.9),
        decay: BUILT.at(3.0, 4.0),
        probes: &["strike_c[0]"],
        claims: &[Claim {
            says: "the chord note by note, then together, softly and loud",
            shows: "loud above soft: {} dB",
            measure: |p| p.peak(BUILT.at(3.0, 3.3)) - p.peak(BUILT.at(2.0, 2.3)),
            keeps: [6.0, f64::INFINITY],
        }],
        ..Instrument::new("piano_key")
    },
];
