//! The loop through the hand as people run it: the built command as server and as device, each a process of its own,
//! and a third that watches every force on the line. What is late is never wrong here: conditions are
//! waited for, times are counted in frames.
#![cfg(target_os = "linux")]

#[cfg(feature = "audio")]
mod audio;
mod conform;
mod described;
mod dialogue;
mod faults;
mod fuzz;
mod liar;
mod limits;
mod other;
mod piano;
mod quiet;
mod raw;
mod role;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod soak;
mod stage;
mod stopped;
mod theory;
mod verbs;
mod watch;
