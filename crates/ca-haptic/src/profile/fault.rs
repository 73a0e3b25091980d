//! Contradictions in a profile, or in the description that a device gives.

use crate::frame::DOF;
use std::fmt;

/// Contradictions in a profile, or in the description that a device gives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ProfileFault {
    /// The named number is below 0.
    Negative(&'static str, f64),
    /// The named time is shorter than this limit \[s\].
    Short(&'static str, f64, f64),
    /// The named number is not above 0.
    NotAbove(&'static str, f64),
    /// The named number is above this limit, which has this unit.
    Large(&'static str, f64, f64, &'static str),
    /// The number of degrees of freedom is out of range.
    Dof(u32),
    /// The number of axes is out of range or does not divide the number of degrees of freedom.
    Axes(u32, u32),
    /// The travel is not a range.
    Range,
    /// The force reaches zero before the end of its hold.
    Zero,
    /// The band of oscillations is not a range.
    Band,
    /// The number of bad frames is out of range.
    Bad(u32),
    /// The edges take up the whole travel.
    Edge,
    /// The device reports this number of degrees of freedom.
    SaysDof(u32),
    /// The device reports force vectors of this number of axes, with this number of degrees of freedom.
    SaysAxes(u32, u32),
}

impl fmt::Display for ProfileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use ProfileFault as P;
        match self {
            P::Negative(name, v) => write!(f, "`{name}` is {v}; it must not be negative"),
            P::Short(name, least, v) => {
                write!(f, "`{name}` is {v} s; it must be at least {least} s, because less is a jump")
            }
            P::NotAbove(name, v) => write!(f, "`{name}` is {v}; it must be more than 0"),
            P::Large(name, most, v, unit) => {
                write!(f, "`{name}` is {v}; it must be at most {most} {unit}, because more would not protect a hand")
            }
            P::Dof(n) => write!(f, "`dof` is {n}; it must be from 1 to {DOF}"),
            P::Axes(axes, dof) => write!(f, "`axes` is {axes}; it must be 1, 2 or 3 and divide `dof` = {dof}"),
            P::Range => f.write_str("`range` must be [least, largest] in metres"),
            P::Zero => f.write_str("`guard.zero` must be later than `guard.hold`"),
            P::Band => f.write_str(
                "`guard.oscillation_band` must be [lowest, highest] in hertz, more than 0; the highest may be `inf`",
            ),
            P::Bad(n) => write!(f, "`guard.bad` is {n}; it must be from 1 to 64"),
            P::Edge => f.write_str("`guard.edge` must be less than half of the travel"),
            P::SaysDof(n) => write!(f, "the device reports {n} degrees of freedom; it must have 1 to {DOF}"),
            P::SaysAxes(axes, n) => {
                write!(
                    f,
                    "the device reports {axes} axes per force vector; it must have 1, 2 or 3, and they must divide its {n} \
                     degrees of freedom"
                )
            }
        }
    }
}

impl std::error::Error for ProfileFault {}

/// Requests are answered in text.
impl From<ProfileFault> for String {
    fn from(why: ProfileFault) -> String {
        why.to_string()
    }
}
