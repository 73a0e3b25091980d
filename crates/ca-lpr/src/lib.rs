//! LPR, radial projection links: the laws of `ca-core` over the sum of two elongations, with the same force at both.
//!
//! ```text
//!    between (a world in space)          onto (another world, on a line)
//!    i ●────────────────● j              p ●────────● q
//!        |D| − l_A                           y_q − y_p
//!              └──────────── e = sum ───────────┘
//!                       F = φ(e, de/dt)
//! ```
//! A body that turns and flies in space deforms by microns at audio rate. An LPR that replaces one of its edges couples
//! this deformation to a world on a line, where sound spreads and is picked up, and that world reacts on the body by
//! the same force. The gradient of e spans both worlds, so all energy that leaves one enters the other, with any law.
//! Translation and rotation do not change a distance and are not heard.
//!
//! Each law of `ca-core` has an LPR form ([`mod@op`]) with its parameters, bounds and energy; [`KINDS`] is where a new
//! law gets one. The kinds are `LPR` (spring and damper, as REF) and `LPR_` followed by the code of the law. Example:
//! ```
//! use ca_compile::{Options, load};
//! use ca_core::{Catalog, tick};
//!
//! let catalog = ca_model::catalog().with(ca_lpr::KINDS);
//! let kind = catalog.get("LPR").expect("the kinds of this crate");
//! let (_model, result) = load(kind.example, "lpr.ca.toml", &catalog, &Options::default());
//! let scene = result.expect("it compiles");
//! let mut state = scene.state();
//! (0..480).for_each(|_| tick(&scene, &mut state));
//! assert!(state.output[0] != 0.0);
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[macro_use]
mod quadripoles;
mod coulomb;
mod kinds;
mod laws;
pub mod op;
mod params;

use ca_core::Real;
use ca_core::internal::op::LawEntry;
pub use kinds::KINDS;

/// Returns the functions over `R` of all laws of this crate, for [`Scene::bind`](ca_core::Scene::bind).
pub fn laws<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
    laws::laws::<R>().into_iter().chain(coulomb::laws()).chain(kinds::quadripoles())
}
