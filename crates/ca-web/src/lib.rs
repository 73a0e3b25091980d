//! The engine and the compiler for browsers and Node, as two WebAssembly modules.
//!
//! [`compiler`] makes a plan from the text of a model: a compiled scene as bytes. It runs in a worker. [`engine`] plays a
//! plan as a [`ca_session::Instrument`]. It runs in an audio worklet, which loads only this module. Both are plain Rust,
//! so the tests run them natively too.
//!
//! The features `engine` and `compiler` choose what the WebAssembly module exports (`exports.rs`): functions over numbers
//! only, without generated code in JavaScript. `tools/site` builds both modules.

pub mod compiler;
pub mod engine;
#[cfg(any(feature = "engine", feature = "compiler"))]
mod exports;
mod outbox;

pub use outbox::Outbox;
