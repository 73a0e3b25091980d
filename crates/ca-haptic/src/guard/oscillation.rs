//! H13: a force that shakes the hand is weakened, until it ends.
//!
//! Decides on the level of the force above 30 Hz, up to the Nyquist frequency of the loop (a high-pass of second order, a
//! low-pass only where the profile asks for one, then a running mean of the squares): where its r.m.s. value stays above
//! its share of the largest force for a while, counted down again where it is below, the force is weakened by a fixed gain. A loop that is unstable at that
//! gain goes on with a smaller amplitude, or still at the largest force: it is weakened again, and again, each time after
//! that while. A force that goes on as before and is not cut is one that the model makes by itself, however weak
//! it reaches the hand, and stays at the gain it has.
//!
//! The force comes back by itself once what is asked for has been quiet for twenty times as long, fading in as after
//! arming; twice as long each time it has to be weakened again. A latch would be the alternative, and would take a player's
//! instrument away for a loud passage. Every weakened frame says so.

use super::gate::frames;
use super::{GuardFrame, Stage};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// A detector per vector of force.
pub struct Oscillation {
    axes: usize,
    high: Biquad,
    low: Option<Biquad>,
    /// share of the new square in the running mean
    share: f64,
    threshold: f64,
    gain: f64,
    /// smallest gain
    least: f64,
    rise: f64,
    frames: u32,
    past: [Past; DOF],
    seen: [Seen; DOF],
}

/// Quiet for so many times `oscillation_time`, before the force comes back: the first time, and at most.
const QUIET: [u32; 2] = [20, 640];
/// What is left of the level of an oscillation that was made by the loop, once the loop is weaker.
const FELL: f64 = 0.7;
/// Times a force is weakened at most.
const TIMES: usize = 4;
/// How many times shorter than `oscillation_time` the mean of the squares is.
const MEAN: f64 = 5.0;

/// A filter of second order.
#[derive(Clone, Copy)]
struct Biquad {
    b: [f64; 3],
    a: [f64; 2],
}

#[derive(Clone, Copy, Default)]
struct Past {
    high: [f64; 2],
    low: [f64; 2],
}

#[derive(Clone, Copy)]
struct Seen {
    square: f64,
    loud: u32,
    quiet: u32,
    gain: f64,
    /// mean square when it was weakened last; 0 before
    before: f64,
    /// frames of quiet until the force comes back
    wait: u32,
}

/// tan(π f frame_dt) to a few percent up to a quarter of the rate, without a function whose last bit differs between machines.
fn warped(f: f64, frame_dt: f64) -> f64 {
    let w = std::f64::consts::PI * (f * frame_dt).min(0.4);
    w / (1.0 - w * w / 3.0)
}

impl Biquad {
    /// Butterworth, by the bilinear transform.
    fn new(f: f64, frame_dt: f64, high: bool) -> Biquad {
        let k = warped(f, frame_dt);
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
        let a = [2.0 * (k * k - 1.0) * norm, (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm];
        let b = if high { [norm, -2.0 * norm, norm] } else { [k * k * norm, 2.0 * k * k * norm, k * k * norm] };
        Biquad { b, a }
    }

    /// Transposed direct form II.
    fn pass(&self, s: &mut [f64; 2], x: f64) -> f64 {
        let y = self.b[0] * x + s[0];
        *s = [self.b[1] * x - self.a[0] * y + s[1], self.b[2] * x - self.a[1] * y];
        y
    }
}

impl Oscillation {
    /// As the profile says, at frames of `frame_dt` seconds; `None` where it is not wanted.
    pub fn new(profile: &Profile, frame_dt: f64) -> Option<Oscillation> {
        let l = &profile.guard;
        let level = l.oscillation_level * profile.force;
        (l.oscillation && level > 0.0).then(|| Oscillation {
            axes: profile.axes as usize,
            high: Biquad::new(l.oscillation_band[0], frame_dt, true),
            low: (l.oscillation_band[1] < 0.5 / frame_dt).then(|| Biquad::new(l.oscillation_band[1], frame_dt, false)),
            share: frame_dt / (frame_dt + l.oscillation_time / MEAN),
            threshold: level * level,
            gain: l.oscillation_gain,
            least: [l.oscillation_gain; TIMES].iter().product(),
            rise: frame_dt / l.ramp,
            frames: frames(l.oscillation_time, frame_dt),
            past: [Past::default(); DOF],
            seen: [Seen::new(frames(l.oscillation_time, frame_dt)); DOF],
        })
    }
}

impl Seen {
    /// Nothing heard yet, by a stage that waits `frames` before it weakens.
    fn new(frames: u32) -> Seen {
        Seen { square: 0.0, loud: 0, quiet: 0, gain: 1.0, before: 0.0, wait: QUIET[0].saturating_mul(frames) }
    }
}

impl Stage for Oscillation {
    fn name(&self) -> &'static str {
        "oscillation"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        // nothing is weakened that nobody feels: waiting for the hand to be clear judges the full force
        if matches!(hand.mode, Mode::Off | Mode::Fault) {
            (self.past, self.seen) = ([Past::default(); DOF], [Seen::new(self.frames); DOF]);
            return;
        }
        for at in (0..hand.n).step_by(self.axes) {
            let end = (at + self.axes).min(hand.n);
            let mut square = 0.0;
            for k in at..end {
                let p = &mut self.past[k];
                let y = self.high.pass(&mut p.high, hand.force[k]);
                let y = self.low.map_or(y, |low| low.pass(&mut p.low, y));
                square += y * y;
            }
            let s = &mut self.seen[at];
            s.square += self.share * (square - s.square);
            let first = s.gain == 1.0;
            // at a smaller gain a loop shakes less
            let scale = if first { 1.0 } else { s.gain * s.gain };
            let goes_on = first || s.square < FELL * FELL * s.before || hand.flags & flag::SATURATED != 0;
            let loud = s.square > self.threshold * scale && s.gain > self.least && goes_on;
            // a hand that is thrown off a wall again and again lets go of it in between
            s.loud = if loud { s.loud.saturating_add(1) } else { s.loud.saturating_sub(1) };
            s.quiet = if s.square > self.threshold || s.loud > 0 { 0 } else { s.quiet.saturating_add(1) };
            if s.loud >= self.frames {
                if first && s.before > 0.0 {
                    s.wait = s.wait.saturating_mul(2).min(QUIET[1].saturating_mul(self.frames));
                }
                s.gain = (s.gain * self.gain).max(self.least);
                (s.before, s.loud) = (s.square, 0);
            } else if s.quiet >= s.wait {
                s.gain = (s.gain + self.rise).min(1.0);
            }
            if s.gain < 1.0 {
                hand.force[at..end].iter_mut().for_each(|f| *f *= s.gain);
                hand.flags |= flag::OSCILLATION;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_DT: f64 = 1.0 / 3000.0;

    /// Frame in which a sine of `f` hertz and `size` times the largest force is first weakened, of `n`.
    fn weakened(f: f64, size: f64, n: usize) -> Option<usize> {
        let p = Profile::shipped("tgr12").expect("shipped");
        let mut stage = Oscillation::new(&p, FRAME_DT).expect("it is on");
        let mut hand = GuardFrame::new(1, FRAME_DT);
        hand.mode = Mode::On;
        (0..n).find(|i| {
            hand.force[0] = size * p.force * (std::f64::consts::TAU * f * *i as f64 * FRAME_DT).sin();
            (hand.flags, hand.inject) = (0, 0.0);
            stage.pass(&mut hand);
            hand.flags & flag::OSCILLATION != 0
        })
    }

    #[test]
    fn hears_the_band_and_nothing_else() {
        // r.m.s. 0.42 of the largest force is above 0.3, 0.28 is below
        for f in [60.0, 100.0, 200.0, 400.0, 1000.0, 1450.0] {
            let at = weakened(f, 0.6, 3000).expect("an oscillation");
            assert!((150..220).contains(&at), "{f} Hz after {at} frames");
            assert_eq!(weakened(f, 0.4, 3000), None, "{f} Hz");
        }
        // an octave and a half below, and a hand that presses
        for f in [0.0, 2.0, 10.0] {
            assert_eq!(weakened(f, 1.0, 6000), None, "{f} Hz");
        }
    }

    #[test]
    fn hears_bounces_whose_level_falls_between_them() {
        let p = Profile::shipped("tgr12").expect("shipped");
        for f in [32.0, 45.0, 64.0] {
            let mut stage = Oscillation::new(&p, FRAME_DT).expect("it is on");
            let mut hand = GuardFrame::new(1, FRAME_DT);
            hand.mode = Mode::On;
            // the largest force for a quarter of each period; r.m.s. of the whole 0.43 of it, at times 0.2
            let at = (0..3000).find(|i| {
                let phase = (f64::from(*i) * FRAME_DT * f).fract();
                hand.force[0] = if phase < 0.25 { p.force } else { 0.0 };
                (hand.flags, hand.inject) = (0, 0.0);
                stage.pass(&mut hand);
                hand.flags & flag::OSCILLATION != 0
            });
            assert!(at.is_some_and(|n| n < 900), "{f} Hz: {at:?}");
        }
        // a single blow as long as that is none
        let mut stage = Oscillation::new(&p, FRAME_DT).expect("it is on");
        let mut hand = GuardFrame::new(1, FRAME_DT);
        hand.mode = Mode::On;
        for i in 0..6000 {
            hand.force[0] = if i % 1000 < 60 { p.force } else { 0.0 };
            (hand.flags, hand.inject) = (0, 0.0);
            stage.pass(&mut hand);
            assert_eq!(hand.flags & flag::OSCILLATION, 0, "{i}");
        }
    }

    #[test]
    fn is_weakened_again_while_it_falls_with_the_gain() {
        let p = Profile::shipped("tgr12").expect("shipped");
        // of a loop, in proportion to the gain; of the model, whatever the gain
        for (of_loop, want) in [(true, 0.3_f64.powi(4)), (false, 0.3)] {
            let mut stage = Oscillation::new(&p, FRAME_DT).expect("it is on");
            let mut hand = GuardFrame::new(1, FRAME_DT);
            hand.mode = Mode::On;
            let mut gain = 1.0;
            for i in 0..900 {
                let shake = 9.0 * (std::f64::consts::TAU * 100.0 * f64::from(i) * FRAME_DT).sin();
                hand.force[0] = if of_loop { gain * shake } else { shake };
                let asked = hand.force[0];
                stage.pass(&mut hand);
                gain = if asked.abs() > 1e-6 { hand.force[0] / asked } else { gain };
            }
            assert!((gain / want - 1.0).abs() < 1e-9, "{of_loop}: {gain}");
        }
    }

    #[test]
    fn comes_back_when_it_is_quiet() {
        let p = Profile::shipped("tgr12").expect("shipped");
        let mut stage = Oscillation::new(&p, FRAME_DT).expect("it is on");
        let mut hand = GuardFrame::new(1, FRAME_DT);
        hand.mode = Mode::On;
        let mut gains = Vec::new();
        for i in 0..12_000 {
            let shake =
                if i < 600 { 9.0 * (std::f64::consts::TAU * 100.0 * f64::from(i) * FRAME_DT).sin() } else { 1.0 };
            hand.force[0] = shake;
            stage.pass(&mut hand);
            gains.push(if shake == 0.0 { 1.0 } else { hand.force[0] / shake });
        }
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(gains[1], 1.0) && near(gains[599], 0.3) && near(gains[3500], 0.3), "{}", gains[3500]);
        assert!(near(gains[11_999], 1.0));
        // back within the time of a ramp, never in a jump
        assert!(gains.windows(2).all(|g| g[1] - g[0] < 1.0 / 2900.0));
    }
}
