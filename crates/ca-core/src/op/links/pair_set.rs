//! PairSet: a contact between all pairs of two sets of points in space, as one module: one row of coefficients, and only
//! pairs that touch are computed.
//!
//! Decides that the pairs that touch are computed exactly as single links are, by the same functions and in the order
//! of the pairs, so a set and its pairs written out agree in every bit; how they are found is for [`VerletList`]. What
//! contains (`sense = "inside"`) acts on those that are far apart: then all are measured.

use super::measure::{Measure, Radial};
use crate::law::Phi;
use crate::numeric::{Real, VerletList};
use crate::op::Op;
use crate::op::layout::{Layout, PairSet};
use crate::op::wide::{Body, Simd};
use crate::state::State;
use core::marker::PhantomData;

/// Three numbers from `i` on.
#[inline(always)]
fn three<R: Real>(v: &[R], i: u32) -> [R; 3] {
    v[i as usize..].first_chunk::<3>().copied().unwrap_or_default()
}

/// The square of a vector.
#[inline(always)]
fn square<R: Real>([x, y, z]: [R; 3]) -> R {
    x * x + y * y + z * z
}

/// The ends of a pair, and what a radial port needs beside them.
#[inline(always)]
fn pair<R: Real>(set: &PairSet, rest: &[R], i: usize, j: usize) -> ([usize; 2], [R; 4]) {
    let (a, b) = (set.members[i], set.members[j]);
    let (p, q) = (three(rest, a), three(rest, b));
    ([a as usize, b as usize], [q[0] - p[0], q[1] - p[1], q[2] - p[2], R::ZERO])
}

/// The distance beyond which there is no force; infinite where the contact contains.
#[inline(always)]
fn radius<R: Real>((from, to): (R, R)) -> R {
    if to < R::INFINITY { R::INFINITY } else { from.max(R::ZERO) }
}

/// Puts the members where they are.
#[inline(always)]
fn place<R: Real>(near: &mut VerletList, set: &PairSet, rest: &[R], x: &[R]) {
    let members = &set.members;
    near.place(|k| [three(rest, members[k]), three(x, members[k])].map(|v| v.map(R::wide)));
}

/// Applies the law of `op` to all pairs of its set; the force on each member is kept in [`LinkState::tap`](crate::state::LinkState::tap) if asked.
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

/// The first pair that presses while nothing moves: its members and its force \[N\], by `force` of the elongation.
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

/// How many pairs a neighbour list has where nothing moves, and how many of them are near enough to be measured; of what
/// contains, all are measured, and none is listed.
pub fn neighbours<R: Real>(set: &PairSet, rest: &[R], x: &[R], idle: (R, R)) -> [usize; 2] {
    let mut near = VerletList::new(set.members.len(), set.rows, set.columns);
    place(&mut near, set, rest, x);
    near.renew(radius(idle).wide(), |_| 0.0);
    let mut measured = 0;
    near.each(radius(idle).wide(), |_, _| measured += 1);
    [near.listed(), measured]
}

/// Two members of a pair set by number, their distance \[m\], and the force between them \[N\].
pub type Pressed<R = f64> = (usize, usize, R, R);

/// Calls `visit` for all pairs of a pair set that may have been in touch in the last two ticks, with the elongations
/// before, at and after the tick between them; `d0` is the motion before the last one.
pub fn touched<R: Real>(
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
            super::measure::around(crate::op::layout::MeasureKind::Radial, x, d, d0, ends.map(|e| e as u32), &reach).0,
        );
    });
}
