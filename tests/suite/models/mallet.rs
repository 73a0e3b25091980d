//! The mallet part shipped with the program, checked against its header: soft notes, light and heavy strings.

use super::rendering::by_hand;
use crate::play::model;

/// Number of contacts at this velocity. The key travels 8 mm; its speed is linear in velocity, a fifth at 0.
fn struck(mass: &str, with: &str, attack: f64, velocity: f64) -> usize {
    let text = format!(
        "[STRING]\nlow = {{ n = 40, f = \"A2\", t60 = \"4 s\", m = \"{mass}\" }}\n\
         [use]\nmallet = {{ part = \"mallet\", with = {{ on = \"low[8]\", note = \"A2\"{with} }} }}\n\
         [SOX]\nout = {{ from = \"low[3]\", hear = \"speed\", gain = 0.1 }}\n"
    );
    let (down, t) = (-8e-3, 0.1 + attack / (0.2 + 0.8 * velocity / 127.0));
    let way = [(0.0, down), (0.1, down), (t, 0.0), (0.3, 0.0), (0.36, down)];
    let h = by_hand(&model(&text), &["mallet.strike"], &[("mallet.key", &way)], 0.5);
    // counts each contact, however soon after the last
    let touches = h.probe[0].iter().map(|f| *f != 0.0);
    touches.clone().zip(touches.skip(1)).filter(|(before, now)| !before && *now).count()
}

#[test]
fn the_softest_note_sounds_unless_its_key_is_slow() {
    assert_eq!([7e-3, 9e-3, 10e-3].map(|attack| struck("4 g", "", attack, 1.0)), [1, 1, 0]);
    assert_eq!(struck("4 g", "", 10e-3, 6.0), 1);
}

#[test]
fn a_light_string_and_a_heavy_one_are_struck_twice() {
    let loud = |mass: &str, with: &str| struck(mass, with, 7e-3, 127.0);
    assert_eq!(
        [loud("1 g", ""), loud("1 g", ", m = \"1 g\""), loud("4 g", ""), loud("8 g", ""), loud("16 g", "")],
        [2, 1, 1, 1, 2]
    );
}
