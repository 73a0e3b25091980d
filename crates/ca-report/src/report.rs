//! A report: what is on a page, as plain data, before it is a text.
//!
//! Decides that a report is put together from sections and blocks by whoever knows what it is about, and that
//! what they look like is decided in [`crate::page`] alone.

use crate::plot::Plot;
use crate::sound::Sound;

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
}
