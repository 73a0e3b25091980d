//! Derivatives of what a scene sounds by parameters of its model, by its start and by what ports are given; and of its energy, by
//! parameters.
//!
//! ```text
//! Model ─ at p and around it ─ compiled ─ differences: what p makes of the numbers ─ ticks: what these make of the outputs
//!         (parameter)                     (difference)                               (forward, reverse)
//! ```
//! Decides for derivatives in two parts, of which neither is written by hand. What the *compiler* makes of a parameter
//! (coefficients, lengths, the start) is had by differences of the eighth order between scenes compiled around its value: these
//! are smooth functions, computed to their last digits, so that the differences are exact to 1e-12 or so. What the *ticks*
//! make of it is had by ticks over dual numbers ([`Dual`](ca_core::Dual)): the same laws, passes and methods, whose numbers carry seven
//! derivatives each. Against differences of whole renders, which lose half of all digits to chaos and rounding, and take two renders
//! for each parameter; and against a tape, which would keep every operation.
//!
//! [`Forward`] takes all of a scene through its ticks so: all derivatives of all samples, for any scene, in a time that grows with the
//! number of parameters. [`Reverse`] goes back over the ticks: the gradient of one loss by any number of parameters, and by what
//! ports are given, in the time of a few renders, for most scenes. [`Energy`] goes forward too, and has the derivatives of the accounts of
//! energy, which the ticks keep as numbers with derivatives like all others.
//!
//! The tick is differentiable nearly everywhere: where a contact closes, friction turns or a table has a corner, the derivative
//! is that of the branch that was taken (docs/numerics.md §9). What is refused, by name: parameters that are whole numbers,
//! words or flags, or change what is built; groups at the gesture rate; parameters that a gesture drives.
//!
//! ```
//! use ca_gradient::{Forward, Reverse};
//! use cordis_anima::{Loaded, Options};
//!
//! let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }\n";
//! let forward = Forward::new(&Loaded::read(text, "bar.ca.toml"), &Options::default(), &["bar.f", "bar.dx0"]).unwrap();
//! let heard = forward.tangents(Some(0.01), None, &mut || true).unwrap();
//! assert_eq!((heard.frames, heard.outputs, heard.parameters.len()), (480, 1, 2));
//! // twice as far is twice as loud
//! let (now, by_dx0) = (heard.output[7], heard.tangents[7 * 2 + 1]);
//! assert!((by_dx0 * 1e-3 - now).abs() < 1e-12);
//! // of half the sum of squares, back over the ticks
//! let reverse = Reverse::new(&Loaded::read(text, "bar.ca.toml"), &Options::default(), &["bar.f", "bar.dx0"]).unwrap();
//! let found = reverse.gradient(&heard.output, None, &mut || true).unwrap();
//! let squares: f64 = heard.output.iter().map(|y| y * y).sum();
//! assert!((found.parameters[1] * 1e-3 / squares - 1.0).abs() < 1e-9);
//! ```
#![forbid(unsafe_code)]

mod difference;
mod energy;
mod error;
mod forward;
mod parameter;
mod parts;
mod played;
mod reverse;
mod tangent;

pub use energy::{ACCOUNTS, Energy, EnergyTangents};
pub use error::Error;
pub use forward::{Forward, Tangents};
pub use parameter::Parameter;
pub use played::GoesOn;
pub use reverse::{Checkpoints, Gradient, Reverse};
