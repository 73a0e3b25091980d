//! Passes and arrays exist only for features in use: space, second ports, pair sets, rate boundaries, filters.

use crate::play::{scene, with};
use ca_compile::Options;
use ca_core::Scene;

fn passes(s: &Scene) -> Vec<&'static str> {
    [&s.passes.reads[..], s.passes.summed(), &s.passes.writes, &s.passes.moves]
        .into_iter()
        .flatten()
        .map(ca_core::internal::op::Op::name)
        .collect()
}

/// Length of every array that only some scenes need.
fn arrays(s: &Scene) -> [usize; 17] {
    let t = s.state();
    let (few, many) = (&s.layout, &t);
    let touches = usize::from(many.links.touches != ca_core::internal::state::ActiveContacts::default());
    [
        few.links.onto.len(),
        few.links.reach.len(),
        few.links.pair_sets.len(),
        few.places.moving_points.len(),
        few.ports.enx.len(),
        few.ports.enf.len(),
        few.ports.tgr.len(),
        few.weighed.len(),
        few.out.blockers.len(),
        few.out.lowpass.len(),
        many.links.cells.len(),
        many.links.near.len(),
        many.ports.border.len(),
        many.ports.late.len(),
        many.ports.blocked.len(),
        many.ports.lowpass.len(),
        touches,
    ]
}

const STRING: &str = "[STRING]\ns = { n = 30, m = 1e-3, k = 1e5, z = 1e-3 }\n[SOX]\nout = { from = \"s[3]\" }\n";
/// A body in space, a sheet it pulls at and a pair set, all without an output.
const SILENT: &str = "[room]\ndim = 3\n[room.TETRA]\np = { edge = 0.02, m = 1e-3 }\n[room.GRAINS]\n\
                      g = { n = 60, gap = 0.01, m = 1e-4 }\n[CEL]\nc = { m = 1e-3, k = 1e5 }\n[SOL]\nrim = {}\n[LPR]\n\
                      edges = { between = [\"room.p[*]\", \"room.p[*]\"], onto = [\"rim\", \"c\"], k = 2e4 }\n[BUT]\n\
                      grit = { between = [\"room.g[*]\", \"room.g[*]\"], k = 100, d = 5e-3 }\n";

#[test]
fn a_string_has_the_passes_of_a_string() {
    let plain = scene(STRING);
    assert_eq!(passes(&plain), ["outputs", "REF", "flush"]);
    assert_eq!(arrays(&plain), [0; 17]);
}

#[test]
fn what_nobody_hears_leaves_nothing_behind() {
    let (plain, full) = (scene(STRING), scene(&format!("{STRING}{SILENT}")));
    assert_eq!(passes(&full), passes(&plain));
    assert_eq!(arrays(&full), [0; 17]);
    assert_eq!(
        (full.counts.n_mat, full.counts.n_lia, full.counts.n_coef, full.counts.n_tap),
        (plain.counts.n_mat, plain.counts.n_lia, plain.counts.n_coef, plain.counts.n_tap)
    );
    // with outputs, all of it is there
    let heard = with(
        &format!("{STRING}{SILENT}"),
        &Options { probes: vec!["c".into(), "room.g[0]".into()], ..Options::default() },
    );
    let (names, [onto, reach, pair_sets, ..]) = (passes(&heard), arrays(&heard));
    assert!(["LPR_RES", "BUT"].iter().all(|n| names.contains(n)), "{names:?}");
    assert_eq!((onto, reach, pair_sets), (6, 7, 1));
}
