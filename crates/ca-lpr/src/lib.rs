//! LPR, radial projection links: the laws of `ca-core` over the sum of two elongations, with one force at both.
//!
//! ```text
//!    between (a world in space)          onto (another world, on a line)
//!    i ●────────────────● j              p ●────────● q
//!        |D| − l_A                           y_q − y_p
//!              └──────────── e = sum ───────────┘
//!                       F = φ(e, de/dt)
//! ```
//! A body that turns and flies in space deforms by microns at audio rate. An LPR in place of an edge of it hands that
//! deformation to a world on a line, where sound spreads and is heard, and hands back what that world answers: the
//! gradient of e spans both worlds, so what leaves one arrives in the other and nothing is created, whatever the law.
//! Flying and turning do not change a distance and are not heard.
//!
//! The laws are in `ca-core`. To give a law its LPR, begin at [`KINDS`].
//!
//! Decides that an LPR is a form of a law and no law of its own ([`mod@op`]): every law of the core has one, with its
//! parameters, its bounds and its energy. The kinds are `LPR` (spring and damper, as the REF) and `LPR_` with the code
//! of the law. A tour:
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
mod dry;
mod kinds;
mod laws;
pub mod op;
mod params;

use ca_core::Real;
use ca_core::internal::op::LawEntry;
pub use kinds::KINDS;

/// The functions of all laws of this crate over `R`, for [`Scene::bind`](ca_core::Scene::bind).
pub fn laws<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
    laws::laws::<R>().into_iter().chain(dry::laws()).chain(kinds::quadripoles())
}
