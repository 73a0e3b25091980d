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
//! - to play: [`Scene`], [`State`], [`tick()`]; parameters that change meanwhile, [`Controls`]; the names of modules, [`Symbols`];
//!   what was proven of the scene, [`Certificate`]; energy, [`Ledger`]; a model in the hand, [`equivalence`]; a mass that is
//!   pulled without a device, [`mod@pointer`];
//! - to compute with another number than `f64`: [`Scene::bind`], [`Real`], [`Dual`];
//! - to add a law: its functions, [`Phi`]; the law as data, [`Law`]; its record, [`Kind`], with [`Param`] and [`Unit`]; a parameter
//!   that is one of several words, [`choice!`]; all kinds of a program, [`Catalog`].
//!
//! The module `internal`, which this page does not show, has the rest for the other crates of the workspace: passes and the arrays
//! that they read, methods, the rate boundary, the builder of a generator. No promise is made about it.
//!
//! What is not here: nothing reads a file or a text, and nothing makes a scene. Models are read by `ca-model` and compiled
//! by `ca-compile`; a program adds `cordis-anima`, which is both with files and sound.
//!
//! A tick computes with a [`Real`]: `f64`, or the number that a scene is bound to ([`Scene::bind`]), `f32` or a number with
//! derivatives. Features: `std` (default) finds the widest instructions of the machine at run time; `bytes` writes compiled scenes as
//! bytes and reads them (`Scene::to_bytes`, `Scene::from_bytes`).
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
