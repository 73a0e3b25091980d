//! Inputs and outputs of a scene: gestures, sound files, probes, clouds of points, and a [performance](perform) that
//! plays a scene to its end without a clock. Devices and real time are in `ca-haptic`.
//!
//! A gesture is a set of named functions of time, read from CSV, NPY, WAV or MIDI files. A render is a WAV file. A
//! probe is any quantity of the model in an NPY or CSV file. Without the feature `files`, which is on by default, the
//! crate has only curves over time and live MIDI. All three together:
//!
//! ```
//! use ca_io::format::Format;
//! use ca_io::gesture::{Gesture, GestureFormat};
//! use ca_io::probe::ProbeOut;
//! use ca_io::sound::WavOut;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // a key goes down 5 mm in 20 ms, stays, and comes up
//! let text = "time,key\n0,0\n0.02,-0.005\n0.1,-0.005\n0.15,0\n";
//! let gesture = Gesture::read(GestureFormat::Csv, text.as_bytes(), &[], None)?;
//! let mut key = gesture.track("key").unwrap().cursor();
//!
//! let dir = tempfile::tempdir()?;
//! let mut sound = WavOut::create(dir.path().join("out.wav"), 3000.0, 1, Format::I24)?;
//! let mut probe = ProbeOut::create(dir.path().join("key.npy"), &["key"], 3000.0)?;
//! for n in 0..450 {
//!     let x = key.at(f64::from(n) / 3000.0); // [m]; amortised O(1), nothing is allocated
//!     sound.write(&[x * 300.0])?; // too loud
//!     probe.write(&[x])?;
//! }
//! let reported = sound.finish()?; // only now is there a file of that name
//! assert_eq!((reported.frames, reported.level.peak[0]), (450, 1.5));
//! assert!(reported.level.clipped > 240);
//! assert_eq!(probe.finish()?, 450);
//!
//! // what cannot be read says where, and what to do
//! let bad = Gesture::read(GestureFormat::Csv, b"time,key\n0,5 mm\n", &[], None).unwrap_err();
//! assert_eq!(
//!     bad.to_string(),
//!     "line 2, column 2 (`key`): `5 mm` is not a number; write it like `-1.5e-3`, without a unit"
//! );
//! # Ok(())
//! # }
//! ```

#[cfg(feature = "files")]
pub mod atomic_file;
#[cfg(feature = "files")]
pub mod cloud;
pub mod error;
#[cfg(feature = "files")]
pub mod files;
#[cfg(feature = "files")]
pub mod flac;
#[cfg(feature = "files")]
pub mod format;
pub mod gesture;
#[cfg(feature = "files")]
pub mod level_and_fade;
pub mod live_midi;
#[cfg(feature = "files")]
pub mod low_frequency;
#[cfg(feature = "files")]
pub mod play;
#[cfg(feature = "files")]
pub mod probe;
#[cfg(feature = "files")]
pub mod read_limited;
#[cfg(feature = "files")]
pub mod recording;
#[cfg(feature = "files")]
pub mod sound;
#[cfg(feature = "files")]
mod wav_header;

pub use error::{FileError, FileErrorKind};
#[cfg(feature = "files")]
pub use play::{length, perform, player, running};
