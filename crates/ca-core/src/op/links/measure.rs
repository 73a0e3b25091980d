//! Measures: how a port measures the elongation of its two ends, and applies a force to them. See [`MeasureKind`].
//!
//! A law never sees positions. A measure turns its scalar force into forces on the ends along the gradient of the
//! elongation, so power in equals power out for any law. The elongation is a difference on a line, a projected
//! difference along a direction, and a distance in space. The kernels in space, the quadripoles of other crates, the
//! energy ledger and the start all use these functions.
//!
//! The change of a distance is relative to the distance one tick before (docs/numerics.md §1.1). Links that are
//! measured in every tick store it ([`Measure::follow`], [`LinkState::lengths`](crate::state::LinkState::lengths)),
//! with one square root and without reading motion. Contacts are measured only when closed, with the change from motion
//! ([`Measure::measure`]), as `(D + D')·(D − D') / (l + l')` with D' the vector one tick before.
//!
//! At zero length the direction is undefined and the force is zero (docs/numerics.md §4.4). With a softening length δ
//! the distance is `sqrt(D² + δ²)`, smooth everywhere.

use crate::numeric::Real;
use crate::op::account::Before;
use crate::op::layout::{Layout, MeasureKind, Ports};
use nalgebra::Vector3;

/// Measurement of one port.
#[derive(Clone, Copy, Debug)]
pub struct Elongation<R: Real = f64> {
    /// contribution to the elongation \[m\]
    pub e: R,
    /// change of `e` in this tick \[m/tick\]
    pub w: R,
    /// vector between the ends, or the direction
    pub v: Vector3<R>,
    /// length of `v`
    pub l: R,
}

impl<R: Real> Elongation<R> {
    /// Returns the gradient of the elongation at the second end. At the first it is the negative.
    pub fn gradient(&self) -> Vector3<R> {
        if self.l < R::of(LEAST) { Vector3::zeros() } else { self.v / self.l }
    }
}

/// Length below which a direction is undefined: the square of a shorter one is below the least number \[m\].
pub(super) const LEAST: f64 = 1e-150;

/// Returns the force per length along a vector of length `l`, or zero for zero length.
#[inline(always)]
pub fn density<R: Real>(force: R, l: R) -> R {
    // in this order, so that NaN stays NaN
    if l < R::of(LEAST) { R::ZERO } else { force / l }
}

/// A measure as a type, for kernels.
pub trait Measure {
    /// True where the ends are points in space, with an entry in [`LinkArrays::reach`](crate::op::layout::LinkArrays::reach).
    const SPACE: bool;

    /// Measures between the ends, with the change computed from their motion.
    fn measure<R: Real>(x: &[R], d: &[R], ends: [usize; 2], reach: &[R; 4]) -> Elongation<R>;

    /// Measures in every tick: compares a distance with `last` and stores it there. If `last` is
    /// [`UNKNOWN`](crate::state::UNKNOWN), the change is computed from motion.
    #[inline(always)]
    fn follow<R: Real>(x: &[R], d: &[R], ends: [usize; 2], reach: &[R; 4], _last: &mut R) -> Elongation<R> {
        Self::measure(x, d, ends, reach)
    }

    /// Returns the square of the elongation, a cheap test for open contacts; `None` if it would lose the sign.
    fn square<R: Real>(_x: &[R], _ends: [usize; 2], _reach: &[R; 4]) -> Option<R> {
        None
    }

    /// Pulls the ends together with `force` \[N\] along the measured direction.
    fn pull<R: Real>(f: &mut [R], ends: [usize; 2], m: &Elongation<R>, force: R);
}

/// Two positions on a line.
pub struct Line;
/// Two points in space, along a fixed direction.
pub struct Along;
/// The distance of two points in space.
pub struct Radial;

#[inline(always)]
fn at<R: Real>(x: &[R], i: usize) -> Vector3<R> {
    x[i..].first_chunk::<3>().map_or_else(Vector3::zeros, |v| Vector3::from(*v))
}

#[inline(always)]
fn vector<R: Real>(reach: &[R; 4]) -> Vector3<R> {
    Vector3::new(reach[0], reach[1], reach[2])
}

#[inline(always)]
fn between<R: Real>(x: &[R], [a, b]: [usize; 2], reach: &[R; 4]) -> Vector3<R> {
    vector(reach) + (at(x, b) - at(x, a))
}

#[inline(always)]
fn length<R: Real>(v: &Vector3<R>, reach: &[R; 4]) -> R {
    (v.dot(v) + reach[3]).sqrt()
}

#[inline(always)]
fn pull3<R: Real>(f: &mut [R], [a, b]: [usize; 2], v: &Vector3<R>, force: R) {
    let g = v * force;
    for k in 0..3 {
        f[a + k] += g[k];
        f[b + k] -= g[k];
    }
}

impl Measure for Line {
    const SPACE: bool = false;
    #[inline(always)]
    fn measure<R: Real>(x: &[R], d: &[R], [a, b]: [usize; 2], _: &[R; 4]) -> Elongation<R> {
        Elongation { e: x[b] - x[a], w: d[b] - d[a], v: Vector3::new(R::of(1.0), R::ZERO, R::ZERO), l: R::of(1.0) }
    }
    #[inline(always)]
    fn pull<R: Real>(f: &mut [R], [a, b]: [usize; 2], _: &Elongation<R>, force: R) {
        f[a] += force;
        f[b] -= force;
    }
}

impl Measure for Along {
    const SPACE: bool = true;
    #[inline(always)]
    fn measure<R: Real>(x: &[R], d: &[R], [a, b]: [usize; 2], reach: &[R; 4]) -> Elongation<R> {
        let n = vector(reach);
        Elongation { e: n.dot(&(at(x, b) - at(x, a))), w: n.dot(&(at(d, b) - at(d, a))), v: n, l: R::of(1.0) }
    }
    #[inline(always)]
    fn pull<R: Real>(f: &mut [R], ends: [usize; 2], m: &Elongation<R>, force: R) {
        pull3(f, ends, &m.v, force);
    }
}

impl Measure for Radial {
    const SPACE: bool = true;
    #[inline(always)]
    fn measure<R: Real>(x: &[R], d: &[R], [a, b]: [usize; 2], reach: &[R; 4]) -> Elongation<R> {
        let now = between(x, [a, b], reach);
        let moved = at(d, b) - at(d, a);
        let before = now - moved;
        let (l, l0) = (length(&now, reach), length(&before, reach));
        let w = (now + before).dot(&moved) / (l + l0).max(R::MIN_POSITIVE);
        Elongation { e: l, w, v: now, l }
    }
    #[inline(always)]
    fn follow<R: Real>(x: &[R], d: &[R], [a, b]: [usize; 2], reach: &[R; 4], last: &mut R) -> Elongation<R> {
        let now = between(x, [a, b], reach);
        let l = length(&now, reach);
        if *last < R::ZERO {
            *last = length(&(now - (at(d, b) - at(d, a))), reach);
        }
        let w = l - *last;
        *last = l;
        Elongation { e: l, w, v: now, l }
    }
    #[inline(always)]
    fn square<R: Real>(x: &[R], ends: [usize; 2], reach: &[R; 4]) -> Option<R> {
        let now = between(x, ends, reach);
        Some(now.dot(&now) + reach[3])
    }
    #[inline(always)]
    fn pull<R: Real>(f: &mut [R], ends: [usize; 2], m: &Elongation<R>, force: R) {
        pull3(f, ends, &m.v, density(force, m.l));
    }
}

/// Measures with a measure known only at run time, for code other than kernels.
pub fn measure<R: Real>(measure: MeasureKind, x: &[R], d: &[R], ends: [u32; 2], reach: &[R; 4]) -> Elongation<R> {
    let ends = ends.map(|m| m as usize);
    match measure {
        MeasureKind::Line => Line::measure(x, d, ends, reach),
        MeasureKind::Along => Along::measure(x, d, ends, reach),
        MeasureKind::Radial => Radial::measure(x, d, ends, reach),
    }
}

/// Measures a port around a tick, seen from after it: `x` and `d` are the positions after it and the motion of that tick.
/// Returns its elongations before, at and after the tick, and the motion of its ends over both intervals along the
/// direction at the tick. That direction follows from the positions at the tick, bit for bit as the force does: between
/// ends at almost one place it is all in the rounding.
#[inline(always)]
pub fn around<R: Real>(
    measure: MeasureKind,
    (x, d): (&[R], &[R]),
    was: Before<R>,
    ends: [u32; 2],
    reach: &[R; 4],
) -> ([R; 3], R) {
    let ([a, b], d0) = (ends.map(|m| m as usize), was.d);
    if measure == MeasureKind::Line {
        let after = x[b] - x[a];
        let at = after - (d[b] - d[a]);
        let before = at - (d0[b] - d0[a]);
        return ([before, at, after], after - before);
    }
    let (out, into) = (at(d, b) - at(d, a), at(d0, b) - at(d0, a));
    let after = at(x, b) - at(x, a);
    let v = vector(reach);
    if measure == MeasureKind::Along {
        let (after, out, into) = (v.dot(&after), v.dot(&out), v.dot(&into));
        return ([after - out - into, after - out, after], out + into);
    }
    let now = v + was.x.map_or(after - out, |x| at(x, b) - at(x, a));
    let l = length(&now, reach);
    let along = density(now.dot(&(out + into)), l);
    ([length(&(now - into), reach), l, length(&(now + out), reach)], along)
}

/// Returns measure, ends and reach of each port of link `i` of a batch whose first link is `first`.
pub fn ports<R: Real>(
    layout: &Layout<R>,
    ports: &Ports,
    first: usize,
    i: usize,
) -> impl Iterator<Item = (MeasureKind, [u32; 2], [R; 4])> {
    let reach =
        |g: MeasureKind, at: usize| if g == MeasureKind::Line { [R::ZERO; 4] } else { layout.links.reach[at + i] };
    let one = (ports.measure, layout.links.ends[first + i], reach(ports.measure, ports.reach));
    let two = ports.onto.map(|(g, ends, at)| (g, layout.links.onto[ends + i], reach(g, at)));
    core::iter::once(one).chain(two)
}
