//! The loop through the hand as people run it: the built command as server and as device, each a process of its own,
//! and this one as a third that watches every force on the line. What is late is never wrong here: conditions are
//! waited for, times are counted in frames.
#![cfg(target_os = "linux")]

#[cfg(feature = "audio")]
mod audio;
mod conform;
mod faults;
mod liar;
mod quiet;
mod raw;
mod soak;
mod stage;
mod stopped;
mod theory;
mod verbs;
mod watch;
