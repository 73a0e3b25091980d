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

/// Requests are answered in text.
impl From<ProfileFault> for String {
    fn from(why: ProfileFault) -> String {
        why.to_string()
    }
}
