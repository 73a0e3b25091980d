//! One page of HTML about a sound and the model that made it, whole in one file.
//!
//! Decides that this crate takes plain data and gives a text: it knows neither files nor scenes, so that the command and
//! Python tell the same of different things. The page needs no network: scripts, styles, pictures and sound are
//! in it, and a policy in its head forbids the rest. Words, tables, pictures and sound are there without
//! scripts; the scripts in `assets/` draw the plots.
//!
//! ```
//! use ca_report::{Axis, Block, Curve, Grid, Plot, Report, Section, Sound};
//!
//! let mut sound = Sound::new(48_000.0, &["out".into()]);
//! sound.push(&[0.0, 0.5, 0.0, -0.5]);
//! let mut report = Report::new("A click & <nothing> else", "made by hand");
//! report.sections.push(Section::new("Sound", vec![Block::Sound(sound)]));
//! let page = report.html();
//! assert!(page.contains("A click &amp; &lt;nothing&gt; else") && page.contains("data:audio/wav;base64,"));
//! ```
#![forbid(unsafe_code)]

mod envelope;
mod page;
pub mod pitch;
mod plot;
mod report;
mod sound;
mod spectrogram;
mod spectrum;

pub use envelope::Envelope;
pub use plot::{Axis, Curve, Grid, Image, Look, Mark, Plot, Point};
pub use report::{Block, Picture, Report, Section, Table, Weight};
pub use sound::{CHANNELS, KEPT, Sound};
pub use spectrogram::spectrogram;
pub use spectrum::{Hann, LOWEST, Spectrum};
