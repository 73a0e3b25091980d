//! What can be computed of a scene before it sounds: the exact answer to "is it stable".
//!
//! Decides for faer: sparse Cholesky with a fill-reducing order, in safe Rust, without a system library. All of it
//! stands behind the feature `analysis`; a build without it proves by the cheap bounds alone and says so.

pub mod factor;
pub mod linear;

pub use factor::{Factor, Pencil};
pub use linear::{Linear, Loose, Place, Row};
