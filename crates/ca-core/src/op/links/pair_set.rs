//! A contact between all pairs of two sets of points in space, as one module, which computes only pairs that touch.
//!
//! Closed pairs, found by [`VerletList`], use the functions of single links in the order of the pairs, so a set has the
//! bits of its pairs written out. A containing contact (`sense = "inside"`) acts on distant pairs, so it measures all.

use super::measure::{Measure, Radial};
use crate::law::Phi;
use crate::numeric::{Real, VerletList};
use crate::op::Op;
use crate::op::account;
use crate::op::layout::{Layout, MeasureKind, PairSet};
use crate::op::wide::{Body, Simd};
use crate::state::State;
use core::marker::PhantomData;

#[inline(always)]
fn three<R: Real>(v: &[R], i: u32) -> [R; 3] {
    v[i as usize..].first_chunk::<3>().copied().unwrap_or_default()
}

#[inline(always)]
fn square<R: Real>([x, y, z]: [R; 3]) -> R {
    x * x + y * y + z * z
}

#[inline(always)]
fn pair<R: Real>(set: &PairSet, rest: &[R], i: usize, j: usize) -> ([usize; 2], [R; 4]) {
    let (a, b) = (set.members[i], set.members[j]);
    let (p, q) = (three(rest, a), three(rest, b));
    ([a as usize, b as usize], [q[0] - p[0], q[1] - p[1], q[2] - p[2], R::ZERO])
}

/// Returns the distance beyond which the force is zero; infinite for a containing contact.
#[inline(always)]
fn radius<R: Real>((from, to): (R, R)) -> R {
    if to < R::INFINITY { R::INFINITY } else { from.max(R::ZERO) }
}

#[inline(always)]
fn place<R: Real>(near: &mut VerletList, set: &PairSet, rest: &[R], x: &[R]) {
    let members = &set.members;
    near.place(|k| [three(rest, members[k]), three(x, members[k])].map(|v| v.map(R::wide)));
}

/// Applies the law of `op` to all pairs of its set. With `TAP` it stores the force on each member in `LinkState::tap`.
pub struct All<P, const C: usize, const M: usize, const TAP: bool>(PhantomData<P>);

impl<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const TAP: bool> Body<R> for All<P, C, M, TAP> {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        let Some(at) = op.ports.pair_set else { return };
        let (set, near) = (&layout.links.pair_sets[at], &mut s.links.near[at]);
        let Some(c) = s.coef[op.coef..].first_chunk::<C>() else { return };
        let (x, d, f, rest) = (&s.x[..], &s.d[..], &mut s.f[..], &layout.places.rest);
        let tap = if TAP { &mut s.links.tap[op.tap..][..3 * set.members.len()] } else { &mut [] };
        tap.fill(R::ZERO);
        let (from, to) = P::idle(c);
        let radius = radius((from, to));
        if radius == R::ZERO {
            return;
        }
        let (from, to) = (from.max(R::ZERO), to.max(R::ZERO));
        let mut none = [R::ZERO; M];
        place(near, set, rest, x);
        near.renew(radius.wide(), |k| square(three(d, set.members[k])).wide());
        near.each(radius.wide(), |i, j| {
            let (ends, reach) = pair(set, rest, i, j);
            if Radial::square(x, ends, &reach).is_some_and(|l| l >= from * from && l <= to * to) {
                return;
            }
            let measured = Radial::measure(x, d, ends, &reach);
            let force = P::force(c, &mut none, &layout.tables, measured.e, measured.w);
            Radial::pull(f, ends, &measured, force);
            if TAP {
                Radial::pull(tap, [3 * i, 3 * j], &measured, force);
            }
        });
    }
}

/// Returns the first pair with a force while nothing moves; `force` is a function of the elongation.
pub fn pressed<R: Real>(
    set: &PairSet,
    rest: &[R],
    x: &[R],
    idle: (R, R),
    force: impl Fn(R) -> R,
) -> Option<Pressed<R>> {
    let mut near = VerletList::new(set.members.len(), set.rows, set.columns);
    place(&mut near, set, rest, x);
    near.renew(radius(idle).wide(), |_| 0.0);
    let mut found: Option<Pressed<R>> = None;
    near.each(radius(idle).wide(), |i, j| {
        if found.is_none() {
            let (ends, reach) = pair(set, rest, i, j);
            let e = Radial::square(x, ends, &reach).map_or(R::ZERO, R::sqrt);
            found = Some((i, j, e, force(e))).filter(|p| p.3 != R::ZERO);
        }
    });
    found
}

/// Returns the number of pairs in a neighbour list while nothing moves, and the number near enough to be measured. A
/// containing contact measures all pairs and lists none.
pub fn neighbours<R: Real>(set: &PairSet, rest: &[R], x: &[R], idle: (R, R)) -> [usize; 2] {
    let mut near = VerletList::new(set.members.len(), set.rows, set.columns);
    place(&mut near, set, rest, x);
    near.renew(radius(idle).wide(), |_| 0.0);
    let mut measured = 0;
    near.each(radius(idle).wide(), |_, _| measured += 1);
    [near.listed(), measured]
}

/// Two members of a pair set by index, their distance \[m\], and the force between them \[N\].
pub type Pressed<R = f64> = (usize, usize, R, R);

/// Calls `visit` for all pairs of a set that may have touched in the last two ticks, with the elongations before, at
/// and after the tick between them. `d0` is the motion before the last one.
pub fn for_each_contact<R: Real>(
    layout: &Layout<R>,
    s: &State<R>,
    near: &mut VerletList,
    d0: &[R],
    at: usize,
    idle: (R, R),
    mut visit: impl FnMut([R; 3]),
) {
    let (set, x, d) = (&layout.links.pair_sets[at], &s.x[..], &s.d[..]);
    place(near, set, &layout.places.rest, x);
    let fastest = |d: &[R]| set.members.iter().map(|m| square(three(d, *m))).fold(R::ZERO, R::max).sqrt();
    let moved = R::of(2.0) * (fastest(d) + fastest(d0));
    near.each((radius(idle) + moved).wide(), |i, j| {
        let (ends, reach) = pair(set, &layout.places.rest, i, j);
        visit(
            super::measure::around(
                MeasureKind::Radial,
                (x, d),
                account::Before { x: None, d: d0 },
                ends.map(|e| e as u32),
                &reach,
            )
            .0,
        );
    });
}
