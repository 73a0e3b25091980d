//! Requests of a page to the program.

use super::define::messages;
use crate::refused::Refused;
use ca_haptic::control::Given;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use std::collections::BTreeMap;

messages! {
    /// A request of the page. A field that was left out, or has another type, is `None`, `false` or empty: the program
    /// then refuses the request and names the field.
    Request, (default, deserialize_with = "lenient"), sent;

    /// Starts or stops the sound for this page. The server of the page handles it.
    "sound" Sound {
        /// `true` to receive sound
        on: bool,
    }
    /// Holds a mass where it is, with a finger. All pages together have ten fingers, and each mass has at most one.
    "grab" Grab {
        /// number of the mass in the drawing
        mass: Option<u64>,
        /// number of the finger on this page; 0 if it is left out
        finger: Option<u8>,
    }
    /// Pulls the mass that a finger of this page holds.
    "drag" Drag {
        /// number of the finger on this page; 0 if it is left out
        finger: Option<u8>,
        /// displacement from rest \[m\]: `[u]`, or `[x, y, z]` in space
        by: Option<Vec<f64>>,
    }
    /// Releases the mass that a finger of this page holds.
    "release" Release {
        /// number of the finger on this page; all fingers if it is left out
        finger: Option<u8>,
    }
    /// Starts the gesture of the model from its beginning, or stops it.
    "gesture" Gesture {
        /// `true` to start
        play: bool,
    }
    /// Moves a port to a position or a force, in 17 ms.
    "port" Port {
        /// name of the port
        name: Option<String>,
        /// the position \[m\] or force \[N\]
        value: Option<f64>,
    }
    /// Sets live parameters, all in one tick.
    "set" Set {
        /// by name: a number in SI units, or a text with a unit
        values: Option<BTreeMap<String, Given>>,
    }
    /// Changes a value of the model that is not live, as `--set` does. The model is compiled again and keeps playing.
    "change" Change {
        /// name of the value, such as `string.t60`
        name: String,
        /// the new value as text, with a unit if it needs one
        value: String,
    }
    /// Restarts from the state at load, with the present values.
    "restart" Restart
    /// As `restart`, then plays the gesture of the model, if there is one.
    "play" Play
    /// Plays MIDI events.
    "midi" Midi {
        /// whole events, at most 96 bytes
        bytes: Option<Vec<u8>>,
    }
    /// Binds the MIDI controller that moves next to a live parameter.
    "learn" Learn {
        /// name of the parameter; `null` to bind none
        name: Option<Option<String>>,
    }
    /// Chooses the sound output.
    "audio" Audio {
        /// one of the `choices` of `state`
        device: String,
    }
    /// Starts or stops recording sound to a WAV file.
    "record" Record {
        /// `true` to start
        on: bool,
    }
    /// Saves everything done since the start as a take.
    "save" Save
    /// Stores the model as it is now, with all its changed values. The server then has its text at `model.ca.toml`. A
    /// model that takes parts or points from other files is refused.
    "snapshot" Snapshot
    /// Returns the name and kind of a mass.
    "pick" Pick {
        /// number of the mass in the drawing
        mass: Option<u64>,
    }
    /// Arms the forces of all devices, if the command line allows it, or turns them off.
    "arm" Arm {
        /// `true` to arm
        on: bool,
    }
    /// Ends the program.
    "stop" Stop
}

/// A request as it came: with the number under which the page waits for its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberedRequest {
    /// `id` of the object, where it has one
    pub id: Option<Value>,
    /// the request, or why there is none
    pub request: Result<Request, Refused>,
}

impl NumberedRequest {
    /// Reads an object that came from a page.
    pub fn read(object: Value) -> NumberedRequest {
        let id = object.get("id").cloned();
        let kind = object["type"].as_str().unwrap_or_default().to_owned();
        let request = serde_json::from_value(object)
            .map_err(|_| format!("`{kind}` is not a request that a page can send").into());
        NumberedRequest { id, request }
    }
}

/// The value of a field; the default of its type where the page sent something else.
fn lenient<'de, D: Deserializer<'de>, T: DeserializeOwned + Default>(from: D) -> Result<T, D::Error> {
    Ok(serde_json::from_value(Value::deserialize(from)?).unwrap_or_default())
}
