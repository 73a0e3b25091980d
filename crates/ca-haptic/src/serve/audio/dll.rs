//! Predicts when a sound device asks for a sample, from the times of its earlier calls.
//!
//! This is the delay-locked loop of F. Adriaensen, "Using a DLL to filter time" (LAC 2005). It has second order, with
//! gains √2·ω and ω², so it follows any steady rate without lasting error, and filters the jitter of the calls. A
//! measured rate alone would drift with each misjudged call. The loop steps by samples, not by calls, so that calls may
//! have any size and may be missing. A call far from its expected time means that the device was stopped: the loop
//! locks again, and retains the rate.
//!
//! Random delays make calls late, never early, and a linear loop would overshoot by 6 ms after a call that is 30 ms
//! late. So a call that is much too early moves the time back at once, and so do early calls just after a lock. A call
//! that is much too late is ignored, unless [`LATE`] of them in a row show that the device has lost time.

/// Bandwidth \[Hz\]. With it, a rate error of 1000 ppm gives a time error of at most 0.15 ms.
const BANDWIDTH: f64 = 0.5;
/// Largest phase step of one call \[rad\], so that the loop is stable for calls of any length.
const TURN: f64 = 0.3;
/// Error from which the loop locks again \[ns\], or two calls if that is longer.
const JUMP: f64 = 5e7;
/// Error that is more than jitter \[ns\], or [`PART`] of a call if that is longer.
const JITTER: f64 = 1e6;
const PART: f64 = 0.02;
/// Late calls in a row that show a loss of time.
const LATE: u32 = 8;
/// Calls after a lock that move the time back at once if they are early.
const SETTLE: u32 = 16;
/// Settling time of the loop \[ns\]: e^{−ωt/√2} = 1e-3.
const SETTLED: f64 = 3.2e9;
/// Largest rate error of a device, as a fraction of its rate.
const WRONG: f64 = 0.05;

/// The loop. Times are \[ns\] of one clock; a sample covers all channels.
#[derive(Clone, Debug)]
pub struct Dll {
    nominal: f64,
    /// Origin of the times \[ns\].
    base: u64,
    /// Last call: first sample, and filtered time \[ns\].
    n: u64,
    t: f64,
    /// Duration of a sample \[ns\].
    dt: f64,
    /// Time of the last lock \[ns\], and the first call after it has settled.
    lock: f64,
    since: Option<(u64, f64)>,
    settle: u32,
    locked: bool,
    /// Number of much too late calls in a row, and their smallest error \[ns\].
    late: u32,
    least: f64,
}

impl Dll {
    /// Makes a loop for a device with `rate` samples per second.
    pub fn new(rate: f64) -> Dll {
        let dt = 1e9 / rate;
        Dll {
            nominal: dt,
            base: 0,
            n: 0,
            t: 0.0,
            dt,
            lock: 0.0,
            since: None,
            settle: 0,
            locked: false,
            late: 0,
            least: 0.0,
        }
    }

    /// Notes that the device asked for samples from `n` on at `at` \[ns\]. Returns true if this locked the loop again.
    pub fn add(&mut self, n: u64, at: u64) -> bool {
        if !self.locked {
            (self.base, self.locked) = (at, true);
            self.lock_on(n, 0.0);
            return false;
        }
        let at = at as f64 - self.base as f64;
        let h = n as f64 - self.n as f64;
        let due = self.t + h * self.dt;
        let e = at - due;
        if h <= 0.0 || e.abs() > JUMP.max(2.0 * h * self.dt) {
            self.lock_on(n, at);
            return true;
        }
        self.n = n;
        let much = JITTER.max(PART * h * self.dt);
        if e > much {
            self.least = if self.late == 0 { e } else { self.least.min(e) };
            self.late += 1;
            let lost = self.late == LATE;
            self.shift(if lost { due + self.least } else { due }, lost);
            return false;
        }
        self.late = 0;
        if e < -much {
            self.shift(at, true);
            return false;
        }
        let w = (std::f64::consts::TAU * BANDWIDTH * h * self.dt * 1e-9).min(TURN);
        self.settle = self.settle.saturating_sub(1);
        let gain = if self.settle > 0 && e < 0.0 { 1.0 } else { std::f64::consts::SQRT_2 * w };
        self.t = due + gain * e;
        self.dt = (self.dt + w * w * e / h).clamp(self.nominal * (1.0 - WRONG), self.nominal * (1.0 + WRONG));
        if self.since.is_none() && self.t - self.lock > SETTLED {
            self.since = Some((n, self.t));
        }
        false
    }

    fn lock_on(&mut self, n: u64, at: f64) {
        (self.n, self.settle, self.late) = (n, SETTLE, 0);
        self.shift(at, true);
    }

    /// Sets the phase. With `lost`, the measurement of the rate starts again.
    fn shift(&mut self, at: f64, lost: bool) {
        self.t = at;
        if lost {
            (self.lock, self.since, self.late) = (at, None, 0);
        }
    }

    /// Returns when sample `n` is requested \[ns\].
    pub fn when(&self, n: i64) -> f64 {
        self.base as f64 + self.t + (n as f64 - self.n as f64) * self.dt
    }

    /// Returns the present duration of a sample \[ns\].
    pub fn sample(&self) -> f64 {
        self.dt
    }

    /// Returns true once the device has asked for samples.
    pub fn is_locked(&self) -> bool {
        self.locked
    }

    /// Returns the rate of the device above nominal \[ppm\]: the mean since the loop settled, or else the present one.
    pub fn ppm(&self) -> f64 {
        let dt = match self.since {
            Some((n, t)) if self.n > n => (self.t - t) / (self.n - n) as f64,
            _ => self.dt,
        };
        (self.nominal / dt - 1.0) * 1e6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 48_000.0;
    const CALL: u64 = 64;
    /// \[rad/s\]
    const OMEGA: f64 = std::f64::consts::TAU * BANDWIDTH;

    /// Returns when a device with `rate` samples per second from `from` \[ns\] on asks for sample `n` \[ns\].
    fn at(n: u64, rate: f64, from: f64) -> f64 {
        from + n as f64 / rate * 1e9
    }

    fn noise(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// After a step of the rate by Δ, the error is e(t) = Δ·√2/ω·e^{−ωt/√2}·sin(ωt/√2), which decays to zero.
    #[test]
    fn another_rate_is_followed_as_theory_says() {
        for ppm in [-1000.0, -37.0, 250.0, 1000.0] {
            let rate = RATE * (1.0 + ppm * 1e-6);
            let mut d = Dll::new(RATE);
            let a = OMEGA / 2_f64.sqrt();
            let most = ppm.abs() * 1e-6 / OMEGA * 1e9;
            for k in 0..90_000 {
                let n = k * CALL;
                let real = at(n, rate, 5e12);
                assert!(!d.add(n, real as u64));
                // a faster device is at first followed call by call
                let settled = if ppm > 0.0 { u64::from(SETTLE) - 1 } else { 0 };
                let t = (n as f64 - (settled * CALL) as f64).max(0.0) / rate;
                // a slower device asks later than expected
                let e = -ppm * 1e-6 * 2_f64.sqrt() / OMEGA * (-a * t).exp() * (a * t).sin() * 1e9;
                let got = real - d.when(n as i64);
                // tolerance for discrete calls, for two times in whole nanoseconds, and for the first calls
                assert!((got - e).abs() < 0.03 * most + 5.0, "{ppm} ppm, {t} s: {got} ns, not {e}");
            }
            // after two minutes: no drift, and the right rate
            let n = 90_000 * CALL;
            assert!((d.when(n as i64) - at(n, rate, 5e12)).abs() < 5.0);
            // tolerance: rest of the transient at `SETTLED`, over 117 s
            assert!((d.ppm() - ppm).abs() < 5e-3, "{} for {ppm} ppm", d.ppm());
        }
    }

    /// With calls up to J early or late, the error never exceeds the bound by the sum of the loop's impulse response.
    /// Its r.m.s. value is √(1.5·ω/√2·T) of the standard deviation of the jitter.
    #[test]
    fn jitter_is_filtered() {
        for (rate, jitter) in [(RATE, 8e5), (RATE * 1.0003, 2e5)] {
            let (mut d, mut seed) = (Dll::new(RATE), 7);
            let (mut worst, mut sum, mut many) = (0_f64, 0.0, 0.0);
            for k in 0..60_000_u64 {
                let n = k * CALL;
                let real = at(n, rate, 1e9);
                assert!(!d.add(n, (real + jitter * noise(&mut seed)) as u64));
                if n as f64 > 10.0 * RATE {
                    let e = d.when(n as i64) - real;
                    worst = worst.max(e.abs());
                    (sum, many) = (sum + e * e, many + 1.0);
                    // within a call, and one call ahead
                    let next = d.when((n + CALL) as i64) - at(n + CALL, rate, 1e9);
                    assert!((next - e).abs() < 0.01 * jitter, "{next} {e}");
                }
            }
            let rms = (sum / many).sqrt();
            let theory = jitter / 3_f64.sqrt() * (1.5 * OMEGA / 2_f64.sqrt() * CALL as f64 / RATE).sqrt();
            assert!((rms / theory - 1.0).abs() < 0.25, "{rms} ns, theory {theory}");
            assert!(worst < 1.4345 * jitter && worst < 6.0 * theory, "{worst} {theory}");
            assert!((d.ppm() - (rate / RATE - 1.0) * 1e6).abs() < 2.0 * 2.0 * worst * 1e-9 / 70.0 * 1e6, "{}", d.ppm());
        }
    }

    /// Most calls come soon, and one in ten some milliseconds late. The late ones are ignored, and the others filtered.
    #[test]
    fn what_is_much_too_late_does_not_count() {
        let (mut d, mut seed) = (Dll::new(RATE), 3);
        for k in 0..60_000_u64 {
            let n = k * CALL;
            let real = at(n, RATE * 0.9998, 1e9);
            let soon = 1e5 * (1.0 + noise(&mut seed));
            let late = if noise(&mut seed) > 0.8 { 4e6 * (1.0 + noise(&mut seed)) } else { 0.0 };
            d.add(n, (real + soon + late) as u64);
            if n as f64 > 10.0 * RATE {
                // 0.1 ms on average, plus the effect of 1 call in 80 that is late by less than a millisecond
                let e = d.when(n as i64) - real;
                assert!((5e4..2.5e5).contains(&e), "{e} at {k}");
            }
        }
    }

    /// A device loses 30 ms at once: the prediction is never late by that, and the rate stays.
    #[test]
    fn a_step_does_not_overshoot() {
        for (step, calls) in [(3e7, LATE), (2e6, LATE), (-2e7, 1)] {
            let mut d = Dll::new(RATE);
            for k in 0..20_000 {
                d.add(k * CALL, at(k * CALL, RATE, 1e9) as u64);
            }
            for k in 20_000..40_000_u64 {
                let real = at(k * CALL, RATE, 1e9) + step;
                assert!(!d.add(k * CALL, real as u64));
                let e = d.when((k * CALL) as i64) - real;
                assert!(e < 5.0, "{e} ns late at {k}");
                assert!(k < 20_000 + u64::from(calls) - 1 || e > -5.0, "{e} at {k}");
            }
            assert!(d.ppm().abs() < 1e-3);
        }
    }

    /// After a late first call, the next calls show when it should have come.
    #[test]
    fn a_lock_on_a_late_call_is_mended_at_once() {
        let mut d = Dll::new(RATE);
        d.add(0, 1_000_000_000 + 5_000_000);
        for k in 1..(SETTLE as u64) {
            d.add(k * CALL, at(k * CALL, RATE, 1e9) as u64);
            assert!((d.when((k * CALL) as i64) - at(k * CALL, RATE, 1e9)).abs() < 2e3);
        }
    }

    #[test]
    fn calls_that_nobody_heard_of_leave_no_trace() {
        let rate = RATE * 1.0001;
        let mut d = Dll::new(RATE);
        for k in (0..40_000_u64).filter(|k| k % 7 != 3 && !(20_000..20_030).contains(k)) {
            assert!(!d.add(k * CALL, at(k * CALL, rate, 3e9) as u64));
        }
        assert!((d.when(40_000 * 64) - at(40_000 * CALL, rate, 3e9)).abs() < 5.0);
        assert!((d.ppm() - 100.0).abs() < 1e-3, "{}", d.ppm());
    }

    /// A device stops for a while, and later loses a call.
    #[test]
    fn after_a_stop_it_locks_again_and_keeps_the_rate() {
        let rate = RATE * 0.9995;
        let mut d = Dll::new(RATE);
        let mut n = 0;
        while n < 48_000 * 20 {
            d.add(n, at(n, rate, 0.0) as u64);
            n += CALL;
        }
        assert!(d.add(n, (at(n, rate, 0.0) + 2e9) as u64), "two seconds late");
        for _ in 0..1000 {
            n += CALL;
            assert!(!d.add(n, (at(n, rate, 0.0) + 2e9) as u64));
            assert!((d.when(n as i64) - at(n, rate, 2e9)).abs() < 100.0, "no second transient");
        }
        assert!((d.ppm() + 500.0).abs() < 0.1);
        // after a lost call, all calls come one call later
        let late = 2e9 + CALL as f64 / rate * 1e9;
        for _ in 0..10_000 {
            n += CALL;
            assert!(!d.add(n, at(n, rate, late) as u64), "no reason to lock");
        }
        assert!((d.when(n as i64) - at(n, rate, late)).abs() < 5.0);
        // sample numbers that go back belong to another stream
        assert!(d.add(0, (at(n, rate, late) + 1e6) as u64));
    }

    #[test]
    fn calls_of_any_length_are_stable() {
        for call in [1, 16, 1024, 96_000] {
            let rate = RATE * 1.0008;
            let mut d = Dll::new(RATE);
            let calls = (60.0 * RATE) as u64 / call + 200;
            for k in 0..calls {
                assert!(!d.add(k * call, at(k * call, rate, 1e12) as u64));
            }
            let n = calls * call;
            assert!(
                (d.when(n as i64) - at(n, rate, 1e12)).abs() < 2e3,
                "{call}: {}",
                d.when(n as i64) - at(n, rate, 1e12)
            );
        }
    }
}
