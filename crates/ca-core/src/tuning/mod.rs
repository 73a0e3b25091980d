//! Tuning: with which stiffness and viscosity a method sounds at a given pitch and decays in a given time.
//!
//! A mode has the dimensionless stiffness a = T²k/m and viscosity b = Tz/m. Its pole r e^(iφ), φ = 2πfT, r = 10^(−3T/t60),
//! is that of
//! - the explicit scheme where a = 1 + r² − 2r cos φ and b = 1 − r² (docs/numerics.md §1.5, [`retune`]);
//! - the implicit one of share θ, (1 + b/2 + θa) w² − (2 − a(1 − 2θ)) w + (1 − b/2 + θa) = 0, where with
//!   D = 1/((1 + r²)/2 − θ(1 + r² − 2r cos φ)) a = D(1 + r² − 2r cos φ) and b = D(1 − r²), so that `centred` is θ = 0;
//! - the mode itself where a = φ² + s² and b = 2s, s = −ln r.
//!
//! Decides that a pitch is what is heard whatever the method, so that changing the method of a model does not put it out
//! of tune. The alternative, stiffness by the explicit scheme and whatever pitch another one makes of it, is 15 cents off
//! at 440 Hz and 48 kHz.

pub(crate) mod problem;
pub mod wave;

use core::f64::consts::{LN_10, PI};

crate::choice::choice! {
    /// How what is linear is computed. A link or a cell knows the first three, a group `modal` too, the model all.
    pub enum Method {
        /// explicit, as in the field
        Ca = "ca",
        /// viscosity from before and after the tick
        Centred = "centred",
        /// stiffness too, by a share θ
        Implicit = "implicit",
        /// by its modes
        Modal = "modal",
        /// everything, by [`crate::method::pefrl`]
        Pefrl = "pefrl",
    }
}

impl Method {
    /// Of a link or a cell.
    pub(crate) const OF_LINK: &'static [&'static str] = Method::WORDS.split_at(3).0;
    /// Of a group.
    pub const OF_GROUP: &'static [&'static str] = Method::WORDS.split_at(4).0;

    /// The share of the force from before and after that it takes, each; `None` for what is not implicit.
    pub fn theta(self, written: Option<f64>) -> Option<f64> {
        match self {
            Method::Centred => Some(0.0),
            Method::Implicit => Some(written.unwrap_or(0.5)),
            Method::Ca | Method::Modal | Method::Pefrl => None,
        }
    }
}

/// How the linear part of an item is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Scheme {
    /// by the explicit scheme
    #[default]
    Explicit,
    /// by this share of the force from the tick before and the tick after, each; 0 is `centred`
    Implicit(f64),
    /// by its modes, without an error in time
    Modal,
}

impl Scheme {
    /// That of a medium, by its method and its `theta`.
    pub fn of(method: Method, written: Option<f64>) -> Scheme {
        match method.theta(written) {
            Some(theta) => Scheme::Implicit(theta),
            None if method == Method::Modal => Scheme::Modal,
            None => Scheme::Explicit,
        }
    }

    /// The viscosity b with which modes fall by 60 dB in `t60` \[s\]: all of them, but by a share θ above 0 those whose
    /// period is long beside a tick; [`Scheme::tuned`] takes the pitch into account.
    pub fn damped(self, t60: f64, tick_dt: f64) -> f64 {
        let s = 3.0 * LN_10 / t60 * tick_dt;
        match self {
            Scheme::Explicit => retune(0.0, t60, tick_dt).1,
            // 2 (1 − r²)/(1 + r²)
            Scheme::Implicit(_) => 2.0 * libm::tanh(s),
            Scheme::Modal => 2.0 * s,
        }
    }

    /// Stiffness a and viscosity b of a mode heard at `f` \[Hz\] that falls by 60 dB in `t60` \[s\]; `None` where this
    /// scheme has no such pole.
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

    /// Stiffness a of a mode heard at `f` \[Hz\] whose viscosity b is given; `None` where this scheme has no such pole.
    pub fn stiffness(self, f: f64, b: f64, tick_dt: f64) -> Option<f64> {
        let phi = 2.0 * PI * f * tick_dt;
        match self {
            Scheme::Explicit => {
                let r = libm::sqrt((1.0 - b).max(0.0));
                let half = libm::sin(PI * f * tick_dt);
                Some((1.0 - r) * (1.0 - r) + 4.0 * r * half * half)
            }
            Scheme::Implicit(theta) => {
                // r² = 1 − b/D, and D hangs on r a little
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

    /// Largest stiffness a of a mode that is stable, over that of the explicit scheme.
    pub fn room(self) -> f64 {
        match self {
            Scheme::Explicit => 1.0,
            Scheme::Implicit(theta) if theta < 0.25 => 1.0 / (1.0 - 4.0 * theta),
            Scheme::Implicit(_) | Scheme::Modal => f64::INFINITY,
        }
    }
}

/// 1 + r² − 2r cos φ, written so that nothing cancels; `loss` is 1 − r.
fn bend(r: f64, loss: f64, phi: f64) -> f64 {
    let half = libm::sin(0.5 * phi);
    loss * loss + 4.0 * r * half * half
}

/// The dimensionless stiffness a = kT²/m and viscosity b = zT/m with which the scheme oscillates at exactly `f` \[Hz\]
/// and loses 60 dB in exactly `t60` \[s\] (docs/numerics.md §1.5). `t60` may be infinite. Written so that nothing
/// cancels at low frequency, where 1 − 2r cos θ + r² loses five digits.
pub fn retune(f: f64, t60: f64, tick_dt: f64) -> (f64, f64) {
    let s = 3.0 * core::f64::consts::LN_10 / t60;
    let q = -libm::expm1(-s * tick_dt);
    let r = 1.0 - q;
    let half = libm::sin(core::f64::consts::PI * f * tick_dt);
    (q * q + 4.0 * r * half * half, -libm::expm1(-2.0 * s * tick_dt))
}
