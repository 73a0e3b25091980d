//! Tests of devices and servers in real time: faults, limits, sound servers, conformance, instruments.
//!
//! `tests/run` selects these tests by the name of this module. They mostly wait, so they run in parallel with all
//! others.

mod calibrate_dialogue;
mod conformance;
mod device_commands;
mod faults;
mod instruments;
mod limits;
mod no_device;
mod other_user;
mod piano;
mod request_flood;
mod self_description;
mod soak;
mod sound;
mod stopped_processes;
mod theory;
