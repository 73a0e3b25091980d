//! Plays a model in real time with its engine, sound, MIDI, OSC, page, devices and files. Used by `ca serve`, `ca play`
//! and Python.
//!
//! [`play`] runs a whole performance on the calling thread. A [`Request`] describes the performance, a [`Listener`]
//! receives the messages, and the result is a [`Report`]. This crate prints nothing and never ends the process.
//!
//! The engine thread computes, the gateway thread moves frames between shared memory and rings, and file threads write.
//! The calling thread does everything else that may block. Only a model with devices gets a gateway and shared memory.
//! Only a model with devices or live parameters, or a page, gets a control.
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
mod text;

pub use language::ModelLanguage;
pub use output::check_wav_path;
pub use performance::play;
pub use report::{Report, Traffic};
pub use request::{
    ControlRequest, DeviceOptions, FileOptions, InputOptions, Listener, ModelSource, OneFile, Pace, PageOptions,
    Reader, Request, SoundOptions, ThreadOptions,
};
