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

    /// Sound is sent to this page, or no longer. The server of the page answers it.
    "sound" Sound {
        /// `true` to be sent sound
        on: bool,
    }
    /// Holds a mass where it is. One page at a time holds a mass.
    "grab" Grab {
        /// number of the mass in the drawing
        mass: Option<u64>,
    }
    /// Pulls the mass that this page holds.
    "drag" Drag {
        /// the place, from where the mass rests \[m\]: `[u]`, or `[x, y, z]` in space
        by: Option<Vec<f64>>,
    }
    /// Lets go of the mass that this page holds.
    "release" Release
    /// Begins the model's own gesture from its start, or ends it.
    "gesture" Gesture {
        /// `true` to begin
        play: bool,
    }
    /// Sends a port to a position or a force, in 17 ms.
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
    /// Changes a number of the model that is not live, as by `--set`. The model is compiled again and plays on.
    "change" Change {
        /// name of the number, such as `string.t60`
        name: String,
        /// its value as text, with a unit where it needs one
        value: String,
    }
    /// Begins again as at load, with the numbers as they are.
    "restart" Restart
    /// As `restart`; then the model's own gesture plays, if there is one.
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
    /// Chooses what plays the sound.
    "audio" Audio {
        /// one of the `choices` of `state`
        device: String,
    }
    /// Records sound into a WAV file from now on, or ends that.
    "record" Record {
        /// `true` to begin
        on: bool,
    }
    /// Saves everything that was done since the start as a take.
    "save" Save
    /// Says which mass this is.
    "pick" Pick {
        /// number of the mass in the drawing
        mass: Option<u64>,
    }
    /// Forces of all devices on, where the command line allows it, or off.
    "arm" Arm {
        /// `true` for on
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
        let request = serde_json::from_value(object).map_err(|_| format!("`{kind}` is nothing a page can ask").into());
        NumberedRequest { id, request }
    }
}

/// The value of a field; the default of its type where the page sent something else.
fn lenient<'de, D: Deserializer<'de>, T: DeserializeOwned + Default>(from: D) -> Result<T, D::Error> {
    Ok(serde_json::from_value(Value::deserialize(from)?).unwrap_or_default())
}
