//! The error of a command to the engine.

use super::manual::FURTHEST;
use crate::engine::FixedPart;
use ca_core::pointer;
use std::fmt;

/// The reason why a command to the engine was refused; it has changed nothing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refused {
    /// Another version of the model is on its way: a command for one scene is not valid for the next.
    Swapping,
    /// The ring of commands to the engine is full.
    Busy,
    /// A live parameter does not accept this value.
    Param(ca_core::Refused),
    /// No device has this name; the existing names.
    Device(String, Vec<String>),
    /// The mass cannot be held.
    Mass(pointer::Refused),
    /// The position to which a mass is pulled is not finite.
    Place,
    /// The model lacks a gesture.
    NoGesture,
    /// No port has this name; the existing names.
    Port(String, Vec<String>),
    /// A device moves this port: names of the port and of the device.
    OfDevice(String, String),
    /// The value of this port is not finite, or its time is not a number.
    Value(String),
    /// The value of this port is too large.
    Far(String),
    /// The new version is too large for the allocated rings.
    Large,
    /// The new version differs in a part that cannot change while it plays.
    Fixed(FixedPart),
}

fn listed(names: &[String]) -> String {
    let all: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
    all.join(", ")
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Swapping => f.write_str("another version of the model is being loaded; try again"),
            Refused::Busy => f.write_str("the command queue of the engine is full; try again"),
            Refused::Param(why) => why.fmt(f),
            Refused::Device(name, there) if there.is_empty() => {
                write!(f, "no device `{name}`: the model does not use devices")
            }
            Refused::Device(name, there) => write!(f, "no device `{name}`; choose from {}", listed(there)),
            Refused::Mass(why) => why.fmt(f),
            Refused::Place => f.write_str("the position of a mass must be a finite number [m]"),
            Refused::NoGesture => f.write_str("the model does not have a gesture; add a `[gesture]`"),
            Refused::Port(name, there) if there.is_empty() => {
                write!(f, "no port `{name}`: the model does not have ports")
            }
            Refused::Port(name, there) => write!(f, "no port `{name}`; choose from {}", listed(there)),
            Refused::OfDevice(port, device) => write!(f, "`{port}` is moved by its device, `{device}`"),
            Refused::Value(port) => write!(f, "`{port}` needs a finite value [m or N] and a time [s]"),
            Refused::Far(port) => write!(f, "the absolute value of `{port}` must be at most {FURTHEST:e} [m or N]"),
            Refused::Large => f.write_str(
                "the new version is too large to replace the model while it plays; stop it and start it again",
            ),
            Refused::Fixed(part) => part.fmt(f),
        }
    }
}

impl std::error::Error for Refused {}

impl From<ca_core::Refused> for Refused {
    fn from(why: ca_core::Refused) -> Refused {
        Refused::Param(why)
    }
}

impl From<pointer::Refused> for Refused {
    fn from(why: pointer::Refused) -> Refused {
        Refused::Mass(why)
    }
}

impl From<FixedPart> for Refused {
    fn from(part: FixedPart) -> Refused {
        Refused::Fixed(part)
    }
}

/// Converts to the text of a reply.
impl From<Refused> for String {
    fn from(why: Refused) -> String {
        why.to_string()
    }
}
