//! Bars, tines and glasses.

use super::{BUILT, Claim, Instrument, Pitch};

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 523.25, cut: BUILT.at(3.9, 4.4) }),
        soft: BUILT.at(0.3, 0.8),
        loud: BUILT.at(3.9, 4.4),
        decay: BUILT.at(6.0, 7.0),
        probes: &["rim[0]"],
        claims: &[Claim {
            says: "feeds the rim until it swings as fast as the finger goes",
            shows: "fastest motion of the first rim over the 0.1205 m/s of its finger: {}",
            measure: |p| {
                let (x, rate) = (p.probe("rim[0]", BUILT.at(3.9, 4.4)), p.play(BUILT).rate);
                crate::acoustics::peak(&crate::acoustics::velocity(&x, rate)) / (0.47 / 3.9)
            },
            keeps: [0.5, 1.3],
        }],
        ..Instrument::new("glass")
    },
    Instrument {
        soft: BUILT.at(0.1, 1.1),
        loud: BUILT.at(2.3, 3.3),
        decay: BUILT.at(2.3, 5.0),
        claims: &[Claim {
            says: "strikes three times, each harder",
            shows: "least rise from one stroke to the next: {} dB",
            measure: |p| {
                let blow = |t: f64| p.peak(BUILT.at(t, t + 0.3));
                (blow(1.2) - blow(0.1)).min(blow(2.3) - blow(1.2))
            },
            keeps: [1.0, f64::INFINITY],
        }],
        ..Instrument::new("iron_bar")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 261.6256, cut: BUILT.at(0.16, 0.49) }),
        soft: BUILT.at(3.3, 4.3),
        loud: BUILT.at(0.1, 0.5),
        decay: BUILT.at(3.3, 6.0),
        claims: &[Claim {
            says: "three cells at 1 : 6.27 : 17.5, as a clamped bar has",
            shows: "second mode of the first tine from 6.27 times C4: {} cents",
            measure: |p| p.cents(6.27 * 261.6256, BUILT.at(0.12, 0.4)),
            keeps: [-60.0, 60.0],
        }],
        ..Instrument::new("kalimba")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 196.0, cut: BUILT.at(0.15, 0.65) }),
        soft: BUILT.at(0.5, 0.7),
        loud: BUILT.at(0.12, 0.3),
        decay: BUILT.at(0.1, 0.7),
        probes: &["low_bar[0]", "low_tube"],
        claims: &[Claim {
            says: "it is the air that is heard most",
            shows: "swing of the air over that of the bar: {}",
            measure: |p| {
                let rms = |name| crate::acoustics::rms(&p.probe(name, BUILT.at(0.3, 0.6)));
                rms("low_tube") / rms("low_bar[0]")
            },
            keeps: [2.0, f64::INFINITY],
        }],
        ..Instrument::new("marimba")
    },
];
