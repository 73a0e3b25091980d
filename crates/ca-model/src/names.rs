//! Names: whether all differ, without a tree of them.

use hashbrown::HashSet;

/// True where no name is there twice.
pub fn all_differ<'n>(mut names: impl Iterator<Item = &'n str>) -> bool {
    let mut seen = HashSet::with_capacity(names.size_hint().0);
    names.all(|name| seen.insert(name))
}
