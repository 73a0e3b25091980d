//! Instruments that fly, fall and collide in space.

use super::{BUILT, Claim, Instrument, Pitch, Plays, Stroke};

const NEVER_MORE: f64 = f64::INFINITY;

/// Returns the duration of each force of these probes in the built-in gesture \[s\].
fn blows(p: &Plays, of: &str) -> Vec<f64> {
    let r = p.play(BUILT);
    let mut all = Vec::new();
    for (_, force) in r.probe.iter().filter(|x| x.0.starts_with(of)) {
        all.extend(force.split(|f| *f == 0.0).filter(|b| !b.is_empty()).map(|b| b.len() as f64 / r.rate));
    }
    all.sort_by(f64::total_cmp);
    all
}

/// A hand that swings a thread of 150 mm at its frequency, 1.29 Hz.
const SWUNG: &[[f64; 2]] = &[
    [0.0, 0.0],
    [0.194, 9e-3],
    [0.582, -9e-3],
    [0.97, 9e-3],
    [1.358, -9e-3],
    [1.746, 9e-3],
    [2.134, -9e-3],
    [2.522, 9e-3],
    [2.91, -9e-3],
    [3.298, 9e-3],
    [3.686, 0.0],
];

pub static ALL: &[Instrument] = &[
    Instrument {
        pitch: Some(Pitch { hertz: 880.0, cut: BUILT.at(5.0, 8.0) }),
        soft: BUILT.way(0.8).seconds(5.0).at(0.0, 5.0),
        loud: BUILT.at(0.0, 5.0),
        decay: BUILT.at(4.3, 9.0),
        probes: &["knock_a", "knock_b", "knock_c", "knock_d", "knock_e"],
        // the built-in gesture is the wind, so the hand has its own
        stroke: Stroke { motions: &[(0, SWUNG)], ..Stroke::DEFAULT },
        claims: &[
            Claim {
                sentence: "the tubes are silent at 11 s",
                shows: "largest sample of the last half second: {} dBFS",
                measure: |p| p.peak(BUILT.at(10.5, 11.0)),
                range: [f64::NEG_INFINITY, -80.0],
            },
            Claim {
                sentence: "then the air damps the threads",
                shows: "strongest blow of the clapper later than a second after the wind, as a part of the strongest: {}",
                // not the time of the last blow: the swing is chaotic, and the last digits of a mass move it by seconds
                measure: |p| {
                    let r = p.play(BUILT);
                    let calm = (5.3 * r.rate) as usize;
                    let strongest = |from: usize| {
                        r.probe.iter().flat_map(|(_, force)| &force[from..]).fold(0.0, |most: f64, f| most.max(f.abs()))
                    };
                    strongest(calm) / strongest(0)
                },
                range: [0.0, 0.6],
            },
        ],
        remark: "Five tubes in tune with bright, inharmonic partials; each is one stiff string of five masses, so that it has five partials and \
                 no more, and the harder blow is little brighter.",
        ..Instrument::new("chimes")
    },
    Instrument {
        soft: BUILT.set(&["room.pebble.m=1 g"]).at(0.0, 1.0),
        loud: BUILT.at(0.0, 1.0),
        claims: &[
            Claim {
                sentence: "room.pebble.m=\"1 g\" (softer",
                shows: "level with a pebble of 1 g below the level of the model: {} dB",
                measure: |p| p.level(BUILT.at(0.0, 1.0)) - p.level(BUILT.set(&["room.pebble.m=1 g"]).at(0.0, 1.0)),
                range: [2.0, 12.0],
            },
            Claim {
                sentence: "room.crystal.k=\"100 kN/m\" (lower)",
                shows: "centroid with it over the centroid of the model; √(1/5) is 0.447: {}",
                measure: |p| {
                    p.colour(BUILT.set(&["room.crystal.k=100 kN/m"]).at(0.0, 1.0)) / p.colour(BUILT.at(0.0, 1.0))
                },
                range: [0.38, 0.52],
            },
        ],
        remark: "Four partials from 1.9 to 4.7 kHz, the lowest by far the strongest, so the sound is thin; a softer blow hardly changes the timbre.",
        ..Instrument::new("crystal")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 220.0, cut: BUILT.at(0.15, 0.28) }),
        soft: BUILT.at(0.6, 1.0),
        loud: BUILT.at(0.1, 0.6),
        claims: &[
            Claim {
                sentence: "comes to rest on the skin",
                shows: "largest sample of the last half second: {} dBFS",
                measure: |p| p.peak(BUILT.at(3.5, 4.0)),
                range: [f64::NEG_INFINITY, -60.0],
            },
            Claim {
                sentence: "Its edges ring far above the drum and sound in the right channel",
                shows: "centroid of the right channel over the centroid of the left: {}",
                measure: |p| {
                    let r = p.play(BUILT);
                    let of = |k: usize| crate::acoustics::centroid(r.part(&r.sound[k], 0.1, 1.0), r.rate);
                    of(1) / of(0)
                },
                range: [3.0, NEVER_MORE],
            },
        ],
        remark: "The rhythm of a tumbling object; the drum is simple and eleven masses wide, the star of seven points has few partials.",
        ..Instrument::new("jack")
    },
    Instrument {
        soft: BUILT.way(0.7).seconds(2.0).at(0.0, 2.0),
        loud: BUILT.at(0.0, 2.0),
        decay: BUILT.at(3.3, 5.0),
        stroke: Stroke { clear: 0.15, ..Stroke::DEFAULT },
        claims: &[
            Claim {
                sentence: "95 % of the power is above 3 kHz",
                shows: "share of it: {}",
                measure: |p| p.above(3000.0, BUILT.at(0.0, 5.0)),
                range: [0.92, 0.98],
            },
            Claim {
                sentence: "they come to rest and the sound ends",
                shows: "largest sample of the last 0.3 s: {} dBFS",
                measure: |p| p.peak(BUILT.at(4.7, 5.0)),
                range: [f64::NEG_INFINITY, -55.0],
            },
        ],
        remark: "Bright grains with the rhythm of the hand; the gourd itself, which should sound below 2 kHz, is hardly audible.",
        ..Instrument::new("maracas")
    },
    Instrument {
        soft: BUILT.way(0.7).seconds(2.5).at(0.4, 2.5),
        loud: BUILT.at(0.4, 2.5),
        decay: BUILT.at(4.4, 6.0),
        probes: &["keep[*]"],
        stroke: Stroke { clear: 0.1, ..Stroke::DEFAULT },
        claims: &[
            Claim {
                sentence: "Blows of a fifth of a millisecond",
                shows: "median of all blows on the shell: {} ms",
                measure: |p| {
                    let all = blows(p, "keep");
                    1e3 * all[all.len() / 2]
                },
                range: [0.15, 0.25],
            },
            Claim {
                sentence: "80 % of the power is above 3 kHz",
                shows: "share of it: {}",
                measure: |p| p.above(3000.0, BUILT.at(0.0, 7.0)),
                range: [0.77, 0.83],
            },
        ],
        remark: "Sharp, like the rattle of the paper; the rest, a fifth of the power, is nearly all between 1 and 3 \
                 kHz, so the sound lacks low frequencies.",
        ..Instrument::new("rattle")
    },
    Instrument {
        soft: BUILT.way(0.7).seconds(2.5).at(0.4, 2.5),
        loud: BUILT.at(0.4, 2.5),
        decay: BUILT.at(4.8, 6.0),
        probes: &["keep[*]"],
        stroke: Stroke { clear: 0.45, ..Stroke::DEFAULT },
        claims: &[
            Claim {
                sentence: "Blows last a fifth of a millisecond, as there",
                shows: "median of all blows on the shell: {} ms",
                measure: |p| {
                    let all = blows(p, "keep");
                    1e3 * all[all.len() / 2]
                },
                range: [0.15, 0.25],
            },
            Claim {
                // rounding in its collisions moves this by some hundredths
                sentence: "four fifths of the power are above 3 kHz",
                shows: "share of it: {}",
                measure: |p| p.above(3000.0, BUILT.at(0.0, 7.0)),
                range: [0.75, 0.87],
            },
        ],
        remark: "It sounds like `rattle`; a shake strikes up to 0.2 s after the turn of the hand, so it is harder to \
                 time than a knock by two keys.",
        ..Instrument::new("rattle_stick")
    },
    Instrument {
        pitch: Some(Pitch { hertz: 1174.7, cut: BUILT.at(2.0, 4.0) }),
        soft: BUILT.at(3.0, 5.0),
        loud: BUILT.at(0.1, 1.5),
        probes: &["hop[4]"],
        claims: &[
            Claim {
                sentence: "falls by its weight from a different height",
                shows: "delay of the first touch of bead `e` after √(2 h / g): {} %",
                measure: |p| {
                    let x = p.probe("hop[4]", BUILT.whole());
                    let first = x.iter().position(|f| *f != 0.0).unwrap_or(0) as f64 / p.play(BUILT).rate;
                    100.0 * (first / (2.0 * p.number("beads.e.x") / 9.81).sqrt() - 1.0)
                },
                range: [-0.2, 0.2],
            },
            Claim {
                sentence: "the last chime is silent before 7 s",
                shows: "largest sample of the last 0.2 s: {} dBFS",
                measure: |p| p.peak(BUILT.at(6.8, 7.0)),
                range: [f64::NEG_INFINITY, -60.0],
            },
        ],
        remark: "The rhythm of bouncing balls; a chime is one mode, so each is a sine with a click, the first four cents sharp.",
        ..Instrument::new("rain_stick")
    },
    Instrument {
        soft: BUILT.at(1.0, 2.2),
        loud: BUILT.at(3.4, 4.6),
        decay: BUILT.at(4.0, 6.0),
        claims: &[
            Claim {
                sentence: "the faster, the louder (8.5 dB from the first to the third toss of the gesture)",
                shows: "the third above the first: {} dB",
                measure: |p| p.level(BUILT.at(3.4, 4.6)) - p.level(BUILT.at(1.0, 2.2)),
                range: [6.0, 11.0],
            },
            Claim {
                sentence: "Thirty-two grains lie in a box",
                shows: "level of the half second before the first toss, below the level of the toss: {} dB",
                measure: |p| p.level(BUILT.at(1.0, 2.2)) - p.level(BUILT.at(0.5, 1.0)),
                range: [10.0, NEVER_MORE],
            },
        ],
        remark: "A rain of notes that no hand could play, the louder the faster; all blows have one hardness, so loud \
                 tosses are hardly brighter.",
        ..Instrument::new("tossed_grains")
    },
];
