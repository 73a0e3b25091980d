//! `ca device`: simulates, tests and calibrates device processes, using [`ca_device_tools`].

mod args;
mod calibrate;
mod conformance;
mod doctor;
mod list;
mod sim;

pub use args::{CalibrateArgs, ConformanceArgs, DeviceArgs, DeviceCommand, ScriptKind, SimArgs};

use crate::outcome::Outcome;

/// Runs the command.
pub fn run(args: &DeviceArgs) -> Outcome {
    match &args.what {
        DeviceCommand::Sim(a) => sim::run(a),
        DeviceCommand::List { json } => list::run(*json),
        DeviceCommand::Doctor { json } => doctor::run(*json),
        DeviceCommand::Calibrate(a) => calibrate::run(a),
        DeviceCommand::Conformance(a) => conformance::run(a),
    }
}
