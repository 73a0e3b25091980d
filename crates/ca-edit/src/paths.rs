//! Sets of paths of keys.

use crate::tree::Statement;
use std::collections::HashSet;

/// Paths, and everything below them.
#[derive(Default)]
pub(crate) struct Paths(HashSet<Vec<String>>);

impl Paths {
    pub fn add(&mut self, path: Vec<String>) {
        self.0.insert(path);
    }

    /// Returns whether `path` is one of the paths, or below one.
    pub fn cover(&self, path: &[String]) -> bool {
        (0..=path.len()).any(|n| self.0.contains(&path[..n]))
    }

    pub fn cover_statement(&self, s: &Statement) -> bool {
        match s {
            Statement::Header(h) => self.cover(&h.words.iter().map(|w| w.name.clone()).collect::<Vec<_>>()),
            Statement::Pair(p) => self.cover(&p.path),
        }
    }
}

impl FromIterator<Vec<String>> for Paths {
    fn from_iter<I: IntoIterator<Item = Vec<String>>>(all: I) -> Paths {
        Paths(all.into_iter().collect())
    }
}
