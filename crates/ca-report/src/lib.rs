//! Writes one HTML page about a sound and the model that made it, in a single file.
//!
//! The crate turns plain data into a text. It uses neither files nor scenes, so the command and Python make the same
//! reports. The page works without a network: scripts, styles, pictures and sound are in it, and a policy in its head
//! forbids anything else. Texts, tables, pictures and sound need no scripts; the scripts in `assets/` draw the plots.
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
