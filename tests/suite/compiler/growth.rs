//! The growth of explicit contacts that findings state, played.

use ca_benches::growth::grew;
use ca_core::internal::scene::growth::{Growth, MEASURED};
use ca_tests::long_form::long_form;

/// Plays each figure that findings state. The suite plays stiff contacts, which grow within seconds; the long form plays soft ones too,
/// a minute of sound for most starts.
#[test]
fn contacts_grow_as_often_as_is_said() {
    let all = long_form("the growth of soft contacts over a minute");
    let played: Vec<Growth> = MEASURED.into_iter().filter(|g| all || g.stiffness >= 0.3).collect();
    let again: Vec<Growth> =
        played.iter().map(|g| Growth { stiffness: g.stiffness, grew: grew(g.stiffness) }).collect();
    assert_eq!(again, played);
}

/// The finding has the figure of the next stiffness that was measured.
#[test]
fn a_contact_is_told_the_figure_of_the_next_stiffness() {
    assert_eq!(Growth::near(0.05).stiffness, 0.1);
    assert_eq!(Growth::near(0.1).stiffness, 0.1);
    assert_eq!(Growth::near(1e6).stiffness, 2.0);
    // the stiffer the more often
    assert!(MEASURED.windows(2).all(|g| g[0].stiffness < g[1].stiffness && g[0].grew <= g[1].grew));
}

/// docs/numerics.md has the same figures.
#[test]
fn the_page_has_the_figures() {
    let page = include_str!("../../../docs/numerics.md");
    for Growth { stiffness, grew } in MEASURED {
        assert!(page.contains(&format!("| {stiffness} | {grew} |")), "{stiffness}: {grew}");
    }
}
