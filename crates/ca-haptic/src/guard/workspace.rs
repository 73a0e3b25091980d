//! H11: softens the ends of the travel.
//!
//! The model sees the true position everywhere, and a spring of the guard pushes the hand back in the last part of the
//! travel. Clamping the position instead would stop the instrument from following the hand, with forces for a wrong
//! position. The spring has half of the stiffness that the device renders, or reaches the largest force at the stop,
//! whichever is softer.
//!
//! A fader parked at its end, or an arm hanging at its lowest, is inside an edge when the device is armed. It need not
//! be lifted for forces to begin, and it is not pushed out: an edge acts only after the hand has been in the free middle
//! of the travel.

use super::{GuardFrame, Stage};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Spring at each end of each axis.
pub struct Workspace {
    low: f64,
    high: f64,
    k: f64,
    /// Force of the spring in the frame before \[N\].
    last: [f64; DOF],
    /// Axes that have been outside of their edges since forces were off.
    left: [bool; DOF],
}

impl Workspace {
    /// Builds the springs from a profile; `None` if it asks for hard ends.
    pub fn new(profile: &Profile) -> Option<Workspace> {
        let [low, high] = profile.range;
        let width = profile.guard.edge * (high - low);
        let k = profile.edge_stiffness();
        (width > 0.0 && k > 0.0).then_some(Workspace {
            low: low + width,
            high: high - width,
            k,
            last: [0.0; DOF],
            left: [false; DOF],
        })
    }
}

impl Stage for Workspace {
    fn name(&self) -> &'static str {
        "workspace"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        for i in 0..hand.n {
            let x = hand.x[i];
            let mut push = self.k * ((self.low - x).max(0.0) - (x - self.high).max(0.0));
            if push == 0.0 {
                self.left[i] = true;
            } else {
                self.left[i] &= !matches!(hand.mode, Mode::Off | Mode::Fault);
                hand.flags |= flag::EDGE;
                if !self.left[i] {
                    push = 0.0;
                }
                hand.force[i] += push;
            }
            // exact for a motion at constant speed
            hand.mean[i] += 0.5 * (self.last[i] + push);
            self.last[i] = push;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pushes_back_from_both_ends_up_to_the_largest_force() {
        let p = Profile::shipped("tgr12").expect("shipped");
        let mut stage = Workspace::new(&p).expect("it has edges");
        // 5 % of 20 mm; 10 N at the stop is softer than half of 40 N/mm
        for (x, want) in [(0.0, 0.0), (8.9e-3, 0.0), (9.5e-3, -5.0), (0.01, -10.0), (-9.1e-3, 1.0), (-0.01, 10.0)] {
            let mut hand = GuardFrame::new(1, 1.0 / 3000.0);
            (hand.x[0], hand.mode) = (x, Mode::On);
            stage.pass(&mut hand);
            assert!((hand.force[0] - want).abs() < 1e-9, "{x}: {}", hand.force[0]);
            assert_eq!(hand.flags & flag::EDGE != 0, want != 0.0);
        }
        // armed while inside: not pushed out, but pushed back once it has been outside
        let mut hand = GuardFrame::new(1, 1.0 / 3000.0);
        for (x, mode, want) in [
            (0.01, Mode::Off, 0.0),
            (0.01, Mode::On, 0.0),
            (0.0095, Mode::On, 0.0),
            (0.008, Mode::On, 0.0),
            (0.0095, Mode::On, -5.0),
        ] {
            (hand.x[0], hand.mode, hand.force[0]) = (x, mode, 0.0);
            stage.pass(&mut hand);
            assert!((hand.force[0] - want).abs() < 1e-9, "{x}: {}", hand.force[0]);
        }
        let mut hard = p;
        hard.guard.edge = 0.0;
        assert!(Workspace::new(&hard).is_none());
    }

    #[test]
    fn takes_what_it_stores() {
        let p = Profile::shipped("tgr12").expect("shipped");
        let mut stage = Workspace::new(&p).expect("it has edges");
        let mut hand = GuardFrame::new(1, 1.0 / 3000.0);
        hand.mode = Mode::On;
        stage.pass(&mut hand);
        hand.x[0] = 9e-3;
        let mut taken = 0.0;
        for _ in 0..100 {
            (hand.moved[0], hand.mean[0]) = (1e-5, 0.0);
            hand.x[0] += 1e-5;
            stage.pass(&mut hand);
            taken -= hand.mean[0] * hand.moved[0];
        }
        let stored = 0.5 * 1e4 * 1e-3 * 1e-3;
        assert!((taken - stored).abs() < 1e-12 * stored.max(1.0), "{taken} J of {stored}");
    }
}
