//! PairSet: a contact between all pairs of two sets of points in space, as one module: one row of coefficients, and only
//! pairs that touch are computed.
//!
//! Decides that the pairs that touch are computed exactly as single links are, by the same functions and in the order
//! of the pairs, so a set and its pairs written out agree in every bit; how they are found is for [`VerletList`]. What
//! contains (`sense = "inside"`) acts on those that are far apart: then all are measured.

use super::measure::{Measure, Radial};
use crate::law::Phi;
use crate::numeric::{Real, VerletList, real, sqrt, value};
use crate::op::Op;
use crate::op::layout::{Layout, PairSet};
use crate::op::wide::{Body, Simd};
use crate::state::State;
use core::marker::PhantomData;

/// Three numbers from `i` on.
#[inline(always)]
fn three(v: &[Real], i: u32) -> [Real; 3] {
    v[i as usize..].first_chunk::<3>().copied().unwrap_or_default()
}

/// The square of a vector.
#[inline(always)]
fn square([x, y, z]: [Real; 3]) -> Real {
    x * x + y * y + z * z
}

/// The ends of a pair, and what a radial port needs beside them.
#[inline(always)]
fn pair(set: &PairSet, rest: &[Real], i: usize, j: usize) -> ([usize; 2], [Real; 4]) {
    let (a, b) = (set.members[i], set.members[j]);
    let (p, q) = (three(rest, a), three(rest, b));
    ([a as usize, b as usize], [q[0] - p[0], q[1] - p[1], q[2] - p[2], real(0.0)])
}

/// The distance beyond which there is no force; infinite where the contact contains.
#[inline(always)]
fn radius((from, to): (Real, Real)) -> Real {
    if to < Real::INFINITY { Real::INFINITY } else { from.max(0.0) }
}

/// Puts the members where they are.
#[inline(always)]
fn place(near: &mut VerletList, set: &PairSet, rest: &[Real], x: &[Real]) {
    let members = &set.members;
    near.place(|k| [three(rest, members[k]), three(x, members[k])].map(|v| v.map(value)));
}

/// Applies the law of `op` to all pairs of its set; the force on each member is kept in [`State::tap`] if asked.
pub struct All<P, const C: usize, const M: usize, const TAP: bool>(PhantomData<P>);

impl<P: Phi<C, M>, const C: usize, const M: usize, const TAP: bool> Body for All<P, C, M, TAP> {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op, layout: &Layout, s: &mut State) {
        let Some(at) = op.ports.pair_set else { return };
        let (set, near) = (&layout.pair_sets[at], &mut s.near[at]);
        let Some(c) = s.coef[op.coef..].first_chunk::<C>() else { return };
        let (x, d, f, rest) = (&s.x[..], &s.d[..], &mut s.f[..], &layout.rest);
        let tap = if TAP { &mut s.tap[op.tap..][..3 * set.members.len()] } else { &mut [] };
        tap.fill(real(0.0));
        let (from, to) = P::idle(c);
        let radius = radius((from, to));
        if radius == 0.0 {
            return;
        }
        let (from, to) = (from.max(0.0), to.max(0.0));
        let mut none = [real(0.0); M];
        place(near, set, rest, x);
        near.renew(value(radius), |k| value(square(three(d, set.members[k]))));
        near.each(value(radius), |i, j| {
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
pub fn pressed(
    set: &PairSet,
    rest: &[Real],
    x: &[Real],
    idle: (Real, Real),
    force: impl Fn(Real) -> Real,
) -> Option<Pressed> {
    let mut near = VerletList::new(set.members.len(), set.rows, set.columns);
    place(&mut near, set, rest, x);
    near.renew(value(radius(idle)), |_| 0.0);
    let mut found: Option<Pressed> = None;
    near.each(value(radius(idle)), |i, j| {
        if found.is_none() {
            let (ends, reach) = pair(set, rest, i, j);
            let e = Radial::square(x, ends, &reach).map_or(real(0.0), sqrt);
            found = Some((i, j, e, force(e))).filter(|p| p.3 != 0.0);
        }
    });
    found
}

/// How many pairs a neighbour list has where nothing moves, and how many of them are near enough to be measured; of what
/// contains, all are measured, and none is listed.
pub fn neighbours(set: &PairSet, rest: &[Real], x: &[Real], idle: (Real, Real)) -> [usize; 2] {
    let mut near = VerletList::new(set.members.len(), set.rows, set.columns);
    place(&mut near, set, rest, x);
    near.renew(value(radius(idle)), |_| 0.0);
    let mut measured = 0;
    near.each(value(radius(idle)), |_, _| measured += 1);
    [near.listed(), measured]
}

/// Two members of a pair set by number, their distance \[m\], and the force between them \[N\].
pub type Pressed = (usize, usize, Real, Real);

/// Calls `visit` for all pairs of a pair set that may have been in touch in the last two ticks, with the elongations
/// before, at and after the tick between them; `d0` is the motion before the last one.
pub fn touched(
    layout: &Layout,
    s: &State,
    near: &mut VerletList,
    d0: &[Real],
    at: usize,
    idle: (Real, Real),
    mut visit: impl FnMut([Real; 3]),
) {
    let (set, x, d) = (&layout.pair_sets[at], &s.x[..], &s.d[..]);
    place(near, set, &layout.rest, x);
    let fastest = |d: &[Real]| sqrt(set.members.iter().map(|m| square(three(d, *m))).fold(real(0.0), Real::max));
    let moved = 2.0 * (fastest(d) + fastest(d0));
    near.each(value(radius(idle) + moved), |i, j| {
        let (ends, reach) = pair(set, &layout.rest, i, j);
        visit(
            super::measure::around(crate::op::layout::MeasureKind::Radial, x, d, d0, ends.map(|e| e as u32), &reach).0,
        );
    });
}
