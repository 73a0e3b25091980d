//! The linear system of contacts that are solved together, and the functions that collect it.
//!
//! Let G be the gradients of the active penetrations, W = T² G M⁻¹ Gᵀ their mobilities, s* the change of penetration
//! over two ticks by all other forces, b the push without motion, and R its slope. The push is N = b + y with
//! ```text
//! (W + R⁻¹) y = s* − W b
//! ```
//! The matrix is symmetric and positive definite, and the right side is in the range of W. Components that W does not
//! see (a mass held from more sides than it has axes) stay zero in y.
//!
//! Conjugate gradients with diagonal scaling solve it. They store one vector over slots, where a factorisation would
//! need memory in the square of the number of contacts, and solve unconnected contacts in one step.

use super::{free_motion, mobility, modes};
use crate::numeric::{Precision, Real};
use crate::op::Op;
use crate::op::layout::Layout;
use crate::op::links::measure::Measure;
use crate::state::State;
use crate::state::active_contacts::{ActiveContact, Part, Port};
use nalgebra::Vector3;

/// Returns the factor by which the squared residual must fall.
fn exact<R: Real>() -> R {
    R::of(if matches!(R::PRECISION, Precision::Single) { 3e-13 } else { 1e-30 })
}

/// Returns the energy \[J\] below which motion is ignored: its squares underflow in the solver.
pub(super) fn nothing<R: Real>() -> R {
    R::of(if matches!(R::PRECISION, Precision::Single) { 1e-35 } else { 1e-200 })
}

/// Ends of a link, and its motion by all other forces.
#[derive(Clone, Copy)]
pub(super) struct Reach<R: Real> {
    port: Port<R>,
    /// second pair of ends, of a quadripole
    onto: Option<Port<R>>,
    /// number of its cluster
    cluster: usize,
    tap: Option<usize>,
    side: R,
    /// change of penetration over two ticks \[m\]
    pub(super) free: R,
    /// mobility of all ends \[m/N\]
    pub(super) own: R,
}

impl<R: Real> Reach<R> {
    /// Adds a second pair of ends; `u` is the gradient of its elongation.
    #[inline(always)]
    pub(super) fn and<G: Measure>(self, layout: &Layout<R>, s: &State<R>, ends: [u32; 2], u: Vector3<R>) -> Reach<R> {
        let (onto, free, own) = port::<R, G>(layout, s, ends, self.side, u);
        Reach { onto: Some(onto), free: self.free + free, own: self.own + own, ..self }
    }
}

/// Returns a pair of ends, the change of penetration over two ticks by all other forces, and the mobility of both ends.
#[inline(always)]
fn port<R: Real, G: Measure>(
    layout: &Layout<R>,
    s: &State<R>,
    ends: [u32; 2],
    side: R,
    u: Vector3<R>,
) -> (Port<R>, R, R) {
    let g: [R; 3] = (u * -side).into();
    let axes = if G::SPACE { 3 } else { 1 };
    let (mut free, mut own) = (R::ZERO, R::ZERO);
    for (k, g) in g[..axes].iter().enumerate() {
        let [a, b] = ends.map(|m| m as usize + k);
        free += *g * (free_motion(layout, s, b) + s.d[b] - free_motion(layout, s, a) - s.d[a]);
        own += *g * *g * (mobility(layout, s, a) + mobility(layout, s, b));
    }
    (Port { ends, axes, g }, free, own)
}

/// Measures the reach of link `i` of `op`; `u` is the gradient of its elongation.
#[inline(always)]
pub(super) fn reach<R: Real, G: Measure>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &State<R>,
    i: usize,
    side: R,
    u: Vector3<R>,
) -> Reach<R> {
    let (port, free, own) = port::<R, G>(layout, s, layout.links.ends[op.first + i], side, u);
    let tap = op.form.tap.then_some(op.tap + i);
    let cluster = layout.links.clusters.get(op.first + i).map_or(0, |c| *c as usize);
    Reach { port, onto: None, cluster, tap, side, free, own }
}

/// Adds a link to the list of this tick and returns its record, in which all but the reach is from an earlier tick.
#[inline(always)]
pub(super) fn enter<R: Real>(s: &mut State<R>, mem: usize, by: Reach<R>) -> Option<&mut ActiveContact<R>> {
    let touches = &mut s.links.touches;
    let Reach { port, onto, cluster, tap, side, free, own } = by;
    let region = touches.regions.get_mut(cluster).filter(|region| region.n < region.room)?;
    let t = touches.list.get_mut(region.first + region.n)?;
    region.n += 1;
    (t.mem, t.port, t.onto, t.tap, t.side, t.free, t.own) = (mem, port, onto, tap, side, free, own);
    Some(t)
}

/// Push of a link that is linear in the motion of the coming tick.
#[derive(Clone, Copy)]
pub(super) struct LinearPush<R> {
    pub(super) clip: bool,
    pub(super) open: bool,
    pub(super) gamma: R,
    pub(super) psi: R,
    pub(super) z: R,
}

/// Adds a linear link, if it has stiffness or viscosity.
pub(super) fn join<R: Real>(s: &mut State<R>, mem: usize, by: Reach<R>, link: LinearPush<R>) {
    let LinearPush { clip, open, gamma, psi, z } = link;
    let stiff = R::of(0.25) * gamma * gamma + R::of(0.5) * z;
    if stiff > R::ZERO
        && let Some(t) = enter(s, mem, by)
    {
        (t.curve, t.part, t.clip, t.open, t.went) = (None, Part::Acts, clip, open, t.free);
        (t.gamma, t.psi, t.z, t.stiff, t.bias) = (gamma, psi, z, stiff, gamma * psi);
        t.diag = t.own + R::of(1.0) / stiff;
    }
}

/// Response to pushes: the mobility of each slot, and with `MODES` the coupling of modal masses.
pub(super) struct Response<'a, R: Real, const MODES: bool> {
    pub(super) layout: &'a Layout<R>,
    pub(super) mobility: &'a [R],
    pub(super) push: &'a mut [R],
    pub(super) tap: &'a mut [R],
}

/// Calls `visit` with the slots that a link moves: at the first end, at the second end, and the gradient at the second.
#[inline(always)]
pub(super) fn places<R: Real>(t: &ActiveContact<R>, mut visit: impl FnMut(usize, usize, R)) {
    let mut each = |port: &Port<R>| {
        let [a, b] = port.ends.map(|m| m as usize);
        for k in 0..port.axes {
            visit(a + k, b + k, port.g[k]);
        }
    };
    each(&t.port);
    if let Some(onto) = &t.onto {
        each(onto);
    }
}

/// Sets `q` of each contact to W p.
pub(super) fn respond<R: Real, const MODES: bool>(list: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) {
    let Response { layout, mobility, push, tap } = to;
    for t in &*list {
        places(t, |a, b, g| {
            push[a] -= g * t.p;
            push[b] += g * t.p;
        });
    }
    if MODES {
        modes::couple(layout, push, tap);
    }
    for t in &mut *list {
        let mut q = R::ZERO;
        places(t, |a, b, g| q += g * (mobility[b] * push[b] - mobility[a] * push[a]));
        t.q = q;
    }
    for t in &*list {
        places(t, |a, b, _| (push[a], push[b]) = (R::ZERO, R::ZERO));
    }
    if MODES {
        modes::clear(layout, push);
    }
}

/// Solves for `y` of the first `acting` of the listed links; the others push by their bias.
pub(super) fn conjugate<R: Real, const MODES: bool>(
    list: &mut [ActiveContact<R>],
    acting: usize,
    to: &mut Response<R, MODES>,
) {
    for t in &mut *list {
        t.p = t.bias;
    }
    respond(list, to);
    let list = &mut list[..acting];
    let mut rho = R::ZERO;
    for t in &mut *list {
        (t.y, t.r) = (R::ZERO, t.free - t.q);
        t.p = t.r / t.diag;
        rho += t.r * t.p;
    }
    let goal = (exact::<R>() * rho).max(nothing());
    // in exact arithmetic it takes as many steps as contacts; rounding may require more
    for _ in 0..10 * list.len() + 10 {
        // values that are not finite are detected elsewhere
        if rho.wide().is_nan() || rho <= goal {
            break;
        }
        respond(list, to);
        let mut along = R::ZERO;
        for t in &mut *list {
            t.q += t.p / t.stiff;
            along += t.p * t.q;
        }
        let (step, before) = (rho / along, rho);
        rho = R::ZERO;
        for t in &mut *list {
            t.y += step * t.p;
            t.r -= step * t.q;
            rho += t.r * t.r / t.diag;
        }
        for t in &mut *list {
            t.p = t.r / t.diag + rho / before * t.p;
        }
    }
}

/// Moves the links that satisfy `are` to the front and returns their number.
pub(super) fn gathered<R: Real>(all: &mut [ActiveContact<R>], are: impl Fn(&ActiveContact<R>) -> bool) -> usize {
    let mut n = 0;
    for i in 0..all.len() {
        if are(&all[i]) {
            all.swap(i, n);
            n += 1;
        }
    }
    n
}
