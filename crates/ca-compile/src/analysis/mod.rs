//! What can be computed of a scene before it sounds: whether it is stable, and the modes of its linear part.
//!
//! Decides for faer: sparse Cholesky with a fill-reducing order and eigenvalues, in Rust, without a system library. All
//! of it stands behind the feature `analysis`; a build without it proves by the cheap bounds alone and says so.

pub mod factor;
pub mod linear;
pub mod modes;

pub use factor::{Factor, StabilityMatrix};
pub use linear::{Dof, Linear, LinkRow, MovingLink, Network, Port};
pub use modes::{Mode, Modes};
