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
//! - to play: [`Scene`], [`State`], [`mod@tick`]; parameters that change meanwhile, [`live`]; what was stored, lost and
//!   received, [`ledger`]; how stable it is, [`certificate`]; a model in the hand, [`equivalence`];
//! - to add a kind: its record, [`kind`]; a law, [`law`] and [`phi`]; a MAT, [`mat`]; a port, [`io`]; a generator,
//!   [`builder`]; a parameter that is one of several words, [`choice!`](crate::choice);
//! - to compile: the arrays, [`layout`]; the passes, [`op`]; how they are solved, [`method`], [`ldl`], [`verlet`]; the rate
//!   boundary, [`border`]; the first tick, [`start`].
//!
//! What is not here: nothing reads a file or a text, and nothing makes a scene. Models are read by `ca-model` and compiled
//! by `ca-compile`; a program adds `cordis-anima`, which is both with files and sound.
//!
//! A tick computes with [`real::Real`]: `f64` in `ca-core`, and `f32` in `ca-core-single`, which is these files under
//! another name. Features: `std` (default) finds the widest instructions of the machine at run time.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod active_contacts;
pub mod aligned;
pub mod border;
pub mod builder;
pub mod catalog;
pub mod certificate;
mod choice;
pub mod cloud;
pub mod energy;
pub mod equivalence;
mod identity;
pub mod io;
pub mod kind;
pub mod law;
pub mod layout;
pub mod ldl;
pub mod ledger;
pub mod live;
pub mod mat;
pub mod method;
pub mod op;
mod param;
pub mod phi;
pub mod plain;
mod problem;
pub mod real;
pub mod scene;
pub mod start;
pub mod state;
pub mod table;
pub mod tick;
pub mod tuning;
pub mod verlet;
pub mod wave;

pub use catalog::Catalog;
pub use scene::Scene;
pub use state::State;
pub use tick::{compute_forces, integrate, process, tick};
