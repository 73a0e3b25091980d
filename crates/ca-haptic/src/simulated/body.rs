//! Exact motion of one axis of a device over one frame.
//!
//! Between events the axis is a mass on a spring and a damper under a constant force, in a frame that moves evenly with
//! the intention of the hand: a closed form. Events are a motion that comes to rest, where dry friction reverses or
//! holds, and an end stop, which takes all speed. Bisection finds them to the last bit, because the spring of a hand
//! leaves no formula for them.

#[derive(Clone, Copy, Debug)]
pub(super) struct Mechanics {
    /// Mass of device and hand \[kg\].
    pub mass: f64,
    /// Viscous friction of the device \[N s/m\].
    pub friction: f64,
    /// Dry friction of the device \[N\].
    pub dry: f64,
    /// End stops \[m\].
    pub range: [f64; 2],
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    /// Force of the motor and of a pushing hand \[N\].
    pub force: f64,
    /// Intended position at the start and end of the frame \[m\].
    pub from: f64,
    pub to: f64,
    /// Stiffness \[N/m\] and damping \[N s/m\] of the hand around it.
    pub stiffness: f64,
    pub damping: f64,
}

/// Largest number of events in a frame; more is chatter at a stop.
const EVENTS: usize = 16;

/// Solves x″ = (force − b x′ − k x)/m over `t`, from [x, v].
fn glide([x, v]: [f64; 2], m: f64, b: f64, k: f64, force: f64, t: f64) -> [f64; 2] {
    if k == 0.0 {
        // (e^z − 1)/z and (e^z − 1 − z)/z², by series where they would cancel
        let z = -b * t / m;
        let (one, two) = if z > -1e-3 {
            (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0)), 0.5 + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z / 120.0)))
        } else {
            (z.exp_m1() / z, (z.exp_m1() - z) / (z * z))
        };
        let push = (force - b * v) / m;
        return [x + v * t + push * t * t * two, v + push * t * one];
    }
    // relative to the position of rest
    let rest = force / k;
    let (e, s, w2) = (x - rest, b / (2.0 * m), k / m);
    let d = w2 - s * s;
    let fade = (-s * t).exp();
    // cos or cosh, and sin or sinh divided by the frequency
    let (c, q) = if d * t * t > 1e-8 {
        let w = d.sqrt();
        ((w * t).cos(), (w * t).sin() / w)
    } else if d * t * t < -1e-8 {
        let w = (-d).sqrt();
        ((w * t).cosh(), (w * t).sinh() / w)
    } else {
        (1.0 - 0.5 * d * t * t, t * (1.0 - d * t * t / 6.0))
    };
    [rest + fade * (e * c + (v + s * e) * q), fade * (v * c - (w2 * e + s * v) * q)]
}

impl Mechanics {
    /// Returns position and speed after `t` seconds.
    pub(super) fn go(&self, start: [f64; 2], drive: &Drive, t: f64) -> [f64; 2] {
        let [mut x, mut v] = start;
        let mut done = 0.0;
        let slope = (drive.to - drive.from) / t;
        for _ in 0..EVENTS {
            let left = t - done;
            if left <= 0.0 {
                break;
            }
            let goal = drive.from + slope * done;
            let net = drive.force + drive.stiffness * (goal - x) + drive.damping * (slope - v) - self.friction * v;
            let [low, high] = self.range;
            let stopped = (x <= low && net <= 0.0) || (x >= high && net >= 0.0);
            // at rest, held by a stop or dry friction until the spring of the hand pulls hard enough
            if v == 0.0 && (stopped || net.abs() <= self.dry) {
                let grown = |at: f64| {
                    let net = drive.force + drive.stiffness * (drive.from + slope * at - x) + drive.damping * slope;
                    !((x <= low && net <= self.dry) || (x >= high && net >= -self.dry) || net.abs() <= self.dry)
                };
                if !grown(t) {
                    return [x, 0.0];
                }
                done = bisect(done, t, grown);
                // `done` is just past that moment, so that the next pass moves
                continue;
            }
            let way = if v == 0.0 { net.signum() } else { v.signum() };
            // relative to the intended position and its speed
            let force = drive.force - self.dry * way - self.friction * slope;
            let at = |s: f64| {
                let local = [x - goal, v - slope];
                let b = self.friction + drive.damping;
                let [e, w] = glide(local, self.mass, b, drive.stiffness, force, s);
                [e + goal + slope * s, w + slope]
            };
            let out = |[x, _]: [f64; 2]| (x < low && way < 0.0) || (x > high && way > 0.0);
            let turned = |[_, v]: [f64; 2]| v * way < 0.0 && self.dry > 0.0;
            let end = at(left);
            let event = |s: f64| out(at(s)) || turned(at(s));
            if out(end) || turned(end) {
                let s = bisect(0.0, left, event);
                let [there, _] = at(s);
                let hit = out(at(s));
                x = if hit { there.clamp(low, high) } else { there };
                v = 0.0;
                // time must advance, or the step would repeat forever
                done += s.max(left * 1e-12);
                continue;
            }
            return [end[0].clamp(low, high), end[1]];
        }
        [x.clamp(self.range[0], self.range[1]), v]
    }
}

/// Returns the first moment at which `event` is true, between `a`, where it is false or about to be true, and `b`.
fn bisect(mut a: f64, mut b: f64, event: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..64 {
        let middle = 0.5 * (a + b);
        if middle <= a || middle >= b {
            break;
        }
        *(if event(middle) { &mut b } else { &mut a }) = middle;
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Mechanics = Mechanics { mass: 0.2, friction: 2.0, dry: 0.0, range: [-1e9, 1e9] };

    fn drive(force: f64) -> Drive {
        Drive { force, from: 0.0, to: 0.0, stiffness: 0.0, damping: 0.0 }
    }

    /// Solves by the classical Runge–Kutta method in `n` steps.
    fn reference(m: &Mechanics, d: &Drive, start: [f64; 2], t: f64, n: usize) -> [f64; 2] {
        let [mut x, mut v] = start;
        let (h, slope) = (t / n as f64, (d.to - d.from) / t);
        let acc = |s: f64, x: f64, v: f64| {
            let goal = d.from + slope * s;
            let f = d.force + d.stiffness * (goal - x) + d.damping * (slope - v);
            (f - m.friction * v - m.dry * if v == 0.0 { 0.0 } else { v.signum() }) / m.mass
        };
        for i in 0..n {
            let s = i as f64 * h;
            let (a1, v1) = (acc(s, x, v), v);
            let (v2, a2) = (v + 0.5 * h * a1, acc(s + 0.5 * h, x + 0.5 * h * v1, v + 0.5 * h * a1));
            let (v3, a3) = (v + 0.5 * h * a2, acc(s + 0.5 * h, x + 0.5 * h * v2, v + 0.5 * h * a2));
            let (v4, a4) = (v + h * a3, acc(s + h, x + h * v3, v + h * a3));
            x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
        [x, v]
    }

    fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
        (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
    }

    #[test]
    fn glides_as_the_equation_says() {
        // no, little and much friction; without a spring, and with an under-, critically and overdamped moving hand
        for friction in [0.0, 1e-6, 2.0, 500.0] {
            for (k, z) in [(0.0, 0.0), (400.0, 1.0), (2000.0, 40.0), (1.0, 30.0), (0.0, 5.0)] {
                let m = Mechanics { friction, ..FREE };
                let d = Drive { force: 1.5, from: 0.01, to: 0.012, stiffness: k, damping: z };
                let (start, t) = ([-0.003, 0.4], 0.01);
                let want = reference(&m, &d, start, t, 4000);
                let is = m.go(start, &d, t);
                assert!(apart(is, want) < 1e-11, "b {friction}, k {k}, z {z}: {is:?} {want:?}");
                // ten frames give the result of one
                let mut s = start;
                for i in 0..10 {
                    let at = |i: i32| 0.01 + 0.0002 * f64::from(i);
                    s = m.go(s, &Drive { from: at(i), to: at(i + 1), ..d }, t / 10.0);
                }
                assert!(apart(s, is) < 1e-13, "b {friction}, k {k}, z {z}: {s:?} {is:?}");
            }
        }
        // critical damping to the last bit: m = 0.25, k = 4, b = 2
        let m = Mechanics { mass: 0.25, friction: 2.0, ..FREE };
        let d = Drive { force: 1.0, from: 0.0, to: 0.0, stiffness: 4.0, damping: 0.0 };
        assert!(apart(m.go([0.1, 0.0], &d, 0.3), reference(&m, &d, [0.1, 0.0], 0.3, 4000)) < 1e-11);
    }

    #[test]
    fn dry_friction_stops_and_holds() {
        let m = Mechanics { mass: 0.1, friction: 0.0, dry: 0.5, range: [-1e9, 1e9] };
        // thrown: stops after v²m/2 = f x
        let [x, v] = m.go([0.0, 0.3], &drive(0.0), 1.0);
        assert!((x - 0.3 * 0.3 * 0.1 / (2.0 * 0.5)).abs() < 1e-15, "{x}");
        assert_eq!(v, 0.0);
        // held up to its size, then moved by the excess
        assert_eq!(m.go([0.0, 0.0], &drive(0.4999), 1.0), [0.0, 0.0]);
        let [x, v] = m.go([0.0, 0.0], &drive(-0.7), 0.1);
        assert!((x + 0.5 * 2.0 * 0.01).abs() < 1e-15 && (v + 0.2).abs() < 1e-15, "{x} {v}");
        // a force against the motion: to rest, then back
        let stop = 0.1 * 0.1 / (0.5 + 1.5);
        let [x, v] = m.go([0.0, 0.1], &drive(-1.5), 0.1);
        let back = 0.1 - stop;
        assert!((x - (0.5 * 0.1 * stop - 0.5 * 10.0 * back * back)).abs() < 1e-14, "{x}");
        assert!((v + 10.0 * back).abs() < 1e-13, "{v}");
        // the spring of a hand that grows within the frame breaks it loose
        let d = Drive { force: 0.0, from: 0.0, to: 0.01, stiffness: 100.0, damping: 0.0 };
        let [x, v] = m.go([0.0, 0.0], &d, 0.1);
        // from 5 mm on x″ = ω²(s t − x) from rest: x = s t − (s/ω) sin ω t
        let (w, s, t) = (1000.0_f64.sqrt(), 0.1, 0.05);
        assert!((x - (s * t - s / w * (w * t).sin())).abs() < 1e-12, "{x}");
        assert!((v - s * (1.0 - (w * t).cos())).abs() < 1e-11, "{v}");
    }

    #[test]
    fn stops_take_all_speed() {
        let m = Mechanics { range: [0.0, 0.01], friction: 0.0, ..FREE };
        assert_eq!(m.go([0.009, 1.0], &drive(3.0), 0.1), [0.01, 0.0]);
        assert_eq!(m.go([0.01, 0.0], &drive(3.0), 0.1), [0.01, 0.0]);
        let [x, v] = m.go([0.01, 0.0], &drive(-1.0), 0.01);
        assert!((x - (0.01 - 0.5 * 5.0 * 1e-4)).abs() < 1e-15 && (v + 0.05).abs() < 1e-15);
        // to the stop, and pulled off again by a hand that reverses
        let d = Drive { force: 0.0, from: 0.02, to: -0.02, stiffness: 100.0, damping: 0.0 };
        let [x, v] = m.go([0.01, 0.0], &d, 0.1);
        assert!((0.0..0.01).contains(&x) && v <= 0.0, "{x} {v}");
    }
}
