//! The run-time of CORDIS-ANIMA: virtual instruments made of masses and interactions, as a short list of homogeneous
//! passes over flat arrays.
//!
//! ```text
//! Scene (immutable, shared)      State (flat arrays, one per player)
//!        └──── tick(&scene, &mut state) ────┘
//! ```
//! A [`Scene`] says what there is, a [`State`] how it stands, and [`tick()`] moves it on by one sample: no allocation, no
//! lock, no call of the system, the same bits on every processor. The halves of a tick are public ([`compute_forces`] and
//! [`integrate`]): a device gets the force of this tick before any mass moves, so the one-sample delay stays one sample.
//!
//! Where to go:
//! - to play: [`Scene`], [`State`], [`tick()`]; what a compiled model is and what was proven of it, [`scene`]; parameters
//!   that change meanwhile, [`live`]; a model in the hand, [`equivalence`]; a mass that is pulled without
//!   a device, [`mod@pointer`];
//! - to add a kind: a MAT, [`mat`]; a port, [`io`]; a law, [`phi`] over the functions of [`law`]; its record, the builder
//!   of a generator and a parameter that is one of several words ([`choice!`]), [`kind`]; what sounds at a pitch,
//!   [`tuning`]; all of them, [`Catalog`];
//! - to compile: how stiff links are solved, [`method`]; the rate boundary, [`border`]; the passes and the arrays they
//!   read, [`op`]; what they write, with the ledger of energy, [`state`]; numbers, tables and solvers, [`numeric`].
//!
//! What is not here: nothing reads a file or a text, and nothing makes a scene. Models are read by `ca-model` and compiled
//! by `ca-compile`; a program adds `cordis-anima`, which is both with files and sound.
//!
//! A tick computes with a [`numeric::Real`]: `f64`, or the number that a scene is bound to ([`Scene::bind`]), `f32` or a number with
//! derivatives. Features: `std` (default) finds the widest instructions of the machine at run time; `bytes` writes compiled scenes as
//! bytes and reads them (`Scene::to_bytes`, `Scene::from_bytes`).
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod border;
mod catalog;
mod choice;
pub mod equivalence;
pub mod io;
pub mod kind;
pub mod law;
pub mod live;
pub mod mat;
pub mod method;
pub mod numeric;
pub mod op;
mod passes;
pub mod phi;
pub mod pointer;
pub mod scene;
pub mod state;
mod tick;
pub mod tuning;

pub use catalog::{Catalog, SOURCES};
pub use scene::{ARITHMETIC, Scene};
pub use state::State;
pub use tick::{compute_forces, integrate, process, tick};
