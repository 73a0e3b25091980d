//! The elastic part of a one-sided law, linear or a power law, as the methods use it.
//!
//! The potential is U(η) = k η²/2 · hard(η) for η > 0, with hard = 1 for the linear spring and η^(p−1) for the power
//! law. Each method is thus written once, at no cost for linear springs. The k of a power law F = q η^p is 2q/(p + 1).

use super::newton::root;
use crate::numeric::{Real, quarter_mean, quarter_power, quarter_root};
use crate::op::account::numbers;
use crate::state::State;

/// The elastic part of a law, and its losses.
pub trait Spring<R: Real>: Copy {
    /// True if the viscosity is unbounded. Rounding errors must then not be multiplied by it.
    const HARDENS: bool;

    /// Makes the contact with these coefficients, in the order of its law.
    fn contact(c: &[R; 5]) -> Contact<R, Self>;

    /// Returns the viscosity \[N per m/tick\] at the penetration `eta` ≥ 0.
    fn viscosity(self, k: R, eta: R) -> R;

    /// Returns the stiffness at a penetration relative to `k`.
    fn hard(self, eta: R) -> R;

    /// Returns 2(U(s) − U(a)) / (k (s − a)) for s and a > 0, without cancellation.
    fn mean(self, s: R, a: R) -> R;

    /// Returns the root s ≥ 0 of s + 2h (U(s) − U(a)) / (k (s − a)) = e, if there is one.
    fn pressed(self, e: R, a: R, h: R) -> R;

    /// Returns force U′ and stiffness U″ at the penetration `eta` > 0.
    fn force(self, k: R, eta: R) -> [R; 2];

    /// Returns the slope of √(2U) under compression \[√(N/m)\].
    fn gamma(self, k: R, eta: R) -> R;
}

/// A one-sided law: a spring and its threshold.
#[derive(Clone, Copy)]
pub struct Contact<R: Real, S> {
    /// stiffness \[N/m\], for the power law \[N/m^p\]
    pub k: R,
    /// threshold of the elongation \[m\]
    pub d: R,
    /// 1 if it acts below the threshold, −1 above
    pub side: R,
    /// true if it only pushes
    pub clip: bool,
    /// elastic part and losses
    pub spring: S,
}

impl<R: Real, S: Spring<R>> Contact<R, S> {
    /// Makes a contact from coefficients in a slice.
    pub fn of(c: &[R]) -> Contact<R, S> {
        S::contact(&numbers(c))
    }

    /// Reads link `i` of `n` from the columns that begin at `coef`.
    pub fn read(s: &State<R>, coef: usize, n: usize, i: usize) -> Contact<R, S> {
        S::contact(&core::array::from_fn(|k| s.coef[coef + k * n + i]))
    }

    /// Returns the penetration \[m\], negative while apart.
    pub fn penetration(&self, e: R) -> R {
        self.side * (self.d - e)
    }

    /// Returns the potential energy \[J\] at a penetration.
    pub fn potential(&self, eta: R) -> R {
        if eta > R::ZERO { R::of(0.5) * self.k * self.spring.hard(eta) * eta * eta } else { R::ZERO }
    }

    /// Returns (U(s) − U(a)) / (s − a) \[N\].
    pub fn slope(&self, s: R, a: R) -> R {
        let Contact { k, spring, .. } = *self;
        match (s > R::ZERO, a > R::ZERO) {
            (true, true) => R::of(0.5) * k * spring.mean(s, a),
            (true, false) => R::of(0.5) * k * spring.hard(s) * s * (s / (s - a)),
            (false, true) => R::of(0.5) * k * spring.hard(a) * a * (a / (a - s)),
            (false, false) => R::ZERO,
        }
    }

    /// Returns the mean push \[N\] while the penetration changes from `a` by `s`, and its derivative by `s` \[N/m\].
    pub fn between(&self, a: R, s: R) -> [R; 2] {
        let (to, mean) = (a + s, self.slope(a + s, a));
        let [force, steep] = if to > R::ZERO { self.spring.force(self.k, to) } else { [R::ZERO; 2] };
        // near `a` the difference of forces is all rounding
        let even = s.abs() <= R::of(1e-6) * to.abs().max(a.abs());
        [mean, if even { R::of(0.5) * steep } else { ((force - mean) / s).max(R::ZERO) }]
    }

    /// Returns the change of penetration over two ticks if this contact were alone: from `a`, with `free` the change by
    /// all other forces, the mobility `c` and the viscosity `z`.
    pub fn alone(&self, a: R, free: R, c: R, z: R) -> R {
        let beta = R::of(0.5) * c * z;
        let h = R::of(0.5) * c * self.k / (R::of(1.0) + beta);
        after(self.spring, (a + free + beta * a) / (R::of(1.0) + beta), a, h) - a
    }
}

/// Returns the penetration after the tick: the root of s + 2h (U(s) − U(a)) / (k (s − a)) = e, quadratic in release.
pub fn after<R: Real, S: Spring<R>>(spring: S, e: R, a: R, h: R) -> R {
    if a >= R::ZERO {
        let g = h * spring.hard(a);
        if e < g * a {
            let (p, q) = (a + e, ((a - e) * (a - e) + R::of(4.0) * g * a * a).sqrt());
            return if p > R::ZERO { R::of(2.0) * a * (e - g * a) / (p + q) } else { R::of(0.5) * (p - q) };
        }
    } else if e <= R::ZERO {
        return e;
    }
    spring.pressed(e, a, h)
}

/// U = k η²/2, with a viscosity.
#[derive(Clone, Copy)]
pub struct Linear<R: Real> {
    /// \[N per m/tick\]
    z: R,
}

impl<R: Real> Spring<R> for Linear<R> {
    const HARDENS: bool = false;
    fn contact(&[k, z, d, side, clip]: &[R; 5]) -> Contact<R, Linear<R>> {
        Contact { k, d, side, clip: clip != R::ZERO, spring: Linear { z } }
    }
    fn viscosity(self, _k: R, _eta: R) -> R {
        self.z
    }
    fn hard(self, _eta: R) -> R {
        R::of(1.0)
    }
    fn mean(self, s: R, a: R) -> R {
        s + a
    }
    fn pressed(self, e: R, a: R, h: R) -> R {
        if a >= R::ZERO {
            return (e - h * a) / (R::of(1.0) + h);
        }
        let p = a + e;
        let q = (p * p - R::of(4.0) * (R::of(1.0) + h) * e * a).sqrt();
        if p >= R::ZERO { (p + q) / (R::of(2.0) * (R::of(1.0) + h)) } else { -R::of(2.0) * e * a / (q - p) }
    }
    fn force(self, k: R, eta: R) -> [R; 2] {
        [k * eta, k]
    }
    fn gamma(self, k: R, _eta: R) -> R {
        k.sqrt()
    }
}

/// U = k η^(p+1)/2 with the losses of Hunt and Crossley, F h dη/dt. It only pushes.
#[derive(Clone, Copy)]
pub struct Power<R: Real> {
    /// 4p, an integer from 4 on
    n: R,
    /// h, relative to the force per unit of change in a tick \[ticks/m\]
    loss: R,
}

impl<R: Real> Power<R> {
    /// Returns (p + 1)/2: the force is this times k η^p.
    fn rise(self) -> R {
        R::of(0.125) * self.n + R::of(0.5)
    }
}

impl<R: Real> Spring<R> for Power<R> {
    const HARDENS: bool = true;
    fn contact(&[q, n, loss, d, side]: &[R; 5]) -> Contact<R, Power<R>> {
        let spring = Power { n, loss };
        Contact { k: q / spring.rise(), d, side, clip: true, spring }
    }
    fn viscosity(self, k: R, eta: R) -> R {
        self.loss * k * self.rise() * quarter_power(eta, self.n)
    }
    fn hard(self, eta: R) -> R {
        quarter_power(eta, self.n - R::of(4.0))
    }
    fn mean(self, s: R, a: R) -> R {
        quarter_mean(s, a, self.n + R::of(4.0))
    }
    /// The left side is convex in s. The start, where the larger of its two parts alone reaches e, is near the root.
    fn pressed(self, e: R, a: R, h: R) -> R {
        if e <= R::ZERO {
            return R::ZERO;
        }
        let (n, most) = (self.n, e / h);
        let far = quarter_root(most, n);
        let guess = if far < -a { quarter_root(most * -a, n + R::of(4.0)) } else { far };
        root(e.min(guess), [R::ZERO, e], a.max(R::ZERO), |s| {
            let p = quarter_power(s, n);
            let (mean, d) = (if a > R::ZERO { self.mean(s, a) } else { p * (s / (s - a)) }, s - a);
            let even = d.abs() <= R::of(1e-6) * s;
            let rise =
                if even { self.rise() * R::of(0.25) * n * p / s } else { (R::of(2.0) * self.rise() * p - mean) / d };
            (s - e + h * mean, R::of(1.0) + h * rise)
        })
    }
    fn force(self, k: R, eta: R) -> [R; 2] {
        let steep = k * self.rise() * self.hard(eta);
        [steep * eta, steep * R::of(0.25) * self.n]
    }
    fn gamma(self, k: R, eta: R) -> R {
        self.rise() * (k * self.hard(eta)).sqrt()
    }
}
