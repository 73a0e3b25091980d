//! Virtual instruments made of masses and interactions (CORDIS-ANIMA), compiled to a short list of homogeneous
//! passes over flat arrays.
//!
//! ```text
//! text ─read→ Model ─compile→ Scene (immutable)     State (flat arrays)
//!                                └──── tick(&scene, &mut state) ────┘
//! ```
//! A tour:
//! ```
//! # #[cfg(feature = "parse")] {
//! use ca_core::{Catalog, Options, load, tick};
//!
//! let text = r#"
//! [SOL]
//! wall = {}
//! [MAS]
//! bob = { m = "1 g", dx0 = "1 mm" }
//! [REF]
//! spring = { between = ["wall", "bob"], k = "7.6 kN/m", z = "5 mN s/m" }
//! [SOX]
//! out = { from = "bob", gain = 1000 }
//! "#;
//! let (_model, result) = load(text, "bob.ca.toml", &Catalog::core(), &Options::default());
//! let scene = result.expect("it compiles");
//! let mut state = scene.state();
//! for _ in 0..48 {
//!     tick(&scene, &mut state); // one sample at 48 kHz; never allocates
//! }
//! assert!(state.output[0].abs() <= 1.0);
//! # }
//! ```
//! The halves of a tick are public ([`sense`] and [`advance`]): a device gets the force of this tick before any mass
//! moves, so the one-sample delay stays one sample.
//!
//! A tick computes with [`real::Real`]: `f64` in `ca-core`, and `f32` in `ca-core-single`, which is these files under
//! another name.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "parse")]
extern crate std;

#[cfg(feature = "analysis")]
pub mod analysis;
pub mod border;
pub mod catalog;
pub mod certificate;
pub mod cloud;
pub mod compile;
pub mod energy;
pub mod equivalence;
pub mod generate;
mod identity;
pub mod io;
pub mod kind;
pub mod law;
pub mod layout;
pub mod ldl;
pub mod ledger;
pub mod live;
#[cfg(feature = "parse")]
pub mod load;
pub mod mat;
pub mod method;
pub mod model;
pub mod near;
pub mod op;
pub mod param;
pub mod phi;
pub mod problem;
pub mod real;
pub mod scene;
pub mod sketch;
pub(crate) mod start;
pub mod state;
pub mod table;
pub mod tick;
pub mod touch;
pub mod tuning;
pub mod wave;

pub use catalog::Catalog;
pub use compile::{KernelClass, Options, compile};
#[cfg(feature = "parse")]
pub use load::load;
pub use model::Model;
pub use scene::Scene;
pub use state::State;
pub use tick::{advance, process, sense, tick};
