//! Groups at the gesture rate: their step per frame, and their motion towards the sound side (docs/numerics.md §5.4).
//!
//! The scheme of a group has positions X_n, one frame apart. During frame n the sound side sees the group move on a
//! straight line from ½(X_{n−1} + X_n) to ½(X_n + X_{n+1}). The scheme counts work by this same motion, so the mean
//! force of the frame transfers energy exactly, for any law. A border through the X_n would be half a frame late, which
//! is a negative damper. One matrix, made by the compiler, gives the response of the sound side, which is linear in the
//! state at the start of the frame and in the motion of the border.
//!
//! With `border = "compensated"`, links across may do what a matrix does not describe, such as a contact or a live
//! parameter. Their deviation is measured when a frame ends, and extrapolated to the next on the parabola through the
//! last three. This compensates for the delay with the stiffness of the whole sound side, without the slope of any law;
//! on a straight line a spring across would be a negative damper of higher order. Force added to one frame is
//! subtracted from the next two, so momentum is conserved. Energy is not, and has an account in the ledger.

use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::{Copied, Layout, SlowGroup};
use crate::op::substep::phase;
use crate::state::{Between, SlowState, State, Unknown};

/// Steps the group when a frame begins, and moves the copies of its MATs in every tick.
pub fn advance<R: Real, const COMPENSATED: bool>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(group) = layout.rates.slow.as_deref() else { return };
    let Some(mut slow) = s.slow.take() else { return };
    let j = phase(layout.rates.frame, s.tick);
    if j == 0 {
        placed(group, &mut slow);
        // its ledger enters the energy at load
        run(&group.reads, group, &mut slow.state);
    } else if j == 1 {
        if COMPENSATED {
            let made = expect(layout, &mut slow);
            s.ledger.iter_mut().for_each(|l| l.groups.border += R::Outer::of(made));
        }
        step::<R, COMPENSATED>(group, layout, s, &mut slow);
    }
    if j <= 1 {
        show(group, &slow, s);
        if let Some((l, own)) = s.ledger.as_mut().zip(slow.state.ledger.as_ref()) {
            l.groups.slow = own.balance();
        }
    }
    let part = f64::from(j) / f64::from(layout.rates.frame);
    let whole = j == 0 || j == layout.rates.frame;
    for (k, (p, b)) in group.ports.iter().zip(&slow.ports).enumerate() {
        let (m, at) = (p.at as usize, if whole { b.to } else { b.from + part * (b.to - b.from) });
        let x = R::of(at);
        // the first motion is unknown: assume that the copy arrives as it goes on
        s.d[m] =
            if j == 0 { slow.state.d[p.own as usize] * R::of(1.0 / f64::from(layout.rates.frame)) } else { x - s.x[m] };
        s.x[m] = x;
        if k < group.coupled {
            s.f[m] = R::ZERO;
        }
    }
    s.slow = Some(slow);
}

/// Stores the forces on MATs that links across join. For a compensated border it also sums them over the frame.
pub fn collect<R: Real, const COMPENSATED: bool>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let (Some(group), Some(slow)) = (layout.rates.slow.as_deref(), s.slow.as_mut()) else { return };
    for (p, b) in group.ports.iter().zip(&mut slow.ports).take(group.coupled) {
        b.force = s.f[p.at as usize].wide();
    }
    if COMPENSATED {
        let weight = match phase(layout.rates.frame, s.tick) {
            0 => 0.0,
            j if j == layout.rates.frame => 0.5,
            _ => 1.0,
        };
        slow.unknown.iter_mut().zip(&slow.ports).for_each(|(u, b)| u.sum += weight * b.force);
    }
}

/// Measures the unknown forces of the frame that ends and extrapolates them to the next. Returns the energy that the
/// border made in the frame: energy given to the group less energy taken from the sound side \[J\].
fn expect<R: Real>(layout: &Layout<R>, slow: &mut SlowState<R>) -> f64 {
    let mut made = 0.0;
    for (u, b) in slow.unknown.iter_mut().zip(&slow.ports) {
        let missed = u.sum / f64::from(layout.rates.frame) - u.given;
        made -= missed * (b.to - b.from);
        let was = u.expected + missed;
        let [one, two] = u.last;
        // the last force of a frame also counts as the first of the next
        *u = Unknown { sum: 0.5 * b.force, given: 0.0, expected: 3.0 * (was - one) + two, last: [was, one] };
    }
    made
}

/// Returns the position of a MAT of the group at the end of the frame.
fn end<R: Real>(slow: &SlowState<R>, p: Copied) -> f64 {
    let m = p.own as usize;
    slow.state.x[m].wide() - 0.5 * slow.state.d[m].wide()
}

/// Restarts the copies at the present positions, without forces across. To be called after writing positions of the
/// group.
pub fn placed<R: Real>(group: &SlowGroup<R>, slow: &mut SlowState<R>) {
    slow.state.placed();
    for (k, p) in group.ports.iter().enumerate() {
        let to = end(slow, *p);
        slow.ports[k] = Between { from: to, to, force: 0.0 };
    }
    slow.unknown.fill(Unknown::default());
}

fn show<R: Real>(group: &SlowGroup<R>, slow: &SlowState<R>, s: &mut State<R>) {
    for p in &group.shown {
        s.x[p.at as usize] = R::of(end(slow, *p));
    }
}

fn run<R: Real>(list: &[Op<R>], group: &SlowGroup<R>, s: &mut State<R>) {
    for op in list {
        (op.kernel)(op, &group.layout, s);
    }
}

fn step<R: Real, const COMPENSATED: bool>(
    group: &SlowGroup<R>,
    layout: &Layout<R>,
    s: &State<R>,
    slow: &mut SlowState<R>,
) {
    run(&group.reads, group, &mut slow.state);
    run(&group.forces, group, &mut slow.state);
    couple::<R, COMPENSATED>(group, layout, s, slow);
    run(&group.after, group, &mut slow.state);
    run(&group.moves, group, &mut slow.state);
    slow.state.tick += 1;
    for (k, p) in group.ports.iter().enumerate() {
        let to = end(slow, *p);
        let b = &mut slow.ports[k];
        (b.from, b.to) = (b.to, to);
    }
}

/// Adds the mean force of the frame on each port, as a force from outside.
fn couple<R: Real, const COMPENSATED: bool>(
    group: &SlowGroup<R>,
    layout: &Layout<R>,
    s: &State<R>,
    slow: &mut SlowState<R>,
) {
    let (response, n) = (&group.response, group.layout.counts.n_mat);
    let width = 1 + 2 * response.places.len();
    let SlowState { state, ports, unknown, free } = slow;
    let half = 0.5 / f64::from(layout.rates.frame);
    for (i, p) in group.ports.iter().enumerate().take(group.coupled) {
        let row = &response.known[i * width..][..width];
        let mut force = row[0] + half * ports[i].force;
        for (weights, at) in row[1..].chunks_exact(2).zip(&response.places) {
            let at = *at as usize;
            force += weights[0] * s.x[at].wide() + weights[1] * s.d[at].wide();
        }
        if COMPENSATED {
            force += unknown[i].expected;
        }
        let m = p.own as usize;
        let [x, d, f] = [state.x[m], state.d[m], state.f[m]].map(R::wide);
        let [p, q, c] = [0, n, 2 * n].map(|first| state.coef[first + m].wide());
        // half of the motion before, and half of the motion that the scheme makes of all these forces
        free[i] = 0.5 * (d + p * d + q * x + c * (f + force));
        state.input[i] = force;
    }
    for i in 0..group.coupled {
        let row = &response.answer[i * group.coupled..][..group.coupled];
        let answer: f64 = row.iter().zip(&free[..]).map(|(a, d)| a * d).sum();
        state.input[i] += answer;
        state.f[group.ports[i].own as usize] += R::of(state.input[i]);
    }
    if COMPENSATED {
        unknown.iter_mut().zip(&state.input).for_each(|(u, force)| u.given = *force);
    }
}
