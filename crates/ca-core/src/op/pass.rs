//! Passes other than links: ports, weight, moving points, outputs, integration. Each exists only if needed.

use super::Op;
use super::wide::{self, Body, Simd};
use crate::numeric::{Precision, Real};
use crate::op::layout::{CoordinateSource, Layout, MovingPoint, Output, Tap};
use crate::state::LinkState;
use crate::state::{Cell, State};

/// Reads position ports. `d` becomes the change of position, so that dampers act on it. The first tick only sets the
/// position, unless the motion of the port is part of the start.
pub fn enx<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for p in &layout.ports.enx[..op.n] {
        let x = R::inner(R::Outer::of(s.valid_input(p.input)) - p.rest);
        let m = p.mat as usize;
        if s.tick > 0 {
            s.d[m] = x - s.x[m];
        } else if !p.implicit {
            s.d[m] = R::ZERO;
        }
        s.x[m] = x;
        s.f[m] = R::ZERO;
    }
}

/// Delays ports that run a tick late. The position just read becomes the next one, so that links know the coming
/// motion. At the first tick the position before follows from the motion of the port.
pub fn delay_ports<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let first = s.tick == 0;
    for (m, way) in layout.ports.ahead[..op.n].iter().zip(&mut s.ports.under_way) {
        let m = *m as usize;
        let to = s.x[m];
        let [before, at] = if first { [to - s.d[m] - s.d[m], to - s.d[m]] } else { *way };
        if !first {
            s.d[m] = at - before;
        }
        s.x[m] = at;
        s.ports.turns[m] = to - at - s.d[m];
        *way = [at, to];
    }
}

/// Adds force ports. A force that is not finite counts as zero and, with `COUNTED`, is counted once per port.
pub fn enf<R: Real, const COUNTED: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let mut last = u32::MAX;
    for p in &layout.ports.enf[op.first..][..op.n] {
        let v = s.input[p.input as usize];
        let force = if v.is_finite() { v } else { 0.0 };
        s.ports.refused += u64::from(COUNTED && !v.is_finite() && p.input != last);
        last = p.input;
        s.f[p.mat as usize] += R::of(force);
    }
}

/// Adds constant forces: weight.
pub fn weight<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for (k, m) in layout.weighed[..op.n].iter().enumerate() {
        s.f[*m as usize] += s.coef[op.coef + k];
    }
}

/// Finds the cell under each moving point.
pub fn aim<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for (k, p) in layout.places.moving_points[..op.n].iter().enumerate() {
        s.links.cells[k] = cell(layout, s, p);
    }
}

fn coordinate<R: Real>(layout: &Layout<R>, s: &State<R>, place: CoordinateSource) -> R::Outer {
    let v = match place {
        CoordinateSource::Coef(c) => s.coef[c as usize].outer(),
        CoordinateSource::Mat(m) => s.x[m as usize].outer() + layout.places.rest[m as usize].outer(),
    };
    // NaN becomes 0
    if v.wide() >= 0.0 { v.min(R::Outer::of(1.0)) } else { R::Outer::ZERO }
}

/// Returns node and weight along one direction of `n` nodes.
pub fn step<O: Real>(u: O, n: u32) -> (u32, O) {
    let at = u * O::of(f64::from(n - 1));
    let i = (at.wide() as u32).min(n.saturating_sub(2));
    (i, at - O::of(f64::from(i)))
}

/// Returns the cell of one moving point at its present coordinates.
pub fn cell<R: Real>(layout: &Layout<R>, s: &State<R>, p: &MovingPoint) -> Cell<R> {
    let one = R::Outer::of(1.0);
    let (i, a) = step(coordinate(layout, s, p.at[0]), p.size[0]);
    let node = |i: u32, j: u32| layout.places.nodes[(p.first + i * p.size[1] + j) as usize];
    if p.size[1] == 1 {
        return Cell {
            n: 2,
            node: [node(i, 0), node(i + 1, 0), 0, 0],
            weight: [one - a, a, R::Outer::ZERO, R::Outer::ZERO].map(R::inner),
        };
    }
    let (j, b) = step(coordinate(layout, s, p.at[1]), p.size[1]);
    Cell {
        n: 4,
        node: [node(i, j), node(i, j + 1), node(i + 1, j), node(i + 1, j + 1)],
        weight: [(one - a) * (one - b), (one - a) * b, a * (one - b), a * b].map(R::inner),
    }
}

/// Computes the positions of moving points from their cells.
pub fn project<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for (k, p) in layout.places.moving_points[..op.n].iter().enumerate() {
        let c = s.links.cells[k];
        let (mut x, mut d) = (R::ZERO, R::ZERO);
        for q in 0..c.n {
            x += c.weight[q] * s.x[c.node[q] as usize];
            d += c.weight[q] * s.d[c.node[q] as usize];
        }
        let m = p.mat as usize;
        s.x[m] = x;
        s.d[m] = d;
        s.f[m] = R::ZERO;
    }
}

/// Distributes the force on moving points to their cells, with the weights of the position, so that no energy is made.
pub fn distribute_forces<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for (k, p) in layout.places.moving_points[..op.n].iter().enumerate() {
        let c = s.links.cells[k];
        let f = s.f[p.mat as usize];
        for q in 0..c.n {
            s.f[c.node[q] as usize] += c.weight[q] * f;
        }
    }
}

/// Computes the positions of modal masses.
pub fn sum<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for p in &layout.places.modal[..op.n] {
        let n = p.n as usize;
        let share = &layout.places.shares[p.share as usize..][..n];
        let dot = |q: &[R]| {
            // four partial sums, which do not wait for each other
            let mut part = [R::ZERO; 4];
            let (q, w) = (q[p.first as usize..][..n].chunks_exact(4), share.chunks_exact(4));
            let rest: R = q.remainder().iter().zip(w.remainder()).map(|(q, w)| *q * *w).sum();
            for (q, w) in q.zip(w) {
                for k in 0..4 {
                    part[k] += q[k] * w[k];
                }
            }
            (part[0] + part[1]) + (part[2] + part[3]) + rest
        };
        let m = p.mat as usize;
        (s.x[m], s.d[m]) = (dot(&s.x), dot(&s.d));
        s.f[m] = R::ZERO;
    }
}

/// Passes forces on modal masses on to their modes, with the shares of the position, so that no energy is made.
pub fn share<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for p in &layout.places.modal[..op.n] {
        let (f, n) = (s.f[p.mat as usize], p.n as usize);
        let share = &layout.places.shares[p.share as usize..][..n];
        for (q, w) in s.f[p.first as usize..][..n].iter_mut().zip(share) {
            *q += *w * f;
        }
    }
}

/// Computes the outputs of this tick, channel by channel as the compiler sorts them. A sum in a register is faster than
/// a sum in memory, where each addition waits for the last write.
pub fn outputs<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let State { x, f, links: LinkState { tap, .. }, coef, output, .. } = s;
    let signals = Signals { x, f, tap };
    let (outputs, gains) = (&layout.out.outputs[..op.n], &coef[op.coef..][..op.n]);
    output.fill(R::Outer::ZERO);
    let (mut channel, mut sum) = (outputs.first().map_or(0, |o| o.channel), R::Outer::ZERO);
    for (o, gain) in outputs.iter().zip(gains) {
        if o.channel != channel {
            output[channel as usize] = sum;
            (channel, sum) = (o.channel, R::Outer::ZERO);
        }
        sum += (*gain * signals.read(o)).outer();
    }
    if !outputs.is_empty() {
        output[channel as usize] = sum;
    }
}

/// Adds the outputs of motion, from `op.first` on.
pub fn motions<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for (o, gain) in layout.out.outputs[op.first..][..op.n].iter().zip(&s.coef[op.coef..]) {
        if let Tap::Position(m) = o.tap {
            s.output[o.channel as usize] += (*gain * s.d[m as usize]).outer();
        }
    }
}

/// From this number of outputs per channel on, they are summed in lanes. One running sum would wait for each addition.
pub const MANY: usize = 16;

/// Computes the outputs of this tick if a channel has at least [`MANY`]. Output i of a channel is added in lane i mod
/// 8, then the lanes in pairs, so the sum depends only on the order of outputs. Consecutive positions are read as
/// vectors.
pub fn many_outputs<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    wide::wide::<R, ManyOutputs>(op, layout, s);
}

const LANES: usize = 8;

struct ManyOutputs;

impl<R: Real> Body<R> for ManyOutputs {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        let State { x, f, links: LinkState { tap, .. }, coef, output, .. } = s;
        let signals = Signals { x, f, tap };
        let (mut outputs, mut gains) = (&layout.out.outputs[..op.n], &coef[op.coef..][..op.n]);
        output.fill(R::Outer::ZERO);
        for row in &layout.out.output_rows {
            let (of_channel, other_outputs) = outputs.split_at(row.n as usize);
            let (own, other_gains) = gains.split_at(row.n as usize);
            (outputs, gains) = (other_outputs, other_gains);
            let pairs = || of_channel.iter().zip(own);
            output[row.channel as usize] = match row.first {
                Some(first) => dot(own, &signals.x[first as usize..][..own.len()]),
                None if own.len() < MANY => {
                    pairs().fold(R::Outer::ZERO, |sum, (o, gain)| sum + (*gain * signals.read(o)).outer())
                }
                None => {
                    let mut lanes = [R::Outer::ZERO; LANES];
                    for (i, (o, gain)) in pairs().enumerate() {
                        lanes[i % LANES] += (*gain * signals.read(o)).outer();
                    }
                    in_pairs(lanes)
                }
            };
        }
    }
}

#[inline(always)]
fn dot<R: Real>(gains: &[R], x: &[R]) -> R::Outer {
    let mut lanes = [R::Outer::ZERO; LANES];
    let ((gains, last_gains), (x, last)) = (gains.as_chunks::<LANES>(), x.as_chunks::<LANES>());
    for (gain, x) in gains.iter().zip(x) {
        for k in 0..LANES {
            lanes[k] += (gain[k] * x[k]).outer();
        }
    }
    for (k, (gain, x)) in last_gains.iter().zip(last).enumerate() {
        lanes[k] += (*gain * *x).outer();
    }
    in_pairs(lanes)
}

#[inline(always)]
fn in_pairs<O: Real>([a, b, c, d, e, f, g, h]: [O; LANES]) -> O {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Computes the outputs of this tick if each channel has one output of a position, in the order of channels.
pub fn positions<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let (x, gains) = (&s.x[..], &s.coef[op.coef..]);
    for ((v, o), gain) in s.output.iter_mut().zip(&layout.out.outputs).zip(gains) {
        if let Tap::Position(m) = o.tap {
            // adding 0 gives the bits of a sum, which is never -0
            *v = R::Outer::ZERO + (*gain * x[m as usize]).outer();
        }
    }
}

/// Signals that outputs can read at this tick: positions, forces on MATs, forces of links.
pub(super) struct Signals<'a, R: Real> {
    x: &'a [R],
    f: &'a [R],
    tap: &'a [R],
}

impl<'a, R: Real> Signals<'a, R> {
    #[inline(always)]
    pub(super) fn of(s: &'a State<R>) -> Signals<'a, R> {
        Signals { x: &s.x, f: &s.f, tap: &s.links.tap }
    }

    #[inline(always)]
    pub(super) fn read(&self, o: &Output) -> R {
        match o.tap {
            Tap::Position(m) => self.x[m as usize],
            Tap::ForceOn(m) => self.f[m as usize],
            Tap::ForceOf(t) => self.tap[t as usize],
        }
    }
}

/// Moves MATs from `op.mat` on that have only inertia: d ← d + C·f, x ← x + d.
pub fn integrate_free<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    wide::wide::<R, IntegrateFree>(op, layout, s);
}

/// Number of masses moved side by side. Loops have this length because many stretches are too short for the vectors
/// that a compiler makes of a whole loop, which would leave most of them over.
const SIDE_BY_SIDE: usize = 4;

struct IntegrateFree;

impl<R: Real> Body<R> for IntegrateFree {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        let (n, at) = (op.n, op.mat);
        let (x, d, f) = (&mut s.x[at..][..n], &mut s.d[at..][..n], &mut s.f[at..][..n]);
        free(x, d, f, &s.coef[2 * layout.counts.n_mat + at..][..n]);
    }
}

/// Moves masses; all slices have the same length.
#[inline(always)]
fn free<R: Real>(x: &mut [R], d: &mut [R], f: &mut [R], c: &[R]) {
    let ((xs, x), (ds, d)) = (x.as_chunks_mut::<SIDE_BY_SIDE>(), d.as_chunks_mut::<SIDE_BY_SIDE>());
    let ((fs, f), (cs, c)) = (f.as_chunks_mut::<SIDE_BY_SIDE>(), c.as_chunks::<SIDE_BY_SIDE>());
    for (((x, d), f), c) in xs.iter_mut().zip(ds).zip(fs).zip(cs) {
        for k in 0..SIDE_BY_SIDE {
            d[k] += c[k] * f[k];
            x[k] += d[k];
            f[k] = R::ZERO;
        }
    }
    for (((x, d), f), c) in x.iter_mut().zip(d).zip(f).zip(c) {
        *d += *c * *f;
        *x += *d;
        *f = R::ZERO;
    }
}

/// Moves MATs from `op.mat` on that have their own spring and damper: d ← P·d + Q·x + C·f, x ← x + d.
pub fn integrate_full<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    wide::wide::<R, IntegrateFull>(op, layout, s);
}

struct IntegrateFull;

impl<R: Real> Body<R> for IntegrateFull {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        let (n, at) = (op.n, op.mat);
        let [p, q, c] = [0, 1, 2].map(|k| &s.coef[k * layout.counts.n_mat + at..][..n]);
        full(&mut s.x[at..][..n], &mut s.d[at..][..n], &mut s.f[at..][..n], [p, q, c]);
    }
}

#[inline(always)]
fn full<R: Real>(x: &mut [R], d: &mut [R], f: &mut [R], pqc: [&[R]; 3]) {
    if matches!(R::PRECISION, Precision::Dual) {
        // a dual number is a vector by itself, and the loop over chunks would call a function for each number
        for ((((x, d), f), p), (q, c)) in x.iter_mut().zip(d).zip(f).zip(pqc[0]).zip(pqc[1].iter().zip(pqc[2])) {
            *d = *p * *d + *q * *x + *c * *f;
            *x += *d;
            *f = R::ZERO;
        }
        return;
    }
    let [(ps, p), (qs, q), (cs, c)] = pqc.map(|all| all.as_chunks::<SIDE_BY_SIDE>());
    let ((xs, x), (ds, d)) = (x.as_chunks_mut::<SIDE_BY_SIDE>(), d.as_chunks_mut::<SIDE_BY_SIDE>());
    let (fs, f) = f.as_chunks_mut::<SIDE_BY_SIDE>();
    for ((((x, d), f), p), (q, c)) in xs.iter_mut().zip(ds).zip(fs).zip(ps).zip(qs.iter().zip(cs)) {
        // array by array: the compiler does not vectorise one loop over all three
        *d = core::array::from_fn(|k| p[k] * d[k] + q[k] * x[k] + c[k] * f[k]);
        *x = core::array::from_fn(|k| x[k] + d[k]);
        *f = [R::ZERO; SIDE_BY_SIDE];
    }
    for ((((x, d), f), p), (q, c)) in x.iter_mut().zip(d).zip(f).zip(p).zip(q.iter().zip(c)) {
        *d = *p * *d + *q * *x + *c * *f;
        *x += *d;
        *f = R::ZERO;
    }
}

/// Clears tiny numbers every 1024 ticks, long before they become denormal and slow. This is part of the tick and not a
/// processor flag, so that renderer, host, Python and replay agree in every bit.
pub fn flush<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    if s.tick & 1023 == 1023 {
        let waves = &mut s.links.mem[layout.waves.first..][..layout.waves.len];
        for v in s.x[..op.n].iter_mut().chain(&mut s.d[..op.n]).chain(waves) {
            if v.abs() < R::TINY {
                *v = R::ZERO;
            }
        }
    }
}

/// Moves ramped coefficients by one tick.
pub fn ramp<R: Real>(_op: &Op<R>, _layout: &Layout<R>, s: &mut State<R>) {
    let (r, coef) = (&mut s.ramps, &mut s.coef);
    let mut k = 0;
    while k < r.moving {
        let i = r.active[k] as usize;
        let c = &mut coef[r.index[i] as usize];
        r.left[i] -= 1;
        if r.left[i] == 0 {
            *c = r.target[i];
            r.moving -= 1;
            r.active[k] = r.active[r.moving];
        } else {
            *c += r.step[i];
            k += 1;
        }
    }
}
