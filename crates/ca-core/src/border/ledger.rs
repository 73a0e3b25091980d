//! The ledger of the border: what each hand gave and what the scene received from it, frame by frame
//! (docs/numerics.md §5.3).
//!
//! Decides to keep it exact rather than to estimate: a device holds its force u from one frame to the next, so what the
//! hand gives during frame n is u_{n−1} times the motion of the hand, and what the scene receives is the mean force of
//! frame n times the motion of its port. Without delay the two motions are the same and the difference is the price of
//! sending forces late; with `latency` the port moves as the hand did before, and without `feedback` the hand meets no
//! force and gives nothing. Signs are those of [`Border::force`](crate::state::Border::force), the force *on* the hand.

use super::phase;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// At the end of a frame, once its force is known. With `SYNC`, where the hand is sent the force of the tick, the mean
/// with the one before is what the scene receives by.
pub(super) fn ledger<R: Real, const SYNC: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let j = phase(layout.rates.frame, s.tick);
    if j != 0 && j != layout.rates.frame {
        return;
    }
    let Some(l) = &mut s.ledger else { return };
    for (k, p) in layout.ports.tgr[..op.n].iter().enumerate() {
        // what was taken at the start of the frame, whatever the caller has written since
        let hand = s.ports.last_input[p.input as usize];
        let (b, e, f) = (&s.ports.border[k], &mut l.hands[k], s.f[p.mat as usize].wide());
        if j > 0 {
            if layout.ports.ahead.contains(&p.mat) {
                // by the ticks of the port, up to the one before
                e.received = l.work[layout.ports.enx.len() + k].wide();
            } else {
                let mean = if SYNC { 0.5 * (e.last + f) } else { b.force };
                e.received -= mean * (b.to - b.from);
            }
            e.given -= e.held * (hand - e.hand);
            e.held = if layout.ports.crossing.feedback { b.force } else { 0.0 };
        }
        (e.hand, e.last) = (hand, f);
    }
}
