//! The engine and the compiler for browsers and Node, as WebAssembly modules.
//!
//! [`compiler`] makes a plan from the text of a model: a compiled scene as bytes. It runs in a worker. [`engine`] plays a
//! plan as a [`ca_session::Instrument`]. It runs in an audio worklet, which loads only this module. [`accuracy`] measures
//! error against run time, in a third module, which a page loads for its first measurement. All are plain Rust, so the
//! tests run them natively too.
//!
//! The features `engine`, `compiler` and `accuracy` choose what the WebAssembly module exports (`exports.rs`): functions
//! over numbers only, without generated code in JavaScript. `tools/site` builds all modules.

pub mod accuracy;
pub mod compiler;
pub mod engine;
#[cfg(any(feature = "engine", feature = "compiler", feature = "accuracy"))]
mod exports;
mod outbox;

pub use outbox::Outbox;
