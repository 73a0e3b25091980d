//! Replacements in a text.

use core::ops::Range;
use serde::{Deserialize, Serialize};

/// A replacement: the bytes of `range` become `text`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TextEdit {
    /// Replaced bytes of the old text; empty for an insertion.
    pub range: Range<usize>,
    /// New text.
    pub text: String,
}

impl TextEdit {
    pub(crate) fn new(range: Range<usize>, text: impl Into<String>) -> TextEdit {
        TextEdit { range, text: text.into() }
    }

    pub(crate) fn insert(at: usize, text: impl Into<String>) -> TextEdit {
        TextEdit::new(at..at, text)
    }
}

/// Result of an operation.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edited {
    /// Whole new text.
    pub text: String,
    /// The difference to the old text: replacements that do not overlap, from first to last.
    pub edits: Vec<TextEdit>,
    /// The changed bytes of the new text, one range for each replacement.
    pub ranges: Vec<Range<usize>>,
}

impl Edited {
    /// Applies replacements to a text. Of two that overlap, the one that begins earlier, or is longer, is applied; two
    /// removals become one, and an insertion in a removed range moves to its end. Replacements outside the text are left
    /// out.
    pub fn new(old: &str, mut edits: Vec<TextEdit>) -> Edited {
        edits.retain(|e| old.get(e.range.clone()).is_some_and(|o| o != e.text));
        // insertions first
        edits.sort_by_key(|e| (e.range.start, !e.range.is_empty(), core::cmp::Reverse(e.range.end)));
        let mut kept: Vec<TextEdit> = Vec::with_capacity(edits.len());
        for e in edits {
            let Some(last) = kept.last_mut().filter(|last| e.range.start < last.range.end) else {
                kept.push(e);
                continue;
            };
            let end = last.range.end;
            match (last.text.is_empty(), e.text.is_empty()) {
                (true, true) => last.range.end = end.max(e.range.end),
                // an insertion among removed bytes
                (true, false) if e.range.is_empty() => kept.push(TextEdit::insert(end, e.text)),
                _ => {}
            }
        }
        let (mut text, mut ranges, mut at) = (String::with_capacity(old.len()), Vec::new(), 0);
        for e in &kept {
            text += &old[at..e.range.start];
            ranges.push(text.len()..text.len() + e.text.len());
            text += &e.text;
            at = e.range.end;
        }
        text += &old[at..];
        Edited { text, edits: kept, ranges }
    }

    /// Finds the difference between two texts, as one replacement.
    pub fn between(old: &str, new: &str) -> Edited {
        let same = |a: &mut dyn Iterator<Item = char>, b: &mut dyn Iterator<Item = char>| -> usize {
            a.zip(b).take_while(|(a, b)| a == b).map(|(a, _)| a.len_utf8()).sum()
        };
        let start = same(&mut old.chars(), &mut new.chars());
        let end = same(&mut old[start..].chars().rev(), &mut new[start..].chars().rev());
        Edited::new(old, vec![TextEdit::new(start..old.len() - end, &new[start..new.len() - end])])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_replacements_are_applied_once() {
        let edits = [(4..6, ""), (0..3, ""), (1..5, ""), (8..9, "xy"), (8..8, "é")];
        let e = Edited::new("0123456789", edits.map(|(r, t)| TextEdit::new(r, t)).into());
        assert_eq!((e.text.as_str(), e.ranges.as_slice()), ("67éxy9", [0..0, 2..4, 4..6].as_slice()));
        assert_eq!(Edited::new("é", vec![TextEdit::new(1..2, "x"), TextEdit::new(5..9, "x")]).text, "é");
    }

    #[test]
    fn a_difference_is_one_replacement() {
        for (old, new, edits) in [
            ("a b c", "a é c", vec![TextEdit::new(2..3, "é")]),
            ("aaa", "aaaa", vec![TextEdit::new(3..3, "a")]),
            ("è", "é", vec![TextEdit::new(0..2, "é")]),
            ("", "", vec![]),
        ] {
            let e = Edited::between(old, new);
            assert_eq!((e.text.as_str(), e.edits), (new, edits));
        }
    }
}
