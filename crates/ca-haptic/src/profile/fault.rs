//! Contradictions in a profile, or in the description that a device gives.

use crate::frame::DOF;
use std::fmt;

/// Contradictions in a profile, or in the description that a device gives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ProfileFault {
    /// a number of this name is below 0
    Negative(&'static str, f64),
    /// a time of this name is shorter than the least \[s\]
    Short(&'static str, f64, f64),
    /// a number of this name is not above 0
    NotAbove(&'static str, f64),
    /// a number of this name is above the largest, which has this unit
    Large(&'static str, f64, f64, &'static str),
    /// this number of degrees of freedom is not possible
    Dof(u32),
    /// this number of axes does not divide this number of degrees of freedom
    Axes(u32, u32),
    /// the travel is not a range
    Range,
    /// the force is zero before it is no longer held
    Zero,
    /// the band of oscillations is not a range
    Band,
    /// this number of bad frames is not possible
    Bad(u32),
    /// the edges take all of the travel
    Edge,
    /// the device says that it has this number of degrees of freedom
    SaysDof(u32),
    /// the device says that this number of axes of this number of degrees of freedom make a force
    SaysAxes(u32, u32),
}

impl fmt::Display for ProfileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use ProfileFault as P;
        match self {
            P::Negative(name, v) => write!(f, "`{name}` must not be negative, it is {v}"),
            P::Short(name, least, v) => write!(f, "`{name}` is at least {least} s, it is {v}: less is a jump"),
            P::NotAbove(name, v) => write!(f, "`{name}` must be more than 0, it is {v}"),
            P::Large(name, most, v, unit) => {
                write!(f, "`{name}` is at most {most} {unit}, it is {v}: more would leave a hand without this limit")
            }
            P::Dof(n) => write!(f, "`dof` lies between 1 and {DOF}, it is {n}"),
            P::Axes(axes, dof) => write!(f, "`axes` is 1, 2 or 3 and divides `dof` = {dof}, it is {axes}"),
            P::Range => f.write_str("`range` = [least, largest] in metres"),
            P::Zero => f.write_str("`guard.zero` must be later than `guard.hold`"),
            P::Band => {
                f.write_str("`guard.oscillation_band` = [lowest, highest] in hertz, more than 0; `inf` for all above")
            }
            P::Bad(n) => write!(f, "`guard.bad` lies between 1 and 64, it is {n}"),
            P::Edge => f.write_str("`guard.edge` is less than half of the travel"),
            P::SaysDof(n) => write!(f, "it says that it has {n} degrees of freedom; 1 to {DOF} are possible"),
            P::SaysAxes(axes, n) => {
                write!(f, "it says that {axes} axes of its {n} make a force; 1, 2 or 3 that divide {n} are possible")
            }
        }
    }
}

impl std::error::Error for ProfileFault {}

/// An answer to a request is a text.
impl From<ProfileFault> for String {
    fn from(why: ProfileFault) -> String {
        why.to_string()
    }
}
