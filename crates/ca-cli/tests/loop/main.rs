//! The loop through the hand as people run it: the built command as server and as device, each a process of its own,
//! and a third that watches every force on the line. What is late is never wrong here: conditions are
//! waited for, times are counted in frames.
//!
//! What is tested is in one module, by the name of which `tests/run` tells these tests from all others: they wait most of
//! their time, and run while the others do.
#![cfg(target_os = "linux")]

mod fuzz;
mod liar;
#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
mod raw;
mod role;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod stage;
mod watch;

#[path = "."]
mod in_real_time {
    mod audio;
    mod conform;
    mod described;
    mod dialogue;
    mod faults;
    mod flood;
    mod instruments;
    mod limits;
    mod other;
    mod piano;
    mod pulse;
    mod quiet;
    mod soak;
    mod stopped;
    mod theory;
    mod verbs;
}
