//! What is said about a file that cannot be read or written.
//!
//! Decides that there is one record for every file format: a kind for programs, and for people the file, the place
//! in it, what is found there and one thing to do about it. An enum with a variant per mishap was the alternative; it
//! would grow with every format, while callers only ever ask whether it is the file, its content or their own request.

use std::fmt;
use std::path::Path;

/// What sort of failure, for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileErrorKind {
    /// the operating system refused to open, read, write or rename it
    Io,
    /// it is not a file of that format, or is cut short
    Format,
    /// a proper file of that format, in a variety that is not read
    Unsupported,
    /// it reads, but what it holds cannot drive a model: a gap, a time that runs backwards, a number without a value
    Content,
    /// the request does not fit the file: a missing rate, a number of channels
    Usage,
    /// the reader of a pipe went away
    Left,
}

/// Why a file could not be read or written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// what sort of failure
    pub kind: FileErrorKind,
    /// the file as the caller named it; empty where there is none
    pub file: String,
    /// where in the file (`line 3, column 2`); empty where it is all of it
    pub place: String,
    /// what is wrong
    pub what: String,
    /// what to do about it; empty where nothing sensible can be said
    pub fix: String,
}

impl FileError {
    /// What went wrong; file, place and a fix are added by those who know them.
    pub fn new(kind: FileErrorKind, what: impl Into<String>) -> FileError {
        FileError { kind, file: String::new(), place: String::new(), what: what.into(), fix: String::new() }
    }
    /// The system refused: `what` says what was tried.
    pub fn io(path: &Path, what: &str, e: &std::io::Error) -> FileError {
        // the number says nothing that the words do not
        let why = e.to_string();
        let why = why.split(" (os error").next().unwrap_or(&why);
        FileError::new(FileErrorKind::Io, format!("{what}: {}", lower(why))).file(path.display())
    }
    /// Not a file of this format.
    pub fn format(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Format, what)
    }
    /// A file of this format that holds what cannot be.
    pub fn content(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Content, what)
    }
    /// What the format allows and this reader does not know.
    pub fn unsupported(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Unsupported, what)
    }
    /// Not the fault of a file.
    pub fn usage(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Usage, what)
    }
    /// Names the file.
    #[must_use]
    pub fn file(mut self, file: impl fmt::Display) -> FileError {
        if self.file.is_empty() {
            self.file = file.to_string();
        }
        self
    }
    /// Names the place in it.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> FileError {
        self.place = place.into();
        self
    }
    /// Says what to do.
    #[must_use]
    pub fn fix(mut self, fix: impl Into<String>) -> FileError {
        self.fix = fix.into();
        self
    }
}

/// A word of a file, as it may stand on a terminal: not too long, and what is no sign is escaped.
pub fn shown(word: &str) -> String {
    const MOST: usize = 40;
    let short: String = word.chars().take(MOST).collect();
    let rest = if word.chars().nth(MOST).is_some() { "…" } else { "" };
    short.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.into() }).collect::<String>()
        + rest
}

/// The words of the system, as part of a sentence.
pub fn reason(e: &std::io::Error) -> String {
    let s = e.to_string();
    let s = s.split(" (os error").next().unwrap_or(&s);
    let mut c = s.chars();
    c.next().map(|a| a.to_lowercase().chain(c).collect()).unwrap_or_default()
}

/// The libraries below us begin their messages with a capital.
pub fn lower(s: &str) -> String {
    let mut c = s.chars();
    match c.next() {
        Some(a) if !c.as_str().starts_with(char::is_uppercase) => a.to_lowercase().chain(c).collect(),
        _ => s.to_owned(),
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.file.is_empty(), self.place.is_empty()) {
            (false, false) => write!(f, "`{}`, {}: ", self.file, self.place)?,
            (false, true) => write!(f, "`{}`: ", self.file)?,
            (true, false) => write!(f, "{}: ", self.place)?,
            (true, true) => {}
        }
        f.write_str(&self.what)?;
        if self.fix.is_empty() { Ok(()) } else { write!(f, "; {}", self.fix) }
    }
}

impl std::error::Error for FileError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_as_one_line() {
        let e = FileError::content("`abc` is not a number").file("take.csv").at("line 3, column 2").fix("write metres");
        assert_eq!(e.to_string(), "`take.csv`, line 3, column 2: `abc` is not a number; write metres");
        assert_eq!(FileError::usage("no rate").to_string(), "no rate");
        assert_eq!(lower("No such file"), "no such file");
        assert_eq!(lower("RIFF missing"), "RIFF missing");
    }
}
