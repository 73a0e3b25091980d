//! The mallet that comes with the program: what its header says of soft notes, light strings and heavy ones.

use super::heard::by_hand;
use crate::play::model;

/// Blows of a note of this velocity: the key goes its 8 mm in `attack` times 127 / velocity.
fn struck(mass: &str, with: &str, attack: f64, velocity: f64) -> usize {
    let text = format!(
        "[STRING]\nlow = {{ n = 40, f = \"A2\", t60 = \"4 s\", m = \"{mass}\" }}\n\
         [use]\nmallet = {{ part = \"mallet\", with = {{ on = \"low[8]\", note = \"A2\"{with} }} }}\n\
         [SOX]\nout = {{ from = \"low[3]\", hear = \"speed\", gain = 0.1 }}\n"
    );
    let (down, t) = (-8e-3, 0.1 + attack * 127.0 / velocity);
    let way = [(0.0, down), (0.1, down), (t, 0.0), (0.3, 0.0), (0.36, down)];
    let h = by_hand(&model(&text), &["mallet.strike"], &[("mallet.key", &way)], 0.5);
    // each contact by itself, however soon after the one before
    let touches = h.probe[0].iter().map(|f| *f != 0.0);
    touches.clone().zip(touches.skip(1)).filter(|(before, now)| !before && *now).count()
}

#[test]
fn soft_notes_are_silent_and_a_shorter_attack_reaches_them() {
    let default = [19.0, 20.0].map(|v| struck("4 g", "", 7e-3, v));
    let short = [8.0, 9.0].map(|v| struck("4 g", "", 3e-3, v));
    assert_eq!((default, short), ([0, 1], [0, 1]));
}

#[test]
fn a_light_string_and_a_heavy_one_are_struck_twice() {
    let loud = |mass: &str, with: &str| struck(mass, with, 7e-3, 127.0);
    assert_eq!(
        [loud("1 g", ""), loud("1 g", ", m = \"1 g\""), loud("4 g", ""), loud("8 g", ""), loud("16 g", "")],
        [2, 1, 1, 1, 2]
    );
}
