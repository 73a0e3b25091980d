//! Requests to a running server and its replies, without the socket that carries them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A value as typed: a number in SI units, or text with a unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Given {
    /// A number in SI units.
    Number(f64),
    /// Text such as `8 kN/m`.
    Text(String),
}

/// A request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// Sets live parameters, all in one tick.
    Set {
        /// Values by name.
        values: BTreeMap<String, Given>,
    },
    /// Arms: forces begin once nothing pushes.
    Arm {
        /// One device; all if absent.
        device: Option<String>,
    },
    /// Disarms: forces off.
    Disarm {
        /// One device; all if absent.
        device: Option<String>,
    },
    /// Asks for the sound devices, or switches to another one.
    Audio {
        /// The device to switch to; `None` only asks.
        to: Option<String>,
    },
    /// Asks for the state of the performance.
    Status,
    /// Ends the performance.
    Stop,
}

/// The answer to a request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// True if the request was executed.
    pub ok: bool,
    /// Result or reason for refusal, for people.
    #[serde(default)]
    pub text: String,
    /// Result for programs.
    #[serde(default)]
    pub fields: Map<String, Value>,
}

impl Reply {
    /// Returns a reply for an executed request.
    pub fn done(text: impl Into<String>) -> Reply {
        Reply { ok: true, text: text.into(), fields: Map::new() }
    }
    /// Returns a reply for a refused request.
    pub fn refused(text: impl Into<String>) -> Reply {
        Reply { ok: false, text: text.into(), fields: Map::new() }
    }
}
