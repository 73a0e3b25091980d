//! "Did you mean": the candidate nearest to a word, and lists of words in a message.
//!
//! A difference of case alone always wins. A candidate that differs in more than a third of the word is not suggested,
//! because a wrong suggestion is worse than none. Without the feature `parse` only the first rule applies, because the
//! edit distance comes from a dependency.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Number of candidates that are compared, so that a suggestion does not take seconds.
const MOST: usize = 10_000;

/// Returns the candidate nearest to `word`, if one is near, and the earlier of two equally near.
pub fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut best: Option<(usize, &'a str)> = None;
    for c in candidates.take(MOST) {
        let d = distance(word, c);
        if d.is_some_and(|d| best.is_none_or(|b| d < b.0)) {
            best = d.map(|d| (d, c));
        }
    }
    best.map(|b| b.1)
}

/// Joins words in backticks with commas.
pub fn ticked<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
}

/// Joins the first twelve words as [`ticked`] does, with a mark if there are more.
pub fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let mut list: Vec<String> = words.map(|w| format!("`{w}`")).collect();
    if list.len() > 12 {
        list.truncate(12);
        list.push("…".into());
    }
    list.join(", ")
}

fn distance(a: &str, b: &str) -> Option<usize> {
    if a.eq_ignore_ascii_case(b) {
        return Some(usize::from(a != b));
    }
    edits(a, b)
}

#[cfg(feature = "parse")]
fn edits(a: &str, b: &str) -> Option<usize> {
    // protects against a hostile word of a megabyte, whose table would be the square of that
    if a.len().max(b.len()) > 64 {
        return None;
    }
    let d = strsim::damerau_levenshtein(&a.to_ascii_lowercase(), &b.to_ascii_lowercase());
    let longest = a.chars().count().max(b.chars().count());
    (d <= (longest / 3).max(usize::from(longest > 2))).then_some(d + 1)
}

#[cfg(not(feature = "parse"))]
fn edits(_: &str, _: &str) -> Option<usize> {
    None
}
