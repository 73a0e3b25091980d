//! Methods: links that keep energy exact whatever their stiffness: linear ones ([`implicit`], numerics 3.1) and one-sided
//! springs (numerics 3.3, 3.4), of which the rest of this page speaks.
//!
//! The explicit contact makes or swallows energy at every blow (numerics 3.2), because its force is that at the
//! beginning of a tick. The methods here choose the force so that its work over the tick is what the spring takes up,
//! which needs the motion that all *other* forces would cause: their passes come last among the forces (see
//! [`Turn`](crate::op::law::Turn)). Decides against sub-steps and against iterating the whole scene: both cost in
//! every tick, these only while something touches.
//!
//! Common to the contacts: the penetration η is `side·(d − e)`, positive while pressed together; the push N ≥ 0 acts against
//! it, and as a tension of the link it is F = −side·N. A push N kept over a tick takes the work N·s/2 from the masses,
//! where s = η₊ − η₋ is the change of penetration over two ticks (numerics 2.2).

pub mod gradient;
pub mod implicit;
pub mod quadratised;

use crate::layout::Layout;
use crate::state::State;

/// A one-sided spring and damper; its coefficients in the order of its law.
#[derive(Clone, Copy)]
struct Buffer {
    /// stiffness \[N/m\]
    k: f64,
    /// viscosity \[N per m/tick\]
    z: f64,
    /// threshold of the elongation \[m\]
    d: f64,
    /// 1: acts below the threshold; −1: above
    side: f64,
    /// pushes only
    clip: bool,
}

impl Buffer {
    fn of(c: &[f64]) -> Buffer {
        let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
        Buffer { k: at(0), z: at(1), d: at(2), side: at(3), clip: at(4) != 0.0 }
    }

    /// Link `i` of `n`, from the columns that begin at `coef`.
    fn read(s: &State, coef: usize, n: usize, i: usize) -> Buffer {
        Buffer::of(&core::array::from_fn::<f64, 5, _>(|k| s.coef[coef + k * n + i]))
    }

    fn penetration(&self, e: f64) -> f64 {
        self.side * (self.d - e)
    }

    /// Potential energy \[J\] at a penetration.
    fn potential(&self, eta: f64) -> f64 {
        if eta > 0.0 { 0.5 * self.k * eta * eta } else { 0.0 }
    }
}

/// The change of position \[m/tick\] that all forces so far give to a place in this tick. A port goes on as it went:
/// where it will be is not known yet.
fn goes(layout: &Layout, s: &State, place: usize) -> f64 {
    let n = layout.n_mat;
    s.coef[place] * s.d[place] + s.coef[n + place] * s.x[place] + s.coef[2 * n + place] * s.f[place]
}

/// Mobility T²/m of a place \[m/N\].
fn mobility(layout: &Layout, s: &State, place: usize) -> f64 {
    s.coef[2 * layout.n_mat + place]
}
