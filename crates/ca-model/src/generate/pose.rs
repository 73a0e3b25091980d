//! Pose: placement of a body in space, and its initial motion.
//!
//! The rotation is a vector in turns, whose direction is the axis and whose length is the angle. A quarter turn is
//! `"25 %"`, whole quarters are exact, and angles need no unit. The order of Euler angles varies among programs. A spin
//! is such a vector per second, in Hz. A body turns and spins about its own origin.

use ca_core::internal::kind::builder::Args;
use ca_core::{Need, Param, Type, Unit};
use core::f64::consts::TAU;
use nalgebra::Vector3;

pub(super) const TURN: Param = Param::new(
    "turn",
    Type::Position { unit: Unit::NONE },
    Need::Optional,
    "orientation: turns about x, y and z as one rotation vector, e.g. [0, 0, \"25 %\"] for a quarter turn about z",
);
pub(super) const V: Param =
    Param::new("v", Type::Position { unit: Unit::SPEED }, Need::Optional, "initial velocity of all masses together");
pub(super) const SPIN: Param = Param::new(
    "spin",
    Type::Position { unit: Unit::HERTZ },
    Need::Optional,
    "initial spin: turns per second about x, y and z, e.g. [0, 0, \"2 Hz\"]",
);

pub(super) struct Pose {
    axis: Vector3<f64>,
    /// Sine and cosine of its angle.
    turn: (f64, f64),
    /// Velocity \[m/s\].
    v: Vector3<f64>,
    /// Angular velocity \[rad/s\].
    spin: Vector3<f64>,
}

impl Pose {
    /// Reads `turn`, `v` and `spin`; a parameter that the kind lacks is zero.
    pub fn new(a: &Args<'_>) -> Pose {
        let vector = |name: &str| Vector3::from_iterator(a.list(name, 3).into_iter().map(|v| v.unwrap_or(0.0)));
        let turn = vector("turn");
        let angle = libm::sqrt(turn.dot(&turn));
        let axis = if angle > 0.0 { turn / angle } else { turn };
        Pose { axis, turn: sin_cos(angle), v: vector("v"), spin: vector("spin") * TAU }
    }

    /// Returns the place of the point `p` of the body, from its origin \[m\].
    pub fn place(&self, p: [f64; 3]) -> [f64; 3] {
        let (p, (s, c)) = (Vector3::from(p), self.turn);
        (p * c + self.axis.cross(&p) * s + self.axis * (self.axis.dot(&p) * (1.0 - c))).into()
    }

    /// Returns the initial velocity \[m/s\] at the place `r`, from the origin of the body.
    pub fn speed(&self, r: [f64; 3]) -> [f64; 3] {
        (self.v + self.spin.cross(&Vector3::from(r))).into()
    }
}

/// Returns sine and cosine of `t` turns, exact for whole quarters.
fn sin_cos(t: f64) -> (f64, f64) {
    let quarters = libm::round(4.0 * t);
    let rest = TAU * (t - 0.25 * quarters);
    let (s, c) = (libm::sin(rest), libm::cos(rest));
    match libm::fmod(quarters, 4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}
