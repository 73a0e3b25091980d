//! Numeric: the number of a tick, and what is made of numbers alone: vectors of them, tables, a solver, a list of near points.
//!
//! Decides that what stands here knows nothing of scenes, kinds or laws, so that all the rest can stand on it.

mod aligned;
#[cfg(dual)]
mod dual;
pub mod ldl;
mod plain;
mod quarter;
mod real;
mod table;
mod verlet;
pub(crate) mod words;

pub use aligned::Aligned;
#[cfg(dual)]
pub use dual::{Dual, TANGENTS};
pub use plain::Plain;
pub use quarter::{quarter_mean, quarter_power, quarter_root};
pub use real::{
    DUAL, NONE, Outer, Real, SINGLE, TINY, Value, bare, inner, lift, outer, real, sqrt, value, value_sqrt, wide,
};
pub use table::Table;
pub use verlet::VerletList;
