//! Tests the haptic loop as users run it: the built command as server and as device in separate processes, and a third
//! process that watches every force on the line. A slow machine never causes a failure: tests wait for conditions and
//! count time in frames.
#![cfg(target_os = "linux")]

mod faulty_device;
mod force_watcher;
mod helper_process;
mod iceoryx_client;
mod in_real_time;
#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
mod random_device;
mod sandbox;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
