//! Spring: the elastic part of a one-sided law, linear or a power, as the methods see it.
//!
//! Decides to write U(η) = k η²/2 · hard(η) for η > 0, with hard = 1 of the linear spring and η^(p−1) of the power law,
//! so that both methods are written once and what is linear costs what it did: there every factor is 1. The k of a
//! power law F = q η^p is then 2q/(p + 1).

use super::newton::root;
use crate::numeric::{Real, quarter_mean, quarter_power, quarter_root, real, sqrt};
use crate::state::State;

/// The elastic part of a law and its losses.
pub trait Spring: Copy {
    /// True where viscosity has no bound, so that rounding must not be multiplied by it.
    const HARDENS: bool;

    /// The contact with these coefficients, in the order of its law.
    fn contact(c: &[Real; 5]) -> Contact<Self>;

    /// Viscosity \[N per m/tick\] at the penetration `eta` ≥ 0.
    fn viscosity(self, k: Real, eta: Real) -> Real;

    /// How much harder it is at a penetration than `k` says.
    fn hard(self, eta: Real) -> Real;

    /// 2(U(s) − U(a)) / (k (s − a)) for s and a > 0, without its cancellation.
    fn mean(self, s: Real, a: Real) -> Real;

    /// The root s ≥ 0 of s + 2h (U(s) − U(a)) / (k (s − a)) = e, where there is one.
    fn pressed(self, e: Real, a: Real, h: Real) -> Real;

    /// The slope of √(2U) where it is pressed together \[√(N/m)\].
    fn gamma(self, k: Real, eta: Real) -> Real;
}

/// A one-sided law: a spring, and where it acts.
#[derive(Clone, Copy)]
pub struct Contact<S> {
    /// stiffness \[N/m\], for the power law \[N/m^p\]
    pub k: Real,
    /// threshold of the elongation \[m\]
    pub d: Real,
    /// 1: acts below the threshold; −1: above
    pub side: Real,
    /// pushes only
    pub clip: bool,
    /// how force grows with penetration, and the losses
    pub spring: S,
}

impl<S: Spring> Contact<S> {
    /// From coefficients in a slice.
    pub fn of(c: &[Real]) -> Contact<S> {
        S::contact(&c.first_chunk().copied().unwrap_or_default())
    }

    /// Link `i` of `n`, from the columns that begin at `coef`.
    pub fn read(s: &State, coef: usize, n: usize, i: usize) -> Contact<S> {
        S::contact(&core::array::from_fn(|k| s.coef[coef + k * n + i]))
    }

    /// How far it is pressed together \[m\]; negative while apart.
    pub fn penetration(&self, e: Real) -> Real {
        self.side * (self.d - e)
    }

    /// Potential energy \[J\] at a penetration.
    pub fn potential(&self, eta: Real) -> Real {
        if eta > 0.0 { 0.5 * self.k * self.spring.hard(eta) * eta * eta } else { real(0.0) }
    }

    /// (U(s) − U(a)) / (s − a) \[N\].
    pub fn slope(&self, s: Real, a: Real) -> Real {
        let Contact { k, spring, .. } = *self;
        match (s > 0.0, a > 0.0) {
            (true, true) => 0.5 * k * spring.mean(s, a),
            (true, false) => 0.5 * k * spring.hard(s) * s * (s / (s - a)),
            (false, true) => 0.5 * k * spring.hard(a) * a * (a / (a - s)),
            (false, false) => real(0.0),
        }
    }
}

/// U = k η²/2, with a viscosity.
#[derive(Clone, Copy)]
pub struct Linear {
    /// \[N per m/tick\]
    z: Real,
}

impl Spring for Linear {
    const HARDENS: bool = false;
    fn contact(&[k, z, d, side, clip]: &[Real; 5]) -> Contact<Linear> {
        Contact { k, d, side, clip: clip != 0.0, spring: Linear { z } }
    }
    fn viscosity(self, _k: Real, _eta: Real) -> Real {
        self.z
    }
    fn hard(self, _eta: Real) -> Real {
        real(1.0)
    }
    fn mean(self, s: Real, a: Real) -> Real {
        s + a
    }
    fn pressed(self, e: Real, a: Real, h: Real) -> Real {
        if a >= 0.0 {
            return (e - h * a) / (1.0 + h);
        }
        let p = a + e;
        let q = sqrt(p * p - 4.0 * (1.0 + h) * e * a);
        if p >= 0.0 { (p + q) / (2.0 * (1.0 + h)) } else { -2.0 * e * a / (q - p) }
    }
    fn gamma(self, k: Real, _eta: Real) -> Real {
        sqrt(k)
    }
}

/// U = k η^(p+1)/2 with the losses of Hunt and Crossley, F h dη/dt; only pushes.
#[derive(Clone, Copy)]
pub struct Power {
    /// 4p, a whole number from 4 on
    n: Real,
    /// h, relative to the force per unit of change in a tick \[ticks/m\]
    loss: Real,
}

impl Power {
    /// (p + 1)/2: the force is k η^p times this.
    fn rise(self) -> Real {
        0.125 * self.n + 0.5
    }
}

impl Spring for Power {
    const HARDENS: bool = true;
    fn contact(&[q, n, loss, d, side]: &[Real; 5]) -> Contact<Power> {
        let spring = Power { n, loss };
        Contact { k: q / spring.rise(), d, side, clip: true, spring }
    }
    fn viscosity(self, k: Real, eta: Real) -> Real {
        self.loss * k * self.rise() * quarter_power(eta, self.n)
    }
    fn hard(self, eta: Real) -> Real {
        quarter_power(eta, self.n - 4.0)
    }
    fn mean(self, s: Real, a: Real) -> Real {
        quarter_mean(s, a, self.n + 4.0)
    }
    /// The left side is convex in s. The start is where the larger of its two parts alone would reach e, so that the
    /// root is near whatever the stiffness.
    fn pressed(self, e: Real, a: Real, h: Real) -> Real {
        if e <= 0.0 {
            return real(0.0);
        }
        let (n, most) = (self.n, e / h);
        let far = quarter_root(most, n);
        let guess = if far < -a { quarter_root(most * -a, n + 4.0) } else { far };
        root(e.min(guess), [real(0.0), e], a.max(0.0), |s| {
            let p = quarter_power(s, n);
            let (mean, d) = (if a > 0.0 { self.mean(s, a) } else { p * (s / (s - a)) }, s - a);
            let even = d.abs() <= 1e-6 * s;
            let rise = if even { self.rise() * 0.25 * n * p / s } else { (2.0 * self.rise() * p - mean) / d };
            (s - e + h * mean, 1.0 + h * rise)
        })
    }
    fn gamma(self, k: Real, eta: Real) -> Real {
        self.rise() * sqrt(k * self.hard(eta))
    }
}
