//! Devices and servers in real time: faults, limits, sound servers, conformance, instruments.
//!
//! `tests/run` tells these tests from all others by the name of this module: they wait most of their time, and run while the
//! others do.

mod conform;
mod described;
mod dialogue;
mod faults;
mod flood;
mod instruments;
mod limits;
mod other;
mod piano;
mod quiet;
mod soak;
mod sound;
mod stopped;
mod theory;
mod verbs;
