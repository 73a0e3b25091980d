//! Virtual instruments made of masses and interactions (CORDIS-ANIMA), for Rust programs: load, compile, tick, render.
//!
//! ```
//! use cordis_anima::{Loaded, Options, tick};
//!
//! let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }\n";
//! let scene = Loaded::read(text, "bar.ca.toml").compile(&Options::default())?.scene;
//! let mut state = scene.state();
//! for _ in 0..48_000 {
//!     tick(&scene, &mut state); // one sample at 48 kHz; never allocates
//!     assert!(state.output[0].abs() <= 1.0);
//! }
//! # Ok::<(), cordis_anima::Error>(())
//! ```
//! [`load`] loads a file, and [`render`] plays a scene to its end with its built-in gesture:
//! ```no_run
//! let scene = cordis_anima::load("hammered_string.ca.toml")?.scene;
//! let sound = cordis_anima::render(&scene, None)?;
//! println!("{} samples of {} channels at {} Hz", sound.frames(), sound.channels, sound.rate);
//! # Ok::<(), cordis_anima::Error>(())
//! ```
//! In an audio program a [`Voice`] plays a scene in blocks of planar `f32`, sets ports and live parameters by handle,
//! and does not allocate:
//! ```
//! # let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }\n";
//! # let scene = cordis_anima::Loaded::read(text, "bar.ca.toml").compile(&Default::default())?.scene;
//! let mut voice = cordis_anima::Voice::new(std::sync::Arc::new(scene));
//! let mut left = [0.0_f32; 128];
//! voice.process(&[], &mut [&mut left]);
//! assert!(left.iter().any(|sample| *sample != 0.0));
//! # Ok::<(), cordis_anima::Error>(())
//! ```
//! With the feature `bytes` a compiled scene is saved as bytes, which a program without a compiler can read:
#![cfg_attr(feature = "bytes", doc = "```")]
#![cfg_attr(not(feature = "bytes"), doc = "```ignore")]
//! use cordis_anima::{Loaded, Options, Plan, catalog};
//!
//! # let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }\n";
//! let scene = Loaded::read(text, "bar.ca.toml").compile(&Options::default())?.scene;
//! let bytes = scene.to_bytes();
//! let again = Plan::from_bytes(&bytes, &catalog()).expect("bytes of this version");
//! assert_eq!(again.identity(), scene.identity());
//! # Ok::<(), cordis_anima::Error>(())
//! ```
//! `examples/` has a renderer (`render`), a real-time callback (`callback`), a voice in an audio host
//! (`jack`), a law of one's own (`law`) and a sweep over
//! threads (`sweep`). What each layer offers beyond these names is in its crate, which is here under its own name:
//! [`ca_core`] (the run-time), [`ca_model`] (the language), [`ca_compile`] (the compiler), [`ca_io`] (gestures, sound
//! files, performances), [`ca_import`] (formats of others). Devices and forces are in `ca-haptic`, which is not part of
//! this crate: a program that only sounds pays for none of it.
#![forbid(unsafe_code)]

mod error;
pub mod loaded;
mod render;
pub mod voice;

pub use ca_compile::{Compiled, KernelClass, Options};
pub use ca_core::{Catalog, Scene, State, compute_forces, integrate, process, tick};
#[cfg(feature = "bytes")]
pub use ca_core::{Plan, PlanError};
pub use ca_io::FileError;
pub use ca_model::Model;
pub use error::{Error, Found};
pub use loaded::{Loaded, catalog, laws, load};
pub use render::{Rendered, render};
pub use voice::Voice;

pub use {ca_compile, ca_core, ca_import, ca_io, ca_model};
