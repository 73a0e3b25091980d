//! Bars, tines and glasses.

use super::{BUILT, Claim, Instrument, Pitch, Stroke, Take};
use crate::acoustics::{db, peak, rms, slope};

const NEVER_MORE: f64 = f64::INFINITY;

/// D5 of the marimba alone, with a stroke of 30 ms.
const SOFT_D5: Take = BUILT
    .moved(&[
        ("key[0].key", &[[0.0, -8e-3]]),
        ("key[11].key", &[[0.1, -8e-3], [0.13, 0.0], [0.18, 0.0], [0.22, -8e-3]]),
    ])
    .seconds(0.44);
/// The same with a stroke of 8 ms.
const LOUD_D5: Take = BUILT
    .moved(&[
        ("key[0].key", &[[0.0, -8e-3]]),
        ("key[11].key", &[[0.1, -8e-3], [0.108, 0.0], [0.158, 0.0], [0.2, -8e-3]]),
    ])
    .seconds(0.44);

/// One finger alone, at a slow and at a fast speed, from 0.1 s on.
const SLOW_FINGER: Take = BUILT
    .moved(&[
        ("finger1", &[[0.0, -0.3], [0.1, -0.3], [6.1, -0.18]]),
        ("finger2", &[[0.0, -0.3]]),
        ("finger3", &[[0.0, -0.3]]),
    ])
    .seconds(6.0);
const QUICK_FINGER: Take = BUILT
    .moved(&[
        ("finger1", &[[0.0, -0.3], [0.1, -0.3], [6.1, 1.5]]),
        ("finger2", &[[0.0, -0.3]]),
        ("finger3", &[[0.0, -0.3]]),
    ])
    .seconds(6.0);

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 523.25, cut: BUILT.at(3.9, 4.4) }),
        soft: SLOW_FINGER.at(4.0, 6.0),
        loud: QUICK_FINGER.at(4.0, 6.0),
        decay: BUILT.at(6.0, 7.0),
        claims: &[
            Claim {
                sentence: "feeds the rim at any speed from 0.02 to 0.3 m/s",
                shows: "first partial of one finger at 0.02 m/s after 4 s: {} dBFS",
                measure: |p| p.partial(523.25, SLOW_FINGER.at(4.0, 6.0)),
                range: [-45.0, -25.0],
            },
            Claim {
                sentence: "the faster, the louder",
                shows: "first partial at 0.3 m/s above that at 0.02 m/s: {} dB",
                measure: |p| p.partial(523.25, QUICK_FINGER.at(4.0, 6.0)) - p.partial(523.25, SLOW_FINGER.at(4.0, 6.0)),
                range: [15.0, NEVER_MORE],
            },
            Claim {
                sentence: "t60 of `rim` = \"0.5 s\" (no finger can start it)",
                shows: "level with it at 0.3 m/s below the level of the unchanged rim: {} dB",
                measure: |p| {
                    p.level(QUICK_FINGER.at(4.0, 6.0)) - p.level(QUICK_FINGER.set(&["rim.t60=0.5 s"]).at(4.0, 6.0))
                },
                range: [30.0, NEVER_MORE],
            },
        ],
        remark: "Loudness follows the finger; the sound is nearly a sine, the stem adds little even when loud, and the \
                 timbre hardly changes.",
        ..Instrument::new("glass")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 123.47, cut: BUILT.at(2.5, 4.5) }),
        soft: BUILT.at(0.1, 0.6),
        loud: BUILT.at(2.28, 2.8),
        decay: BUILT.at(2.3, 5.0),
        probes: &["hammer.strike"],
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
                sentence: "its partials are near 1 : 2.76 : 5.40 : 8.93",
                shows: "largest deviation of partials 2, 3 and 4: {} cents",
                measure: |p| {
                    let cut = BUILT.at(2.31, 2.7);
                    let first = 123.47 * 2f64.powf(p.cents(123.47, BUILT.at(2.5, 4.5)) / 1200.0);
                    let off = [2.757, 5.404, 8.933].map(|r| p.cents(r * first, cut));
                    off.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
                },
                range: [-40.0, 40.0],
            },
            Claim {
                sentence: "brighter when louder",
                shows: "centroid of the last stroke over the centroid of the first: {}",
                measure: |p| p.colour(BUILT.at(2.28, 2.8)) / p.colour(BUILT.at(0.08, 0.6)),
                range: [1.05, NEVER_MORE],
            },
            Claim {
                sentence: "they shorten the others",
                shows: "T60 of the first mode over T60 of the second: {}",
                measure: |p| p.t60(123.47, BUILT.at(2.5, 4.5)) / p.t60(2.77 * 123.47, BUILT.at(2.35, 3.0)),
                range: [3.0, 12.0],
            },
        ],
        remark: "Partials of a free bar, the fourth a quarter of a semitone flat because there are only 25 masses; \
                 between soft and loud the timbre changes less than on a piano.",
        stroke: Stroke { slower: 2.0, ..Stroke::DEFAULT },
        ..Instrument::new("iron_bar")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 261.6256, cut: BUILT.at(0.16, 0.49) }),
        soft: BUILT.at(0.1, 0.5),
        loud: BUILT.at(3.64, 4.1),
        decay: BUILT.at(3.7, 6.0),
        probes: &["tine[0].pluck[0]"],
        claims: &[
            Claim {
                sentence: "three cells at 1 : 6.27 : 17.5, as a clamped bar has",
                shows: "deviation of the second mode of the first tine from 6.27 times C4: {} cents",
                measure: |p| p.cents(6.27 * 261.6256, BUILT.at(0.12, 0.4)),
                range: [-5.0, 5.0],
            },
            Claim {
                sentence: "it touches a ringing tine for about a millisecond at most",
                shows: "longest touch of the thumb of C4 on its way back: {} ms",
                measure: |p| {
                    let rate = p.play(BUILT).rate;
                    // from the end of each hold to the next stroke
                    let back = [[0.172, 0.4], [3.172, 3.6], [3.772, 5.0]];
                    let touch = |c: [f64; 2]| {
                        p.probe("tine[0].pluck[0]", BUILT.at(c[0], c[1])).iter().filter(|f| **f != 0.0).count()
                    };
                    1e3 * back.into_iter().map(touch).max().unwrap_or(0) as f64 / rate
                },
                range: [0.0, 1.1],
            },
            Claim {
                sentence: "with a quarter of the force",
                shows: "largest force of such a touch over the force of the pluck before it: {}",
                measure: |p| {
                    let of = |a: f64, b: f64| peak(&p.probe("tine[0].pluck[0]", BUILT.at(a, b)));
                    let touch = [[0.1, 0.172, 0.4], [3.1, 3.172, 3.6], [3.7, 3.772, 5.0]];
                    touch.map(|[a, b, c]| of(b, c) / of(a, b)).into_iter().fold(0.0, f64::max)
                },
                range: [0.0, 0.25],
            },
            Claim {
                sentence: "a tune that grows louder",
                shows: "the last chord above the first note: {} dB",
                measure: |p| p.peak(BUILT.at(3.65, 4.2)) - p.peak(BUILT.at(0.1, 0.5)),
                range: [6.0, NEVER_MORE],
            },
        ],
        remark: "Pure tines, in tune; a stronger note is louder but not brighter, since plucked cells are linear.",
        ..Instrument::new("kalimba")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 196.0, cut: BUILT.at(0.15, 0.45) }),
        soft: SOFT_D5.at(0.1, 0.44),
        loud: LOUD_D5.at(0.1, 0.44),
        decay: BUILT.at(5.5, 8.0),
        probes: &["bar[0].tube", "bar[0].wood[0]", "key[11].strike[0]"],
        claims: &[
            Claim {
                sentence: "three cells at 1 : 4 : 10, as makers carve them",
                shows: "largest deviation of partials 2 and 3 of D5 from 4 and 10 times its pitch: {} cents",
                measure: |p| {
                    let off = [4.0, 10.0].map(|r| p.cents(r * 587.3295, LOUD_D5.at(0.11, 0.4)));
                    off.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
                },
                range: [-5.0, 5.0],
            },
            Claim {
                sentence: "swings wider than the wood",
                shows: "amplitude of the air under G3 over the amplitude of the wood: {}",
                measure: |p| {
                    let of = |name| rms(&p.probe(name, BUILT.at(0.2, 0.45)));
                    of("bar[0].tube") / of("bar[0].wood[0]")
                },
                range: [2.0, NEVER_MORE],
            },
            Claim {
                sentence: "loud notes are brighter",
                shows: "centroid of D5 struck in 8 ms over the centroid in 30 ms: {}",
                measure: |p| p.colour(LOUD_D5.at(0.08, 0.44)) / p.colour(SOFT_D5.at(0.08, 0.44)),
                range: [1.5, NEVER_MORE],
            },
            Claim {
                sentence: "throws a mallet, which strikes once",
                shows: "times the mallet of D5 touches its bar in the gesture, which plays it once: {}",
                measure: |p| p.contacts("key[11].strike[0]", BUILT.whole()),
                range: [1.0, 1.0],
            },
        ],
        remark: "The resonance of the air is loudest and makes each note full; a soft stroke is little more than the \
                 first partial, a loud one also has the ring of the wood for a third of a second.",
        ..Instrument::new("marimba")
    },
];

/// Returns the share of its swing lost in a second, from a line through the peaks around these times.
pub fn loss_a_second(x: &dyn Fn(f64, f64) -> Vec<f64>, at: &[f64]) -> f64 {
    let points: Vec<[f64; 2]> = at.iter().map(|t| [*t, db(peak(&x(t - 0.3, t + 0.3)))]).collect();
    1.0 - 10f64.powf(slope(&points) / 20.0)
}
