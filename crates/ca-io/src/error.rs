//! Errors about files that cannot be read or written.
//!
//! All file formats share one record: a kind for programs; the file, the place in it, the problem and one fix for
//! people. An enum with a variant per problem would grow with every format, and callers only distinguish the file, its
//! content and their own request.

use std::fmt;
use std::path::Path;

/// Kind of a failure, for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileErrorKind {
    /// The operating system refused to open, read, write or rename the file.
    Io,
    /// The file is not of this format, or is cut short.
    Format,
    /// The file uses a valid variant of the format that is not supported.
    Unsupported,
    /// The content cannot drive a model: a gap, a time that decreases, a number without a value.
    Content,
    /// The request does not fit the file: a missing rate, a number of channels.
    Usage,
    /// The reader of a pipe closed it.
    Left,
}

/// Reason why a file could not be read or written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// Kind of the failure.
    pub kind: FileErrorKind,
    /// File as the caller named it; empty if there is none.
    pub file: String,
    /// Place in the file (`line 3, column 2`); empty for the whole file.
    pub place: String,
    /// Description of the problem.
    pub what: String,
    /// Advice; empty if there is none.
    pub fix: String,
}

impl FileError {
    /// Makes an error without file, place and fix; callers that know them add them.
    pub fn new(kind: FileErrorKind, what: impl Into<String>) -> FileError {
        FileError { kind, file: String::new(), place: String::new(), what: what.into(), fix: String::new() }
    }
    /// Makes an error of the operating system: `what` names the failed operation.
    pub fn io(path: &Path, what: &str, e: &std::io::Error) -> FileError {
        // the words of the system already say what its number means
        let why = e.to_string();
        let why = why.split(" (os error").next().unwrap_or(&why);
        FileError::new(FileErrorKind::Io, format!("{what}: {}", lower(why))).file(path.display())
    }
    /// Makes an error for a file that is not of this format.
    pub fn format(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Format, what)
    }
    /// Makes an error for invalid content in a file of this format.
    pub fn content(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Content, what)
    }
    /// Makes an error for a valid file in a variant that this reader does not support.
    pub fn unsupported(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Unsupported, what)
    }
    /// Makes an error for a wrong request.
    pub fn usage(what: impl Into<String>) -> FileError {
        FileError::new(FileErrorKind::Usage, what)
    }
    /// Sets the file, if none is set.
    #[must_use]
    pub fn file(mut self, file: impl fmt::Display) -> FileError {
        if self.file.is_empty() {
            self.file = file.to_string();
        }
        self
    }
    /// Sets the place in the file.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> FileError {
        self.place = place.into();
        self
    }
    /// Sets the advice.
    #[must_use]
    pub fn fix(mut self, fix: impl Into<String>) -> FileError {
        self.fix = fix.into();
        self
    }
}

/// Returns a word from a file as safe for a terminal: at most 40 characters, control characters escaped.
pub fn shown(word: &str) -> String {
    const MOST: usize = 40;
    let short: String = word.chars().take(MOST).collect();
    let rest = if word.chars().nth(MOST).is_some() { "…" } else { "" };
    short.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.into() }).collect::<String>()
        + rest
}

/// Returns the message of the system without its error number and with a lower-case first letter.
pub fn reason(e: &std::io::Error) -> String {
    let s = e.to_string();
    let s = s.split(" (os error").next().unwrap_or(&s);
    let mut c = s.chars();
    c.next().map(|a| a.to_lowercase().chain(c).collect()).unwrap_or_default()
}

/// Returns `s` with a lower-case first letter, unless the next letter is a capital. Libraries capitalise their
/// messages.
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
