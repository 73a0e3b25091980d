//! Virtual instruments made of masses and interactions (CORDIS-ANIMA), compiled to a short list of homogeneous
//! passes over flat arrays.
//!
//! ```text
//! text ─read→ Model ─compile→ Scene (immutable)     State (flat f64 arrays)
//!                                └──── tick(&scene, &mut state) ────┘
//! ```
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "parse")]
extern crate std;

pub mod catalog;
pub mod generate;
pub mod io;
pub mod kind;
pub mod mat;
pub mod model;
pub mod phi;
