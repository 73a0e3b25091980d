//! The scene compiler: turns a model into a scene that contains only what the outputs and devices need.
//!
//! ```text
//! Model ─ lower ─ Resolved ─ connect ─ Wired ─ passes ─ Pruned ─ certify ─ emit ─ Scene
//!         units, ranges,     ends of links,    methods,          bounds on stability;
//!         parameters         taps of outputs   cheaper laws      order, arrays, passes
//! ```
//!
//! All passes read and rewrite one network of plain records between model and scene. They push findings into one list,
//! so that the author sees all of them at once. A folder uses the network and the folders before it in this diagram,
//! never those behind it.
//!
//! [`load`](load::load) reads and compiles a text, and [`compile`] compiles a model. With the feature `analysis`,
//! [`linear`] returns the matrices at load, from which [`analysis`] computes the modes. The language is in `ca-model`,
//! the run-time in `ca-core`.
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

/// Largest number of degrees of freedom for which modes are computed, since the matrix is dense.
pub const MOST_MODES: usize = 4000;

pub use compile::{Compiled, compile, measured};
#[cfg(feature = "analysis")]
pub use compile::{linear, linear_tick};
pub use emit::cost;
#[cfg(feature = "parse")]
pub use load::load;
pub use options::{KernelClass, Options};
