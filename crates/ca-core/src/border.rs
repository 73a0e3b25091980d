//! The border between two rates: a device that speaks R times slower than the sound.
//!
//! Decides on linear position in, trapezoid mean force out. It is the only pair in its class that conserves power for
//! any link behind it (numerics 5.1: sum of F̄ΔX over frames equals the sum of f·(X_{j+1} − X_{j−1})/2 over ticks), and
//! it does not print a 3 kHz staircase on the sound, as holding the position would.
//!
//! Frame n covers the ticks (n−1)R+1 … nR. The caller writes X_n to [`State::input`] before tick (n−1)R+1; after the
//! forces of tick nR, before the masses move, [`Border::force`] is the mean force of the frame. With R = 1 it is the
//! force of the tick itself.

use crate::layout::Layout;
use crate::op::Op;
pub use crate::state::Border;
use crate::state::State;

/// Tick within the frame, 1 … R; 0 at the very first tick, which only places the device.
fn phase(layout: &Layout, tick: u64) -> u32 {
    if tick == 0 { 0 } else { ((tick - 1) % u64::from(layout.ratio)) as u32 + 1 }
}

/// True where the next tick begins a gesture frame, so that new device positions are due.
pub fn frame_due(layout: &Layout, tick: u64) -> bool {
    phase(layout, tick) <= 1
}

/// Position of device ports at this tick.
pub fn position(op: &Op, layout: &Layout, s: &mut State) {
    let j = phase(layout, s.tick);
    for (k, p) in layout.tgr[..op.n].iter().enumerate() {
        let m = p.mat as usize;
        if j <= 1 {
            let x = s.heard(p.input) - p.rest;
            let b = &mut s.border[k];
            b.from = if j == 0 { x } else { b.to };
            b.to = x;
        }
        let b = s.border[k];
        let x = if j == layout.ratio || j == 0 {
            b.to
        } else {
            b.from + f64::from(j) / f64::from(layout.ratio) * (b.to - b.from)
        };
        s.d[m] = if j == 0 { 0.0 } else { x - s.x[m] };
        s.x[m] = x;
        s.f[m] = 0.0;
    }
}

/// Collects the force on device ports after the forces of this tick.
pub fn collect(op: &Op, layout: &Layout, s: &mut State) {
    let j = phase(layout, s.tick);
    for (k, p) in layout.tgr[..op.n].iter().enumerate() {
        let f = s.f[p.mat as usize];
        let b = &mut s.border[k];
        if j == layout.ratio {
            b.force = if layout.ratio == 1 { f } else { (b.sum + 0.5 * f) / f64::from(layout.ratio) };
            b.sum = 0.5 * f;
        } else if j == 0 {
            b.sum = 0.5 * f;
        } else {
            b.sum += f;
        }
    }
}
