//! Checks names for duplicates by hashing, without a sorted map.

use hashbrown::HashSet;

/// Returns true if all names differ.
pub fn all_differ<'n>(mut names: impl Iterator<Item = &'n str>) -> bool {
    let mut seen = HashSet::with_capacity(names.size_hint().0);
    names.all(|name| seen.insert(name))
}
