//! The loop through the hand as people run it: the built command as server and as device, each a process of its own,
//! and a third that watches every force on the line. What is late is never wrong here: conditions are
//! waited for, times are counted in frames.
#![cfg(target_os = "linux")]

mod fuzz;
mod in_real_time;
mod liar;
#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
mod raw;
mod role;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod stage;
mod watch;
