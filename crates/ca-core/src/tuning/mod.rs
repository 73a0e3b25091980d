//! Tuning: the stiffness and viscosity with which a method gives a pitch and a decay time.
//!
//! A mode has the dimensionless stiffness a = T²k/m and viscosity b = Tz/m. Its pole is r e^(iφ) with φ = 2πfT and r =
//! 10^(−3T/t60). This pole requires, by
//! - the explicit scheme: a = 1 + r² − 2r cos φ and b = 1 − r² (docs/numerics.md §1.5, [`retune`]);
//! - the implicit scheme with the share θ, (1 + b/2 + θa) w² − (2 − a(1 − 2θ)) w + (1 − b/2 + θa) = 0: a = D(1 + r² −
//!   2r cos φ) and b = D(1 − r²), where D = 1/((1 + r²)/2 − θ(1 + r² − 2r cos φ)); `centred` is θ = 0;
//! - the exact mode: a = φ² + s² and b = 2s, where s = −ln r.
//!
//! A pitch is the one that sounds with any method, so changing the method does not detune a model. With the stiffness
//! of the explicit scheme, another method would be 15 cents off at 440 Hz and 48 kHz.

pub(crate) mod problem;
pub mod wave;

use core::f64::consts::{LN_10, PI};

crate::choice::choice! {
    /// Method for the linear part. A link or a cell can use the first three, a group also `modal` and `auto`, the whole model
    /// all.
    pub enum Method {
        /// explicit, the scheme of CORDIS-ANIMA
        Ca = "ca",
        /// viscosity from the positions before and after the tick
        Centred = "centred",
        /// stiffness too, with a share θ
        Implicit = "implicit",
        /// by its modes
        Modal = "modal",
        /// explicit, and links that are not linear by the method that conserves their energy
        Auto = "auto",
        /// the whole model, by [`crate::method::pefrl`]
        Pefrl = "pefrl",
    }
}

impl Method {
    /// Words for a link or a cell.
    pub(crate) const OF_LINK: &'static [&'static str] = Method::WORDS.split_at(3).0;
    /// Words for a group.
    pub const OF_GROUP: &'static [&'static str] = Method::WORDS.split_at(5).0;

    /// Returns the share θ of the force from before and after the tick, each, or `None` for methods that are not
    /// implicit.
    pub fn theta(self, written: Option<f64>) -> Option<f64> {
        match self {
            Method::Centred => Some(0.0),
            Method::Implicit => Some(written.unwrap_or(0.5)),
            Method::Ca | Method::Modal | Method::Pefrl | Method::Auto => None,
        }
    }
}

/// Scheme for the linear part of a group, a link or a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Scheme {
    /// explicit scheme
    #[default]
    Explicit,
    /// implicit scheme with this share of the force from the tick before and the tick after, each; 0 is `centred`
    Implicit(f64),
    /// exact modes, without an error in time
    Modal,
}

impl Scheme {
    /// Returns the scheme of a medium, by its method and its `theta`.
    pub fn of(method: Method, written: Option<f64>) -> Scheme {
        match method.theta(written) {
            Some(theta) => Scheme::Implicit(theta),
            None if method == Method::Modal => Scheme::Modal,
            None => Scheme::Explicit,
        }
    }

    /// Returns the viscosity b with which modes decay by 60 dB in `t60` \[s\].
    ///
    /// With a share θ above 0 it holds only for periods long against a tick; [`Scheme::tuned`] also uses the pitch.
    pub fn damped(self, t60: f64, tick_dt: f64) -> f64 {
        let s = 3.0 * LN_10 / t60 * tick_dt;
        match self {
            Scheme::Explicit => retune(0.0, t60, tick_dt).1,
            // 2 (1 − r²)/(1 + r²)
            Scheme::Implicit(_) => 2.0 * libm::tanh(s),
            Scheme::Modal => 2.0 * s,
        }
    }

    /// Returns the stiffness a and viscosity b for a pitch `f` \[Hz\] and a decay `t60` \[s\], or `None` without such a
    /// pole.
    pub fn tuned(self, f: f64, t60: f64, tick_dt: f64) -> Option<(f64, f64)> {
        let (s, phi) = (3.0 * LN_10 / t60 * tick_dt, 2.0 * PI * f * tick_dt);
        match self {
            Scheme::Explicit => Some(retune(f, t60, tick_dt)),
            Scheme::Implicit(theta) => {
                let (r, square) = (libm::exp(-s), -libm::expm1(-2.0 * s));
                let bend = bend(r, -libm::expm1(-s), phi);
                let d = 1.0 / (1.0 - 0.5 * square - theta * bend);
                (d.is_finite() && d > 0.0).then_some((d * bend, d * square))
            }
            Scheme::Modal => Some((phi * phi + s * s, 2.0 * s)),
        }
    }

    /// Returns the stiffness a for a pitch `f` \[Hz\] at the viscosity b, or `None` if the scheme lacks such a pole.
    pub fn stiffness(self, f: f64, b: f64, tick_dt: f64) -> Option<f64> {
        let phi = 2.0 * PI * f * tick_dt;
        match self {
            Scheme::Explicit => {
                let r = libm::sqrt((1.0 - b).max(0.0));
                let half = libm::sin(PI * f * tick_dt);
                Some((1.0 - r) * (1.0 - r) + 4.0 * r * half * half)
            }
            Scheme::Implicit(theta) => {
                // r² = 1 − b/D, and D depends on r a little
                let (mut square, mut a) = (0.0_f64, None);
                for _ in 0..64 {
                    let r = libm::sqrt((1.0 - square).max(0.0));
                    let bend = bend(r, square / (1.0 + r), phi);
                    let d = 1.0 / (1.0 - 0.5 * square - theta * bend);
                    a = (d.is_finite() && d > 0.0).then_some(d * bend);
                    let next = (b / d).clamp(0.0, 1.0);
                    if next == square {
                        break;
                    }
                    square = next;
                }
                a
            }
            Scheme::Modal => Some(phi * phi + 0.25 * b * b),
        }
    }

    /// Returns the largest stable stiffness a of a mode, relative to the explicit scheme.
    pub fn stability_limit(self) -> f64 {
        match self {
            Scheme::Explicit => 1.0,
            Scheme::Implicit(theta) if theta < 0.25 => 1.0 / (1.0 - 4.0 * theta),
            Scheme::Implicit(_) | Scheme::Modal => f64::INFINITY,
        }
    }
}

/// Returns 1 + r² − 2r cos φ in a form without cancellation; `loss` is 1 − r.
fn bend(r: f64, loss: f64, phi: f64) -> f64 {
    let half = libm::sin(0.5 * phi);
    loss * loss + 4.0 * r * half * half
}

/// Returns the dimensionless stiffness a = kT²/m and viscosity b = zT/m with which the explicit scheme oscillates at
/// exactly `f` \[Hz\] and loses 60 dB in exactly `t60` \[s\] (docs/numerics.md §1.5).
///
/// `t60` may be infinite. The form avoids cancellation at low frequency, where 1 − 2r cos θ + r² loses five digits.
pub fn retune(f: f64, t60: f64, tick_dt: f64) -> (f64, f64) {
    let s = 3.0 * core::f64::consts::LN_10 / t60;
    let q = -libm::expm1(-s * tick_dt);
    let r = 1.0 - q;
    let half = libm::sin(core::f64::consts::PI * f * tick_dt);
    (q * q + 4.0 * r * half * half, -libm::expm1(-2.0 * s * tick_dt))
}
