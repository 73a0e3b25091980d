//! Why a request is refused.

use ca_haptic::serve;
use ca_haptic::serve::audio::NoChoice;
use std::fmt;

/// Why a request is refused; nothing has changed then.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refused {
    /// the engine does not take the order
    Engine(serve::Refused),
    /// outputs cannot be chosen
    Output(NoChoice),
    /// the request does not fit, comes at the wrong time, or the host cannot do it; in words
    Text(String),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Engine(why) => why.fmt(f),
            Refused::Output(why) => why.fmt(f),
            Refused::Text(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for Refused {}

impl From<serve::Refused> for Refused {
    fn from(why: serve::Refused) -> Refused {
        Refused::Engine(why)
    }
}

impl From<NoChoice> for Refused {
    fn from(why: NoChoice) -> Refused {
        Refused::Output(why)
    }
}

impl From<&'static str> for Refused {
    fn from(text: &'static str) -> Refused {
        Refused::Text(text.into())
    }
}

impl From<String> for Refused {
    fn from(text: String) -> Refused {
        Refused::Text(text)
    }
}

/// An answer to a request is a text.
impl From<Refused> for String {
    fn from(why: Refused) -> String {
        why.to_string()
    }
}
