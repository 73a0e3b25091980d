//! Plain: text of a file as it may be shown on a terminal.
//!
//! Decides that a title, a name and a path of somebody else's model are shown without control characters: escape sequences
//! move the cursor, change the title of the window, or hide what stands before them.

use alloc::string::String;

/// `text` with U+FFFD for each control character but the end of a line.
///
/// ```
/// assert_eq!(ca_model::plain::plain("a\x1b]0;x\x07b\nc\r"), "a\u{fffd}]0;x\u{fffd}b\nc\u{fffd}");
/// ```
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}
