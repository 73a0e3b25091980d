//! Energy ledger of the border: energy given at each device and received by the scene (docs/numerics.md §5.3).
//!
//! The ledger is exact. A device holds its force u from one frame to the next, so the energy given at it in frame n is
//! u_{n−1} times its motion. The scene receives the mean force of frame n times the motion of its port.
//!
//! Without added delay the two motions are equal, and the difference of the energies is the cost of sending forces
//! late. With `latency` the port repeats an earlier motion of the device. Without `feedback` the device exerts no force
//! and gives no energy. Signs follow [`Border::force`](crate::state::Border::force), the force *on* the hand.

use super::phase;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Enters a frame at its end. With `SYNC` the device gets the force of the tick, and the scene the mean with the last
/// one.
pub(super) fn ledger<R: Real, const SYNC: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let j = phase(layout.rates.frame, s.tick);
    if j != 0 && j != layout.rates.frame {
        return;
    }
    let Some(l) = &mut s.ledger else { return };
    for (k, p) in layout.ports.tgr[..op.n].iter().enumerate() {
        // the position at the start of the frame, even if the caller has written another since
        let hand = s.ports.last_input[p.input as usize];
        let (b, e, f) = (&s.ports.border[k], &mut l.hands[k], s.f[p.mat as usize].wide());
        if j > 0 {
            if layout.ports.ahead.contains(&p.mat) {
                // counted by the ticks of the port, up to the one before
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
