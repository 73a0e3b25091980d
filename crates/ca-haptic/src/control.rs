//! Requests to a running server and its replies, without the socket that carries them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A value as it was typed: a number in SI units, or a text with its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Given {
    /// in the model's units
    Number(f64),
    /// `8 kN/m`
    Text(String),
}

/// A request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// new values of live parameters, all in one tick
    Set {
        /// by name
        values: BTreeMap<String, Given>,
    },
    /// forces on, once nothing pushes
    Arm {
        /// one device; all if absent
        device: Option<String>,
    },
    /// forces off
    Disarm {
        /// one device; all if absent
        device: Option<String>,
    },
    /// what plays the sound, and what may
    Audio {
        /// another one; none to ask
        to: Option<String>,
    },
    /// how it goes
    Status,
    /// the end
    Stop,
}

/// The answer to a request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// whether it was done
    pub ok: bool,
    /// for people: what was done, or why not
    #[serde(default)]
    pub text: String,
    /// for programs
    #[serde(default)]
    pub fields: Map<String, Value>,
}

impl Reply {
    /// It was done.
    pub fn done(text: impl Into<String>) -> Reply {
        Reply { ok: true, text: text.into(), fields: Map::new() }
    }
    /// It was not.
    pub fn refused(text: impl Into<String>) -> Reply {
        Reply { ok: false, text: text.into(), fields: Map::new() }
    }
}
