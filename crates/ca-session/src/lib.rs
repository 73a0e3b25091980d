//! One playing instrument, as a page and a program use it, without operating system, threads and transport.
//!
//! [`Session`] answers requests of pages and passes new versions of the model to the recorder. [`PageSink`] sends
//! pictures, sound and news. [`Midi`] plays MIDI, [`osc`] plays OSC packets, and [`answer`](fn@answer) serves `ca set`
//! and similar commands. [`Instrument`] combines them with an engine, for programs without threads. [`protocol`] has a
//! type for each message between the page of `ca play` and the program.
//!
//! Traits stand for everything else: pages ([`Pages`]), the language ([`Language`]), the compiler ([`VersionCompiler`]) and files
//! ([`Files`]). The caller gives the time.
#![forbid(unsafe_code)]

mod answer;
mod edit;
mod energy;
mod fingers;
mod greeting;
mod host;
mod instrument;
mod midi;
pub mod osc;
mod pages;
mod picture;
mod preset;
pub mod protocol;
mod refused;
mod session;

pub use answer::{Change, answer, value};
pub use greeting::greeting;
pub use host::{CompileState, CompiledVersion, Files, Language, NoFiles, VersionCompiler};
pub use instrument::Instrument;
pub use midi::Midi;
pub use pages::Pages;
pub use picture::PageSink;
pub use refused::Refused;
pub use session::{Parts, Session};
