//! Plays the growth of explicit contacts that findings report: a lossless ball between two walls, from random starts
//! (docs/numerics.md §3.2).
//!
//! Stiffness, position and speed are drawn, because a single value may hit a stiffness that makes no energy at any
//! phase. Drawing uses products and sums only, so that every machine plays the same starts.

use crate::play::{Random, mat, scene};
use ca_core::internal::scene::growth::{Growth, MEASURED, SECONDS, STARTS, TIMES};
use ca_core::tick;
use ca_tests::long_form::long_form;

const RATE: f64 = 48e3;
const MASS: f64 = 1e-3;
/// Positions of the walls \[m\].
const WALLS: [f64; 2] = [-0.01, 0.0137];

/// A random number from 0 to 1.
fn part(drawn: &mut Random) -> f64 {
    0.5 * (drawn.uniform() + 1.0)
}

/// Number of [`STARTS`] around a stiffness kT²/m whose energy exceeds [`TIMES`] the initial one within [`SECONDS`].
fn grew(stiffness: f64) -> u32 {
    let mut drawn = Random(0x9e37_79b9_7f4a_7c15);
    (0..STARTS).map(|_| u32::from(grows(stiffness, &mut drawn))).sum()
}

/// Returns true if one start grows so far.
fn grows(stiffness: f64, drawn: &mut Random) -> bool {
    let k = stiffness * (0.7 + 0.7 * part(drawn)) * MASS * RATE * RATE;
    let x = WALLS[0] + (WALLS[1] - WALLS[0]) * part(drawn);
    let speed = 0.1 + 2.9 * part(drawn);
    let v = if part(drawn) < 0.5 { -speed } else { speed };
    let [low, high] = WALLS;
    let scene = scene(&format!(
        "[SOL]\nl = {{ x = {low:?} }}\nr = {{ x = {high:?} }}\n[MAS]\nb = {{ m = {MASS:?}, dx0 = {x:?}, v = {v:?} }}\n[BUT]\n\
         c = {{ between = [\"l\", \"b\"], k = {k:?} }}\nd = {{ between = [\"b\", \"r\"], k = {k:?} }}\n[SOX]\n\
         o = {{ from = \"b\" }}\n"
    ));
    let ball = mat(&scene, "b");
    let mut s = scene.state();
    let most = TIMES * (v / RATE) * (v / RATE);
    let free = |x: f64| (low..=high).contains(&x);
    for _ in 0..u64::from(SECONDS) * RATE as u64 {
        tick(&scene, &mut s);
        // between the walls all of its energy is motion
        let (x, d) = (s.x[ball], s.d[ball]);
        if free(x) && free(x - d) && d * d > most {
            return true;
        }
    }
    false
}

/// Plays each figure that findings report. The core suite plays stiff contacts, which grow within seconds. The long
/// form also plays soft ones, a minute of sound for most starts.
#[test]
fn contacts_grow_as_often_as_is_said() {
    let all = long_form("the growth of soft contacts over a minute");
    let played: Vec<Growth> = MEASURED.into_iter().filter(|g| all || g.stiffness >= 0.3).collect();
    let again: Vec<Growth> =
        played.iter().map(|g| Growth { stiffness: g.stiffness, grew: grew(g.stiffness) }).collect();
    assert_eq!(again, played);
}

#[test]
fn a_contact_is_told_the_figure_of_the_next_stiffness() {
    assert_eq!(Growth::near(0.05).stiffness, 0.1);
    assert_eq!(Growth::near(0.1).stiffness, 0.1);
    assert_eq!(Growth::near(1e6).stiffness, 2.0);
    assert!(MEASURED.windows(2).all(|g| g[0].stiffness < g[1].stiffness && g[0].grew <= g[1].grew));
}

#[test]
fn the_page_has_the_figures() {
    let page = include_str!("../../../docs/numerics.md");
    for Growth { stiffness, grew } in MEASURED {
        assert!(page.contains(&format!("| {stiffness} | {grew} |")), "{stiffness}: {grew}");
    }
}
