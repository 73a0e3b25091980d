//! Resolves names of several instances: `note[*].key` names one module of each.

use crate::model::{LARGEST, Model};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

pub(super) struct Counts(BTreeMap<String, usize>);

/// Returns the names that a name of several instances stands for, such as `key[*].hammer` or `key[1..3].f`. Returns
/// `None` for a name that stands for itself, or for an instance that does not exist.
pub fn instances(model: &Model, name: &str) -> Option<Vec<String>> {
    let mut all = Vec::new();
    Counts::of(model).each(String::new(), name.trim(), &mut all).ok().filter(|many| *many)?;
    Some(all)
}

impl Counts {
    pub fn of(model: &Model) -> Counts {
        let mut counts = BTreeMap::new();
        // each instance is a group
        let instances = model.groups.iter().filter_map(|g| g.name.strip_suffix(']')?.rsplit_once('['));
        for (name, index) in instances {
            let n: &mut usize = counts.entry(name.into()).or_default();
            *n = (*n).max(index.parse().map_or(0, |i: usize| i + 1));
        }
        Counts(counts)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds all names for `done` followed by `rest`. Returns true if an index is not literal, such as `*` or `-1`.
    pub fn each(&self, mut done: String, rest: &str, all: &mut Vec<String>) -> Result<bool, Outside> {
        let index =
            rest.split_once('[').and_then(|(word, r)| r.split_once(']').map(|(index, rest)| (word, index, rest)));
        let Some((word, index, rest)) = index.filter(|_| all.len() < LARGEST) else {
            all.push(done + rest);
            return Ok(false);
        };
        done += word;
        let Some(n) = self.0.get(done.as_str()).copied() else {
            return self.each(format!("{done}[{index}]"), rest, all);
        };
        let Some(which) = indices(index.trim(), n) else {
            return Err(Outside { name: done, index: index.into(), n });
        };
        let mut many = which.first().map(ToString::to_string).as_deref() != Some(index);
        for i in which {
            many |= self.each(format!("{done}[{i}]"), rest, all)?;
        }
        Ok(many)
    }
}

/// Index without an instance.
pub(super) struct Outside {
    pub name: String,
    pub index: String,
    pub n: usize,
}

/// Returns the instances that an index selects; `None` if it is invalid or out of range.
fn indices(index: &str, n: usize) -> Option<Vec<usize>> {
    let one = |t: &str| -> Option<usize> {
        let i: i64 = t.trim().parse().ok()?;
        usize::try_from(if i < 0 { i + n as i64 } else { i }).ok().filter(|i| *i <= n)
    };
    if index == "*" {
        return Some((0..n).collect());
    }
    if let Some((a, b)) = index.split_once("..") {
        let (a, b) = (one(a)?, one(b)?);
        return (a < b).then(|| (a..b).collect());
    }
    one(index).filter(|i| *i < n).map(|i| Vec::from([i]))
}
