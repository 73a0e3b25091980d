//! The pass that solves for all links collected in a tick and applies their pushes.

use super::system::{Response, gathered, respond};
use super::{cluster, quadratised, sweeps};
use crate::numeric::{Precision, Real};
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;
use crate::state::active_contacts::{ActiveContact, ActiveContacts, Part};

/// Solves for the pushes of all collected links. `MODES` is true if several act at modal masses of one group, `SWEEPS`
/// if sweeps precede Newton's method.
pub fn solve<R: Real, const MODES: bool, const SWEEPS: bool>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let ActiveContacts { n, list, push, unsolved } = &mut s.links.touches;
    let all = &mut list[..core::mem::take(n)];
    if all.iter().all(|t| t.part == Part::Waits) {
        return;
    }
    let mobility = &s.coef[2 * layout.counts.n_mat..];
    let mut to = Response::<R, MODES> { layout, mobility, push, tap: &mut s.links.tap };
    let curved = all.iter().any(|t| t.curve.is_some());
    let solved = SWEEPS && curved && sweeps::swept(all, &mut to);
    let acting = match curved {
        _ if solved && !matches!(R::PRECISION, Precision::Dual) => all.len(),
        true => {
            *unsolved += u64::from(!cluster::newton(all, &mut to, solved));
            gathered(all, |t| t.part != Part::LeftOut)
        }
        false => quadratised::pushes(all, &mut to),
    };
    let (acting, left_out) = all.split_at_mut(acting);
    for t in &mut *acting {
        if t.curve.is_some() {
            // added to the energy lost at the beginning of the tick
            s.links.mem[t.mem] += cluster::heat(t, &layout.tables);
        } else {
            quadratised::keep(t, &mut s.links.mem);
        }
        apply(t, &mut s.f, &mut s.links.tap);
    }
    if left_out.is_empty() {
        return;
    }
    for t in &mut *left_out {
        t.p = R::ZERO;
    }
    let left_out = acting.len()..;
    respond(all, &mut Response::<R, MODES> { layout, mobility, push, tap: &mut s.links.tap });
    for t in &all[left_out] {
        quadratised::follow(t, &mut s.links.mem);
    }
}

fn apply<R: Real>(t: &ActiveContact<R>, f: &mut [R], taps: &mut [R]) {
    for k in 0..t.axes {
        let [a, b] = t.ends.map(|m| m as usize + k);
        f[a] += t.g[k] * t.p;
        f[b] -= t.g[k] * t.p;
    }
    if let Some(tap) = t.tap {
        taps[tap] = -t.side * t.p;
    }
}
