//! A model played in real time: its engine, sound, MIDI, OSC, page, devices and files, as `ca serve`, `ca play` and Python use it.
//!
//! [`play`] runs a whole performance on the calling thread: a [`Request`] says what is played and by what, a [`Listener`] gets
//! the messages, and the result is a [`Report`]. Nothing is printed here, and nothing ends the process.
//!
//! The engine thread computes, the gateway thread moves frames between shared memory and rings, and threads of files write. The
//! calling thread does everything else that may take time. A model with devices alone gets a gateway and
//! shared memory; a model with live parameters, or a page, gets a control.
#![forbid(unsafe_code)]

mod compiler;
mod connections;
mod inputs;
mod language;
mod output;
mod page;
mod performance;
mod report;
mod request;
mod setup;
mod sound;

pub use language::ModelLanguage;
pub use output::check_wav_path;
pub use performance::play;
pub use report::{Report, Traffic};
pub use request::{
    Asked, DeviceOptions, FileOptions, InputOptions, Listener, ModelSource, Pace, PageOptions, Reader, Request,
    SoundOptions, ThreadOptions,
};
