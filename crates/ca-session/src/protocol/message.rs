//! Messages of the program to a page.

use super::define::{messages, record};
use super::js::Js;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

messages! {
    /// A message to the page.
    Message, (), js;

    /// The scene that plays. The first message, and sent again with each new version of the model.
    "scene" Scene {
        /// version of the model that plays, from 1
        generation: u32,
        /// title of the model
        title: String,
        /// name of the model
        model: String,
        /// ticks a second \[Hz\]
        rate: f64,
        /// ticks of a gesture frame
        frame: u32,
        /// names of the outputs
        channels: Vec<String>,
        /// drawing of the scene, as `ca-view` writes it
        drawing: Value,
        /// live parameters
        params: Vec<Param>,
        /// ports of position and force, and keys of devices
        ports: Vec<PortInfo>,
        /// whether the model has a gesture
        gesture: bool,
        /// presets of the model; `set` with the name `preset` and the name of a preset chooses it
        presets: Vec<Preset>,
        /// MIDI keys that play, lowest first; `null` without any
        notes: Option<Vec<u8>>,
        /// duration given in the model \[s\]
        seconds: Option<f64>,
        /// names of the parts whose kinetic energy the message `energy` has
        energy: Vec<String>,
        /// proven stability, in words
        stability: String,
    }
    /// The present state, four times per second.
    "state" State {
        /// sound sample computed last
        tick: u64,
        /// time of that sample \[s\]
        seconds: f64,
        /// computing time as a share of real time; `null` in the first second
        load: Option<f64>,
        /// missed periods
        late: u64,
        /// records, samples, pictures, forces and times lost
        lost: u64,
        /// samples at the peak limit
        clipped: u64,
        /// whether the model diverged: its values are out of range
        diverged: bool,
        /// whether the gesture of the model plays
        playing: bool,
        /// the first of `held`; −1 without one
        pointer: i64,
        /// numbers of the masses that fingers hold, in the drawing
        held: Vec<u64>,
        /// devices
        devices: Vec<DeviceState>,
        /// values of the live parameters, by name (SI)
        params: BTreeMap<String, f64>,
        /// number of open pages
        clients: u64,
        /// the parameter that the next MIDI controller is bound to
        learning: Option<String>,
        /// MIDI controllers that are bound to parameters
        bound: Vec<Bound>,
        /// sound output: `page`, or the name of a sound server or device
        sound: String,
        /// the outputs of the sound
        outputs: Choices,
        /// latency from the model to the ear, if a sound output other than the page plays \[ms\]
        latency: Option<f64>,
        /// number of times the sound device ran out of samples; `null` in the first second
        underruns: Option<u64>,
        /// whether a page may arm forces
        arms: bool,
        /// whether a take can be saved
        keeps: bool,
        /// the file to which sound is recorded
        recording: Option<String>,
    }
    /// Kinetic energy, about twenty times per second.
    "energy" Energy {
        /// time of the model \[s\]
        seconds: f64,
        /// energy of each part \[J\], in the order of `energy` of `scene`
        motion: Vec<f64>,
    }
    /// A message for the user.
    "said" Said {
        /// whether something went wrong
        bad: bool,
        /// the message
        text: String,
    }
    /// A new version of the model was compiled, or has errors.
    "report" Report {
        /// whether it plays
        ok: bool,
        /// its warnings, or why it does not play
        text: String,
    }
    /// The answer to a request with an `id`, and to each request that is refused.
    "reply" Reply {
        /// `id` of the request; `null` without one
        id: Value,
        /// whether it was done
        ok: bool,
        /// what was done, or why not
        text: String,
        /// what `pick` found
        [(flatten)] picked: Option<Picked>,
    }
}

record! {
    /// A live parameter.
    Param {
        /// its name
        name: String,
        /// its value at load (SI)
        value: f64,
        /// its minimum (SI); `null` without a bound
        min: Option<f64>,
        /// its maximum (SI); `null` without a bound
        max: Option<f64>,
        /// its unit; empty for a plain number
        unit: String,
        /// its description
        doc: String,
    }
}

record! {
    /// A preset of the model.
    Preset {
        /// its name
        name: String,
        /// values of live parameters, by name (SI)
        values: BTreeMap<String, f64>,
    }
}

record! {
    /// A port.
    PortInfo {
        /// its name
        name: String,
        /// quantity that it receives
        role: PortRole,
        /// number of the mass that it moves, in the drawing
        mass: Option<u64>,
        /// its rest position \[m\]
        rest: f64,
    }
}

record! {
    /// A device.
    DeviceState {
        /// its name
        name: String,
        /// mode of its forces
        mode: String,
        /// cause of that mode
        cause: String,
    }
}

record! {
    /// A MIDI controller that is bound to a live parameter.
    Bound {
        /// MIDI channel, from 1
        channel: u8,
        /// number of the controller
        number: u8,
        /// name of the parameter
        name: String,
    }
}

record! {
    /// The sound outputs from which a page can choose.
    Choices {
        /// names of the outputs; empty if there is no choice
        choices: Vec<String>,
        /// name of the requested output
        wanted: String,
        /// whether the requested output is being opened
        busy: bool,
    }
}

record! {
    /// The mass that `pick` found.
    Picked {
        /// its number in the drawing
        mass: u64,
        /// its name in the model
        name: String,
        /// code of its kind
        kind: String,
    }
}

/// The quantity that a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PortRole {
    /// a position
    Position,
    /// a force
    Force,
    /// the position of a device
    Device,
}

impl Js for PortRole {
    fn js() -> String {
        r#""position"|"force"|"device""#.into()
    }
}

impl Message {
    /// The text that goes over the wire, with the fields of each object in alphabetical order.
    pub fn text(&self) -> String {
        serde_json::to_value(self).unwrap_or_default().to_string()
    }
}
