//! Derivatives of the outputs of a scene, by parameters of its model, its start and its port inputs; and of its energy,
//! by parameters.
//!
//! ```text
//! Model ─ at p and around it ─ compiled ─ differences: what p makes of the numbers ─ ticks: what these make of the outputs
//!         (parameter)                     (difference)                               (forward, reverse)
//! ```
//! A derivative has two parts, neither of them written by hand:
//!
//! - What the *compiler* makes of a parameter (coefficients, lengths, the start) is differentiated by eighth-order
//!   differences between scenes compiled around its value. These functions are smooth and computed to their last
//!   digits, so the differences are exact to about 1e-12.
//! - What the *ticks* make of these numbers is computed over dual numbers ([`Dual`](ca_core::Dual)): the same laws,
//!   passes and methods on numbers that carry seven derivatives each.
//!
//! Differences of whole renders would lose half of all digits to chaos and rounding, and need two renders per
//! parameter. Recording every operation of every tick would take memory in proportion to the time played.
//!
//! [`Forward`] returns all derivatives of all samples, for any scene; its time grows with the number of parameters.
//! [`Reverse`] returns the gradient of one loss by any number of parameters and by port inputs, in the time of a few
//! renders, for most scenes. [`Energy`] works forward too and returns the derivatives of the energy accounts.
//!
//! The tick is differentiable nearly everywhere. At a contact that closes, friction that changes its branch or a corner
//! of a table, the derivative follows the branch taken (docs/numerics.md §9). Refused, by name: parameters that are
//! whole numbers, words or flags, or that change what is built; groups at the gesture rate; parameters driven by a
//! gesture.
//!
//! ```
//! use ca_gradient::{Forward, Reverse};
//! use cordis_anima::{Loaded, Options};
//!
//! let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }\n";
//! let forward = Forward::new(&Loaded::read(text, "bar.ca.toml"), &Options::default(), &["bar.f", "bar.dx0"]).unwrap();
//! let sound = forward.tangents(Some(0.01), None, &mut || true).unwrap();
//! assert_eq!((sound.frames, sound.outputs, sound.parameters.len()), (480, 1, 2));
//! // twice as far is twice as loud
//! let (now, by_dx0) = (sound.output[7], sound.tangents[7 * 2 + 1]);
//! assert!((by_dx0 * 1e-3 - now).abs() < 1e-12);
//! // of half the sum of squares, back over the ticks
//! let reverse = Reverse::new(&Loaded::read(text, "bar.ca.toml"), &Options::default(), &["bar.f", "bar.dx0"]).unwrap();
//! let found = reverse.gradient(&sound.output, None, &mut || true).unwrap();
//! let squares: f64 = sound.output.iter().map(|y| y * y).sum();
//! assert!((found.parameters[1] * 1e-3 / squares - 1.0).abs() < 1e-9);
//! ```
#![forbid(unsafe_code)]

mod difference;
mod energy;
mod error;
mod forward;
mod parameter;
mod parts;
mod play_io;
mod reverse;
mod tangent;

pub use energy::{ACCOUNTS, Energy, EnergyTangents};
pub use error::Error;
pub use forward::{Forward, Tangents};
pub use parameter::Parameter;
pub use play_io::GoesOn;
pub use reverse::{Checkpoints, Gradient, Reverse};
