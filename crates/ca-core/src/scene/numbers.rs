//! All numbers with which the tick of a scene begins, in sequence, for code that writes their derivatives.
//!
//! The derivatives of coefficients, positions and lengths by a model parameter are computed outside, by differences
//! between scenes compiled with other values of the parameter (`ca-gradient`). The compiler computes smooth functions
//! to the last digits, and its formulas need no second version. Everything other than these numbers determines how the
//! tick runs, and must be the same in all of these scenes: [`structure`].

use crate::numeric::Real;
use crate::op::layout::{Counts, LinkArrays, OutputArrays, Places, PortArrays, Rates};
use crate::op::layout::{Layout, Termination};
use crate::scene::{Scene, identify};
use crate::state::{Identity, State};

/// Calls `visit` for each number (not of slow groups or devices), in the same order for the same [`structure`].
pub fn numbers<R: Real<Outer = R>>(scene: &mut Scene<R>, visit: &mut impl FnMut(&mut R)) {
    layout(&mut scene.layout, visit);
    state(&mut scene.initial, visit);
    if let Some(before) = &mut scene.before {
        state(&mut before.state, visit);
    }
}

/// Sets all numbers of a scene to 0 and returns the identity of the rest.
pub fn structure<R: Real<Outer = R>>(scene: &mut Scene<R>) -> Identity {
    numbers(scene, &mut |v| *v = R::ZERO);
    identify(
        &scene.layout,
        [&scene.passes.reads, &scene.passes.forces, &scene.passes.writes, &scene.passes.moves],
        &scene.initial,
    )
}

fn layout<R: Real<Outer = R>>(layout: &mut Layout<R>, visit: &mut impl FnMut(&mut R)) {
    // names each field, so that adding one requires a decision here
    let Layout {
        links: LinkArrays { reach, e0, ends: _, onto: _, rows: _, pair_sets: _, clusters: _ },
        places:
            Places { rest, shares, couplings, nodes: _, moving_points: _, modal: _, solved_modal: _, modal_couplings: _ },
        tables,
        ports: PortArrays { enx, driven, enf: _, tgr: _, ahead: _, crossing: _ },
        waves,
        out: OutputArrays { links: output_links, blockers, lowpass, outputs: _, of_motion: _, output_rows: _ },
        implicit,
        rates: Rates { sample_dt: _, ratio: _, frame: _, slow: _, substeps: _ },
        counts: Counts { n_mat: _, n_lia: _, n_coef: _, n_mem: _, n_touch: _, n_tap: _, channels: _, n_out: _ },
        weighed: _,
        ledger: _,
        vectors: _,
    } = layout;
    reach.as_flattened_mut().iter_mut().for_each(&mut *visit);
    for all in [e0, rest, shares, couplings, lowpass] {
        all.iter_mut().for_each(&mut *visit);
    }
    for t in tables {
        t.numbers(visit);
    }
    for d in driven {
        d.table.iter_mut().for_each(&mut *visit);
    }
    for p in enx {
        visit(&mut p.rest);
    }
    for j in &mut waves.junctions {
        visit(&mut j.z);
    }
    for d in &mut waves.delays {
        if let Termination::Lossy { loss, .. } = &mut d.end {
            [&mut loss.a, &mut loss.b, &mut loss.c].into_iter().for_each(&mut *visit);
        }
    }
    for h in output_links {
        visit(&mut h.e0);
    }
    for b in blockers {
        visit(&mut b.r);
        visit(&mut b.g);
    }
    for force in implicit.iter_mut().flat_map(|i| &mut i.forces) {
        force.moving.iter_mut().chain(&mut force.fixed).for_each(|(_, weight)| visit(weight));
    }
}

/// Visits a state at load. Temporary numbers, and numbers not yet written, have no derivative. The forces at load are
/// those that the start of mi.lib leaves to the first tick, which are also in the ledger.
fn state<R: Real<Outer = R>>(s: &mut State<R>, visit: &mut impl FnMut(&mut R)) {
    for all in [&mut s.x, &mut s.d, &mut s.coef, &mut s.links.lengths] {
        all.iter_mut().for_each(&mut *visit);
    }
    s.links.mem.iter_mut().for_each(&mut *visit);
    s.links.cells.iter_mut().flat_map(|c| &mut c.weight).for_each(&mut *visit);
    s.f.iter_mut().chain(s.ledger.iter_mut().flat_map(|l| &mut l.start_force)).for_each(visit);
    s.output.fill(R::Outer::ZERO);
}
