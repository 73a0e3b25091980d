//! The scene compiler: from what the author wrote to what runs, leaving out what the scene does not need.
//!
//! ```text
//! Model ─ lower ─ Resolved ─ connect ─ Wired ─ passes ─ Pruned ─ certify ─ emit ─ Scene
//!         units, ranges,     ends of links,    methods,          bounds on stability;
//!         parameters         taps of outputs   cheaper laws      order, arrays, passes
//! ```
//!
//! Decides on one network of plain records between model and scene: every pass reads and rewrites that, and all of them
//! push findings into one list, so an author sees everything at once. The folders are in the order of work, and each
//! knows those before it and the network, never those behind it.
//!
//! [`load`](load::load) reads and compiles a text, [`compile`] a model, [`linear`] gives the matrices at load whose
//! [modes](analysis) are asked for (feature `analysis`). What a model says is in `ca-model`, what runs in `ca-core`.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

#[cfg(feature = "analysis")]
pub mod analysis;
mod certify;
mod compile;
mod connect;
mod emit;
mod findings;
#[cfg(feature = "parse")]
pub mod load;
mod lower;
mod net;
mod options;
mod passes;

/// Most degrees of freedom of a network whose modes are computed: the matrix is dense.
pub const MOST_MODES: usize = 4000;

pub use compile::{Compiled, compile, measured};
#[cfg(feature = "analysis")]
pub use compile::{linear, linear_tick};
pub use emit::cost;
#[cfg(feature = "parse")]
pub use load::load;
pub use options::{KernelClass, Options};
