//! Numeric: the number of a tick, and what is made of numbers alone: vectors of them, tables, a solver, a list of near points.
//!
//! Decides that what stands here knows nothing of scenes, kinds or laws, so that all the rest can stand on it.

mod aligned;
mod dual;
pub mod ldl;
mod plain;
mod quarter;
mod real;
mod table;
mod verlet;
pub(crate) mod words;

pub use aligned::Aligned;
pub use dual::{Dual, TANGENTS};
pub use plain::Plain;
pub use quarter::{quarter_mean, quarter_power, quarter_root};
#[cfg(feature = "bytes")]
pub use real::Stored;
pub use real::{NONE, Precision, Real};
pub use table::Table;
pub use verlet::VerletList;
