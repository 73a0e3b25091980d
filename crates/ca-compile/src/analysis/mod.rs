//! Analysis of a scene before it sounds: its stability, and the modes of its linear part.
//!
//! It uses faer, which has sparse Cholesky with a fill-reducing order and eigenvalues, in Rust without a system
//! library. Builds without the feature `analysis` prove stability by cheap bounds only, and say so.

pub mod factor;
pub mod linear;
pub mod modes;

pub use factor::{Factor, StabilityMatrix};
pub use linear::{Dof, Linear, LinkRow, MovingLink, Network, Port};
pub use modes::{Mode, Modes};
