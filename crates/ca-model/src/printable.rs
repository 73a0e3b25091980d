//! Makes text of a file safe for a terminal.
//!
//! Titles, names and paths of foreign models are shown without control characters, since escape sequences move the
//! cursor, change the title of the window or hide earlier text.

use alloc::string::String;

/// Returns `text` with U+FFFD for each control character except line ends.
///
/// ```
/// assert_eq!(ca_model::printable::printable("a\x1b]0;x\x07b\nc\r"), "a\u{fffd}]0;x\u{fffd}b\nc\u{fffd}");
/// ```
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}
