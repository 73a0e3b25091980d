//! Content of a page as plain data.
//!
//! Callers build a report from sections and blocks; [`crate::page`] alone decides how these look.

use crate::plot::Plot;
use crate::sound::Sound;

/// Importance of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Useful to know.
    Note,
    /// Result that differs from the intention.
    Warning,
}

/// Table; columns of numbers are aligned to the right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns; empty for a table of names and values.
    pub head: Vec<String>,
    /// Cells, one for each column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Returns a table of names and values.
    pub fn pairs(rows: impl IntoIterator<Item = (&'static str, String)>) -> Table {
        Table { head: Vec::new(), rows: rows.into_iter().map(|(name, value)| vec![name.into(), value]).collect() }
    }

    /// Returns a table with names of columns.
    pub fn new(head: &[&str], rows: Vec<Vec<String>>) -> Table {
        Table { head: head.iter().map(|h| (*h).to_owned()).collect(), rows }
    }
}

/// Piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// Paragraph; names stand in backquotes, as in all texts except titles and sources.
    Text(String),
    /// Players of a sound.
    Sound(Sound),
    /// Plot.
    Plot(Plot),
    /// Table.
    Table(Table),
    /// Verbatim text, with a name.
    Source(String, String),
}

/// Moving instrument at the top of a page, drawn by an additional script.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Data for the script, without the pictures.
    pub about: serde_json::Value,
    /// Pictures, as the script reads them.
    pub bytes: Vec<u8>,
    /// The script.
    pub script: String,
    /// Description of what the film leaves out; may be empty.
    pub note: String,
}

/// Section, which is listed in the contents.
#[derive(Clone, Debug)]
pub struct Section {
    /// Its title.
    pub title: String,
    /// Its blocks.
    pub blocks: Vec<Block>,
}

impl Section {
    /// Returns a section.
    pub fn new(title: &str, blocks: Vec<Block>) -> Section {
        Section { title: title.into(), blocks }
    }
}

/// All content of a page.
#[derive(Clone, Debug)]
pub struct Report {
    /// Subject.
    pub title: String,
    /// Line below the title: model and author.
    pub subtitle: String,
    /// Moving instrument, if there is one.
    pub picture: Option<Picture>,
    /// Notes at the top of the page.
    pub notes: Vec<(Weight, String)>,
    /// Sections in order.
    pub sections: Vec<Section>,
}

impl Report {
    /// Returns an empty page.
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
