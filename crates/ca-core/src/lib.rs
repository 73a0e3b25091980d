//! The run-time of CORDIS-ANIMA: plays instruments of masses and interactions as a few homogeneous passes over arrays.
//!
//! ```text
//! Scene (immutable, shared)      State (flat arrays, one per player)
//!        └──── tick(&scene, &mut state) ────┘
//! ```
//! A [`Scene`] describes the instrument and never changes. A [`State`] holds every number that changes. [`tick()`]
//! advances a state by one sample: it does not allocate, lock or call the system, and gives the same bits on every
//! processor.
//!
//! Both halves of a tick are public ([`compute_forces`] and [`integrate`]). A device gets the force of this tick before
//! any mass moves, so the one-sample delay stays one sample.
//!
//! Starting points:
//! - to play: [`Scene`], [`State`], [`tick()`]; live parameters, [`Controls`]; names of modules, [`Symbols`]; what is
//!   proven of the scene, [`Certificate`]; energy, [`Ledger`]; real and model units at a device, [`equivalence`];
//!   pulling a mass without a device, [`mod@pointer`];
//! - to compute with a number type other than `f64`: [`Scene::bind`], [`Real`], [`Dual`];
//! - to add a law: its functions, [`Phi`]; the law as data, [`Law`]; its record, [`Kind`], with [`Param`] and [`Unit`];
//!   a parameter that is one of several words, [`choice!`]; all kinds of a program, [`Catalog`].
//!
//! The undocumented module `internal` exports the rest to the other crates of the workspace: passes and their arrays,
//! methods, the rate boundary, the builder of generators. It may change at any time.
//!
//! This crate does not read files or text, and does not make scenes. `ca-model` reads models and `ca-compile` compiles
//! them. A program depends on `cordis-anima`, which combines both with files and sound.
//!
//! A tick computes with a [`Real`]: `f64`, or the type of [`Scene::bind`], which is `f32` or a number with derivatives.
//!
//! Features: `std` (default) detects the widest vector instructions of the machine at run time; `bytes` writes compiled
//! scenes to bytes and reads them back (`Scene::to_bytes`, `Scene::from_bytes`).
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod border;
mod catalog;
mod choice;
pub mod equivalence;
#[doc(hidden)]
pub mod internal;
mod io;
mod kind;
mod law;
mod live;
mod mat;
mod method;
mod numeric;
mod op;
mod passes;
mod phi;
pub mod pointer;
mod scene;
mod state;
mod tick;
mod tuning;

pub use catalog::{Catalog, SOURCES};
pub use kind::name::Name;
pub use kind::{ABOVE_ZERO, ANY, Dim, Kind, Need, OneOf, POSITIVE, Param, Role, Type, Unit};
pub use law::{Bound, Number, Phi};
pub use live::{Controls, LiveParam, Patch, Refused};
pub use numeric::{Dual, Precision, Real, TANGENTS, Table};
pub use op::{Law, Laws, ParamBinding};
pub use phi::BETWEEN;
pub use scene::certificate::{Certificate, Level};
pub use scene::{ARITHMETIC, Input, InputRole, Location, Scene, Symbol, Symbols, Unbound};
#[cfg(feature = "bytes")]
pub use scene::{PLAN_VERSION, Plan, PlanError};
pub use state::{Balance, Identity, Ledger, NotRestored, State};
pub use tick::{compute_forces, integrate, process, tick};
