//! "Did you mean": the candidate nearest to a word, and lists of words in a message.
//!
//! Decides that a difference of case alone always wins, and that further away than a third of the word nothing is
//! suggested: a wrong suggestion costs more than none. Without the feature `parse` only the first rule holds, because
//! the edit distance comes from a dependency.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// A list that is longer is not looked through to its end: nobody waits seconds for a guess.
const MOST: usize = 10_000;

/// The candidate nearest to `word`, if one is near; the earlier of two equally near.
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

/// These words in ticks, with commas between them.
pub fn ticked<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
}

/// The first twelve words, and a mark if there are more.
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
    // a hostile word of a megabyte is near to nothing, and not worth a square table
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
