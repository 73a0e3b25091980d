//! One page of HTML about a sound and the model that made it, whole in one file.
//!
//! Decides that this crate takes plain data and gives a text: it knows neither files nor scenes, so that the command and
//! Python tell the same of different things. The page asks nobody for anything: script, style, pictures and sound are
//! in it, and a policy in its head forbids the rest. What it says in words, tables, pictures and sound is there without a
//! script; the script adds the plots, drawn by uPlot (MIT, `assets/`).
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
mod plot;
mod sound;
mod spectrogram;
mod spectrum;

pub use envelope::Envelope;
pub use plot::{Axis, Curve, Grid, Image, Look, Mark, Plot, Point};
pub use sound::{CHANNELS, KEPT, Sound};
pub use spectrogram::spectrogram;
pub use spectrum::{LOWEST, Spectrum};

/// How much a note matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// good to know
    Note,
    /// something is not as meant
    Warning,
}

/// A table; cells that are numbers stand to the right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// names of the columns; none for a table of names and values
    pub head: Vec<String>,
    /// cells, as many as there are columns
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Names and values.
    pub fn pairs(rows: impl IntoIterator<Item = (&'static str, String)>) -> Table {
        Table { head: Vec::new(), rows: rows.into_iter().map(|(name, value)| vec![name.into(), value]).collect() }
    }

    /// A table with names of columns.
    pub fn new(head: &[&str], rows: Vec<Vec<String>>) -> Table {
        Table { head: head.iter().map(|h| (*h).to_owned()).collect(), rows }
    }
}

/// A piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// a paragraph; names stand in backquotes, as in all texts but titles and sources
    Text(String),
    /// players
    Sound(Sound),
    /// a plot
    Plot(Plot),
    /// a table
    Table(Table),
    /// text as it is, with a name
    Source(String, String),
}

/// The moving instrument at the top of a page: what a script of its own draws.
#[derive(Clone, Debug)]
pub struct Picture {
    /// what the script is told of it, without its bytes
    pub about: serde_json::Value,
    /// the pictures, as the script reads them
    pub bytes: Vec<u8>,
    /// the script
    pub script: String,
    /// what is not as it was, in words; or nothing
    pub told: String,
}

/// A part of the page, in its table of contents.
#[derive(Clone, Debug)]
pub struct Section {
    /// its title
    pub title: String,
    /// what is in it
    pub blocks: Vec<Block>,
}

impl Section {
    /// A section.
    pub fn new(title: &str, blocks: Vec<Block>) -> Section {
        Section { title: title.into(), blocks }
    }
}

/// All that is on the page.
#[derive(Clone, Debug)]
pub struct Report {
    /// what it is about
    pub title: String,
    /// one line below: of what, by whom
    pub subtitle: String,
    /// the moving instrument, where there is one
    pub picture: Option<Picture>,
    /// what a reader must know before all else
    pub notes: Vec<(Weight, String)>,
    /// the parts, in order
    pub sections: Vec<Section>,
}

impl Report {
    /// A page with nothing on it yet.
    pub fn new(title: &str, subtitle: &str) -> Report {
        Report {
            title: title.into(),
            subtitle: subtitle.into(),
            picture: None,
            notes: Vec::new(),
            sections: Vec::new(),
        }
    }

    /// The page.
    pub fn html(&self) -> String {
        page::page(self)
    }
}
