//! Measures the loop latency: from a position that a device sent to the first one it sent after using the force that
//! answers it.
//!
//! The device stamps both ends, so no clocks are compared; `ack` on either side connects them. A missing or foreign
//! time stamp could give any latency, so a loop longer than the time that passed here meanwhile is not counted.

use crate::frame::{DeviceFrame, ForceFrame};

/// Frames stored: a third of a second at 3 kHz.
const KEPT: usize = 1024;
/// Longest time that a frame waits in the rings \[ns\].
const WAITS: u64 = 5_000_000_000;

pub(super) struct LoopLatency {
    /// Position frames: number, time sent \[ns\], time read here \[ns\].
    sent: Vec<(u64, u64, u64)>,
    /// Force frames: number, and number of the position frame that it answers.
    answered: Vec<(u64, u64)>,
    session: u64,
    /// Number of the last force that was counted.
    last: u64,
}

impl LoopLatency {
    pub(super) fn new() -> LoopLatency {
        LoopLatency { sent: vec![(0, 0, 0); KEPT], answered: vec![(0, 0); KEPT], session: 0, last: 0 }
    }

    pub(super) fn force(&mut self, f: &ForceFrame) {
        if f.ack > 0 && f.ack_session == self.session {
            self.answered[f.seq as usize % KEPT] = (f.seq, f.ack);
        }
    }

    /// Returns the loop latency \[ns\] if this frame is the first that uses a force. `now` \[ns\] is the time here.
    pub(super) fn device(&mut self, f: &DeviceFrame, now: u64) -> Option<u64> {
        if f.session != self.session {
            *self = LoopLatency { session: f.session, ..LoopLatency::new() };
        }
        self.sent[f.seq as usize % KEPT] = (f.seq, f.t_host_ns, now);
        if f.ack <= self.last {
            return None;
        }
        self.last = f.ack;
        let (seq, position) = self.answered[f.ack as usize % KEPT];
        let (sent, at, looked) = self.sent[position as usize % KEPT];
        let most = now.saturating_sub(looked).saturating_add(WAITS);
        let length = f.t_host_ns.checked_sub(at).filter(|ns| *ns > 0 && *ns <= most);
        length.filter(|_| seq == f.ack && sent == position && at > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_is_from_the_position_to_the_first_one_after_its_force() {
        let (mut l, mut d, mut f) = (LoopLatency::new(), DeviceFrame::new("a", 1), ForceFrame::new("a", 1));
        (d.session, f.ack_session) = (9, 9);
        for n in 1..=5000_u64 {
            // the force that answers frame n is used two frames later
            (d.seq, d.ack, d.t_host_ns) = (n, n.saturating_sub(2), 1000 * n);
            let reported = l.device(&d, 5 * 1000 * n);
            assert_eq!(reported, (n > 2).then_some(2000), "{n}");
            (f.seq, f.ack) = (n, n);
            l.force(&f);
        }
        d.session = 10;
        (d.seq, d.ack) = (1, 4000);
        assert_eq!(l.device(&d, 1), None, "another session knows nothing of the past");
    }

    #[test]
    fn a_stamp_of_no_clock_makes_no_latency() {
        for (name, wrong) in [("the largest", u64::MAX), ("none", 0), ("another clock", 1_700_000_000_000_000_000)] {
            let (mut l, mut d, mut f) = (LoopLatency::new(), DeviceFrame::new("a", 1), ForceFrame::new("a", 1));
            (d.session, f.ack_session) = (9, 9);
            let mut counted = 0;
            for n in 1..=900_u64 {
                let now = 3_000_000_000_000 + 333_333 * n;
                let t = if n.is_multiple_of(5) { wrong } else { now };
                (d.seq, d.ack, d.t_host_ns) = (n, n.saturating_sub(2), t);
                if let Some(ns) = l.device(&d, now) {
                    assert_eq!(ns, 666_666, "{name}, frame {n}");
                    counted += 1;
                }
                (f.seq, f.ack) = (n, n);
                l.force(&f);
            }
            // a loop has two ends, so two in five are lost
            assert_eq!(counted, 898 - 180 - 179, "{name}");
        }
    }
}
