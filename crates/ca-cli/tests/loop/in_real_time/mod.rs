//! Tests of devices and servers in real time: faults, limits, sound servers, conformance, instruments.
//!
//! `tests/run` selects these tests by the name of this module. They mostly wait, so they run in parallel with all
//! others.

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
