//! The pass that solves for all links collected in a tick and applies their pushes.

use super::system::{Response, gathered, places, respond};
use super::{cluster, quadratised, sweeps};
use crate::numeric::{Precision, Real};
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;
use crate::state::active_contacts::{ActiveContact, ActiveContacts, Part};

/// Solves for the pushes of all collected links. `MODES` is true if several act at modal masses of one group, `SWEEPS`
/// if sweeps precede Newton's method.
pub fn solve<R: Real, const MODES: bool, const SWEEPS: bool>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let ActiveContacts { regions, list, push, unsolved } = &mut s.links.touches;
    let mobility = &s.coef[2 * layout.counts.n_mat..];
    let mut to = Response::<R, MODES> { layout, mobility, push, tap: &mut s.links.tap };
    for region in regions {
        let all = &mut list[region.first..][..core::mem::take(&mut region.n)];
        if all.iter().any(|t| t.part != Part::Waits) {
            *unsolved += u64::from(!solve_one::<R, MODES, SWEEPS>(all, &mut to, &mut s.f, &mut s.links.mem));
        }
    }
}

/// Solves for the pushes of a cluster and applies them. Returns false at the iteration limit.
#[inline(always)]
fn solve_one<R: Real, const MODES: bool, const SWEEPS: bool>(
    all: &mut [ActiveContact<R>],
    to: &mut Response<R, MODES>,
    f: &mut [R],
    mem: &mut [R],
) -> bool {
    let curved = all.iter().any(|t| t.curve.is_some());
    let solved = SWEEPS && curved && sweeps::swept(all, to);
    let mut within = true;
    let acting = match curved {
        _ if solved && !matches!(R::PRECISION, Precision::Dual) => all.len(),
        true => {
            within = cluster::newton(all, to, solved);
            gathered(all, |t| t.part != Part::LeftOut)
        }
        false => quadratised::pushes(all, to),
    };
    let (acting, left_out) = all.split_at_mut(acting);
    for t in &mut *acting {
        if t.curve.is_some() {
            // added to the energy lost at the beginning of the tick
            mem[t.mem] += cluster::heat(t, &to.layout.tables);
        } else {
            quadratised::keep(t, mem);
        }
        apply(t, f, to.tap);
    }
    if left_out.is_empty() {
        return within;
    }
    for t in &mut *left_out {
        t.p = R::ZERO;
    }
    let left_out = acting.len()..;
    respond(all, to);
    for t in &all[left_out] {
        quadratised::follow(t, mem);
    }
    within
}

fn apply<R: Real>(t: &ActiveContact<R>, f: &mut [R], taps: &mut [R]) {
    places(t, |a, b, g| {
        f[a] += g * t.p;
        f[b] -= g * t.p;
    });
    if let Some(tap) = t.tap {
        taps[tap] = -t.side * t.p;
    }
}
