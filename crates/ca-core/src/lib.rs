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
//! What is here: the elements ([`mat`], [`phi`], [`io`]) with the [records](kind) that describe them, the passes ([`op`]),
//! the integration [`method`]s, the [rate boundary](border), the energy [`ledger`], and [live changes](live). What is not:
//! nothing reads a file or a text, and nothing here makes a scene. Models are read by `ca-model` and compiled by
//! `ca-compile`; a program adds `cordis-anima`, which is both with files and sound.
//!
//! A tick computes with [`real::Real`]: `f64` in `ca-core`, and `f32` in `ca-core-single`, which is these files under
//! another name. Features: `std` (default) finds the widest instructions of the machine at run time.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod active_contacts;
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
pub mod param;
pub mod phi;
pub mod plain;
pub mod problem;
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
