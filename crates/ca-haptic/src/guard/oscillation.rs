//! H13: weakens a force that shakes the hand until the shaking ends.
//!
//! The detector measures the force above 30 Hz, up to the Nyquist frequency of the loop: a second-order high-pass, a
//! low-pass only where the profile asks for one, and a running mean of the squares. If the r.m.s. value stays above its
//! share of the largest force for long enough (time below counts back), a fixed gain weakens the force.
//!
//! A loop that is still unstable at that gain goes on with a smaller amplitude, or still at the largest force, and is
//! weakened again each time it lasted as long. A force that goes on at the same level without being cut comes from the
//! model itself, however weak it reaches the hand, and keeps its gain.
//!
//! The force fades in again, as after arming, once the force of the model has been quiet for twenty times as long; the
//! wait doubles each time it has to be weakened again. A latch instead would disable an instrument because of a loud
//! passage. Every weakened frame carries a flag.

use super::gate::frames;
use super::{GuardFrame, Stage};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Detector and gain per force vector.
pub struct Oscillation {
    axes: usize,
    high: Biquad,
    low: Option<Biquad>,
    /// Weight of the new square in the running mean.
    share: f64,
    threshold: f64,
    gain: f64,
    least: f64,
    rise: f64,
    frames: u32,
    past: [Past; DOF],
    seen: [Seen; DOF],
}

/// Quiet time before the force returns, in units of `oscillation_time`: the first, and the longest.
const QUIET: [u32; 2] = [20, 640];
/// Ratio of levels after and before weakening below which the loop made the oscillation.
const FELL: f64 = 0.7;
const TIMES: usize = 4;
/// Ratio of `oscillation_time` to the time constant of the running mean.
const MEAN: f64 = 5.0;

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
    /// Mean square when it was last weakened; 0 before.
    before: f64,
    /// Frames of quiet until the force returns.
    wait: u32,
}

/// Approximates tan(π f frame_dt) to a few percent up to a quarter of the rate, with the same bits on every machine.
fn warped(f: f64, frame_dt: f64) -> f64 {
    let w = std::f64::consts::PI * (f * frame_dt).min(0.4);
    w / (1.0 - w * w / 3.0)
}

impl Biquad {
    /// Designs a Butterworth filter by the bilinear transform.
    fn new(f: f64, frame_dt: f64, high: bool) -> Biquad {
        let k = warped(f, frame_dt);
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
        let a = [2.0 * (k * k - 1.0) * norm, (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm];
        let b = if high { [norm, -2.0 * norm, norm] } else { [k * k * norm, 2.0 * k * k * norm, k * k * norm] };
        Biquad { b, a }
    }

    // transposed direct form II
    fn pass(&self, s: &mut [f64; 2], x: f64) -> f64 {
        let y = self.b[0] * x + s[0];
        *s = [self.b[1] * x - self.a[0] * y + s[1], self.b[2] * x - self.a[1] * y];
        y
    }
}

impl Oscillation {
    /// Builds the stage from a profile, at `frame_dt` seconds a frame; `None` if the profile turns it off.
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
    fn new(frames: u32) -> Seen {
        Seen { square: 0.0, loud: 0, quiet: 0, gain: 1.0, before: 0.0, wait: QUIET[0].saturating_mul(frames) }
    }
}

impl Stage for Oscillation {
    fn name(&self) -> &'static str {
        "oscillation"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        // starts afresh while forces are off: the gate checks the full force before it lets forces begin
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
            // a loop oscillates less at a smaller gain
            let scale = if first { 1.0 } else { s.gain * s.gain };
            let goes_on = first || s.square < FELL * FELL * s.before || hand.flags & flag::SATURATED != 0;
            let loud = s.square > self.threshold * scale && s.gain > self.least && goes_on;
            // counted back rather than reset: a hand that bounces off a wall leaves it in between
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

    /// Returns the frame of `n` in which a sine of `f` hertz and `size` times the largest force is first weakened.
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
        // r.m.s. values of 0.42 and 0.28 of the largest force, on either side of 0.3
        for f in [60.0, 100.0, 200.0, 400.0, 1000.0, 1450.0] {
            let at = weakened(f, 0.6, 3000).expect("an oscillation");
            assert!((150..220).contains(&at), "{f} Hz after {at} frames");
            assert_eq!(weakened(f, 0.4, 3000), None, "{f} Hz");
        }
        // an octave and a half below the band, and a steady push
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
            // the largest force for a quarter of each period: r.m.s. 0.43 of it overall, at times 0.2
            let at = (0..3000).find(|i| {
                let phase = (f64::from(*i) * FRAME_DT * f).fract();
                hand.force[0] = if phase < 0.25 { p.force } else { 0.0 };
                (hand.flags, hand.inject) = (0, 0.0);
                stage.pass(&mut hand);
                hand.flags & flag::OSCILLATION != 0
            });
            assert!(at.is_some_and(|n| n < 900), "{f} Hz: {at:?}");
        }
        // a single blow of that length is not an oscillation
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
        // a loop shakes in proportion to the gain; the model shakes at any gain
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
        // returns over the time of a ramp, without a jump
        assert!(gains.windows(2).all(|g| g[1] - g[0] < 1.0 / 2900.0));
    }
}
