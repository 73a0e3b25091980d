//! Refusals of requests.

use ca_haptic::serve;
use ca_haptic::serve::audio::NoChoice;
use std::fmt;

/// Reason why a request is refused; nothing has changed then.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refused {
    /// The engine does not accept the order.
    Engine(serve::Refused),
    /// Outputs cannot be chosen.
    Output(NoChoice),
    /// The request does not fit, comes at the wrong time, or the host cannot carry it out; in words.
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

impl From<Refused> for String {
    fn from(why: Refused) -> String {
        why.to_string()
    }
}
