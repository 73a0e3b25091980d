//! Tests the haptic loop as users run it: the built command as server and as device in separate processes, and a third
//! process that watches every force on the line. A slow machine never causes a failure: tests wait for conditions and
//! count time in frames.
#![cfg(target_os = "linux")]

mod fuzz;
mod in_real_time;
mod liar;
#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
mod raw;
mod role;
mod sandbox;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod watch;
