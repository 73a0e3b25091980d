//! The border between two rates: a device whose frames are R ticks apart.
//!
//! Each border is a pair of position in and force out that conserves power for any link behind it (docs/numerics.md
//! §5.1): the force of a frame times the motion of its port, summed over frames, equals the sum of f·(X_{j+1} −
//! X_{j−1})/2 over ticks. `linear.rs` is the default, since it adds no 3 kHz staircase to the sound. `hold.rs` is the
//! other such pair, for comparison. `synchronous.rs` replaces both if R = 1.
//!
//! The border is chosen once, at load. Delay, ledger and missing force feedback are separate passes or kernels.
//!
//! Frame n covers the ticks (n−1)R+1 … nR. The caller writes X_n to [`State::input`] before tick (n−1)R+1. After the
//! forces of tick nR, [`Border::force`](crate::state::Border::force) is the force that the device holds in the next
//! frame.

use crate::numeric::Real;
use crate::op::layout::{BorderMethod, Enx, Layout};
use crate::op::substep::phase;
use crate::op::{Kernel, Op};
use crate::state::{Border, State};

mod delays;
pub mod group;
mod hold;
mod ledger;
mod linear;
mod synchronous;

pub use delays::{Delays, delays};

/// Returns true if the next sample, number `sample`, begins a gesture frame, so that new device positions are due.
pub fn frame_due<R: Real>(layout: &Layout<R>, sample: u64) -> bool {
    phase(layout.rates.ratio, sample) <= 1
}

/// Returns the pass that moves device ports.
pub fn position<R: Real>(way: BorderMethod, late: bool) -> Kernel<R> {
    match (way, late) {
        (BorderMethod::Synchronous, false) => synchronous::position::<R, false>,
        (BorderMethod::Synchronous, true) => synchronous::position::<R, true>,
        (BorderMethod::Linear, false) => linear::position::<R, false>,
        (BorderMethod::Linear, true) => linear::position::<R, true>,
        (BorderMethod::Hold, false) => hold::position::<R, false>,
        (BorderMethod::Hold, true) => hold::position::<R, true>,
    }
}

/// Returns the pass that reads the force on device ports after the forces of a tick.
pub fn collect<R: Real>(way: BorderMethod) -> Kernel<R> {
    match way {
        BorderMethod::Synchronous => synchronous::collect,
        BorderMethod::Linear => linear::collect,
        BorderMethod::Hold => hold::collect,
    }
}

/// Returns the pass of the ledger of the border.
pub fn ledger<R: Real>(way: BorderMethod) -> Kernel<R> {
    if way == BorderMethod::Synchronous { ledger::ledger::<R, true> } else { ledger::ledger::<R, false> }
}

/// Keeps the force on devices for the ledger without sending it. It runs before and after `collect`. The sum is stored
/// in the ledger between ticks, so the state is the same as without a ledger.
pub fn mute<R: Real>(op: &Op<R>, _layout: &Layout<R>, s: &mut State<R>) {
    let Some(l) = &mut s.ledger else { return };
    for (b, e) in s.ports.border[..op.n].iter_mut().zip(&mut l.hands) {
        core::mem::swap(&mut b.sum, &mut e.sum);
        b.force = 0.0;
    }
}

/// Returns the device position that reaches the scene with this frame \[m\], absolute: the one just read, or the one of
/// `latency` frames ago. Positions before the first count as equal to it.
fn arrive<R: Real, const LATE: bool>(layout: &Layout<R>, s: &mut State<R>, k: usize, p: &Enx<R>) -> f64 {
    let x = s.valid_input(p.input);
    if !LATE {
        return x;
    }
    let n = layout.ports.crossing.latency as usize;
    let line = k * n..(k + 1) * n;
    if s.tick == 0 {
        s.ports.late[line].fill(x);
        return x;
    }
    let frame = (s.tick - 1) / u64::from(layout.rates.frame) + 1;
    let at = line.start + (frame % n as u64) as usize;
    core::mem::replace(&mut s.ports.late[at], x)
}

fn begin<R: Real, const LATE: bool>(layout: &Layout<R>, s: &mut State<R>, ports: &[Enx<R>]) {
    for (k, p) in ports.iter().enumerate() {
        let x = arrive::<R, LATE>(layout, s, k, p) - p.rest.wide();
        let b = &mut s.ports.border[k];
        b.from = if s.tick == 0 { x } else { b.to };
        b.to = x;
    }
}

/// Sets the positions of ports: `at` returns the position within the frame, relative to rest.
#[inline(always)]
fn place<R: Real>(s: &mut State<R>, ports: &[Enx<R>], at: impl Fn(&Border) -> f64) {
    let first = s.tick == 0;
    let x = &mut s.x[..];
    // of equal length, so that one bounds check serves for all
    let (d, f) = (&mut s.d[..x.len()], &mut s.f[..x.len()]);
    for (p, b) in ports.iter().zip(&s.ports.border) {
        let (m, to) = (p.mat as usize, R::of(at(b)));
        d[m] = if first { R::ZERO } else { to - x[m] };
        x[m] = to;
        f[m] = R::ZERO;
    }
}
