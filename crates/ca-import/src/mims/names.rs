//! Names that are valid in a model file, and notes without repetition.
//!
//! A name is unique among modules, parameters and groups. MIMS separates these and accepts a label twice, but renaming
//! is harmless because nothing refers to links and ports. A note that applies to many lines is given once, with a
//! count.

use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_model::diag::{Diag, Diags};

/// All names given so far, each with the next number to try.
#[derive(Clone, Debug, Default)]
pub(super) struct Names(BTreeMap<String, usize>);

impl Names {
    /// Returns `wanted`, or `wanted_2`, `wanted_3` … if that is taken.
    pub fn unique(&mut self, wanted: &str) -> String {
        let Some(&next) = self.0.get(wanted) else {
            self.0.insert(wanted.to_string(), 2);
            return wanted.to_string();
        };
        let mut free = next;
        while self.0.contains_key(&format!("{wanted}_{free}")) {
            free += 1;
        }
        self.0.insert(wanted.to_string(), free + 1);
        let name = format!("{wanted}_{free}");
        self.0.insert(name.clone(), 2);
        name
    }
}

/// Makes a name of ASCII letters, digits and `_` that does not begin with a digit (which would be a quantity).
pub(super) fn legal(label: &str) -> String {
    let mut name: String = label.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        name.insert(0, '_');
    }
    name
}

/// Returns the common beginning of a row of labels: `low` for `low_m0` to `low_m149`. Empty if there is none.
pub(super) fn stem(labels: &[&str]) -> String {
    let Some((first, rest)) = labels.split_first() else { return String::new() };
    let same = |n: usize, other: &str| first.bytes().zip(other.bytes()).take(n).take_while(|(a, b)| a == b).count();
    let n = rest.iter().fold(first.len(), |n, other| same(n, other));
    let common = first.get(..n).unwrap_or("").trim_end_matches(|c: char| c.is_ascii_digit());
    common.rfind('_').and_then(|at| common.get(..at)).filter(|s| !s.is_empty()).unwrap_or(common).to_string()
}

/// Notes by key, in the order of their first place.
#[derive(Debug, Default)]
pub(super) struct Losses {
    index: BTreeMap<String, usize>,
    list: Vec<(Diag, usize)>,
}

impl Losses {
    /// Adds a note for a new key; otherwise counts it.
    pub fn add(&mut self, key: &str, diag: Diag) {
        if let Some(&i) = self.index.get(key) {
            self.list[i].1 += 1;
        } else {
            self.index.insert(key.to_string(), self.list.len());
            self.list.push((diag, 1));
        }
    }

    pub fn into_diags(self, diags: &mut Diags) {
        for (mut diag, n) in self.list {
            if n > 1 {
                diag.title = format!("{}, {n} times", diag.title);
            }
            diags.push(diag);
        }
    }
}
