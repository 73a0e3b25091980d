//! Number types, and what is built from numbers alone: aligned arrays, tables, an LDLᵀ solver, a neighbour list.
//!
//! Nothing here depends on scenes, kinds or laws, so every other module can use it.

mod aligned;
mod dual;
pub mod ldl;
mod plain;
mod quarter;
mod real;
mod table;
mod verlet;
pub(crate) mod word_hash;

pub use aligned::Aligned;
pub use dual::{Dual, TANGENTS};
pub use plain::Plain;
pub use quarter::{quarter_mean, quarter_power, quarter_root};
#[cfg(feature = "bytes")]
pub use real::Stored;
pub use real::{NONE, Precision, Real};
pub use table::Table;
pub use verlet::VerletList;
