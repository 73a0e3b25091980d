//! Computes how many modules and instances a line of `[use]` makes at least, before any is made.
//!
//! The lower bound comes from the text alone. A part in another file, and a part whose number of instances is a
//! parameter, count once. A bound above the limit is refused at once; insertion stops the cases that it misses.

use super::expander::{Expander, Home, Size};
use crate::diag::Diag;
use crate::model::{LARGEST, Part, Use, Value};
use alloc::format;

impl Expander<'_> {
    /// Returns true if `n` instances of `part` fit into the model; otherwise reports it.
    pub fn fits(&mut self, u: &Use, name: &str, n: Option<usize>, part: &Part, home: &Home) -> bool {
        let [modules, instances] = self.size(part, home).map(|one| one.saturating_mul(n.unwrap_or(1)));
        let there = self.model.items.len().max(self.model.groups.len());
        if modules.max(instances).saturating_add(there) < LARGEST {
            return true;
        }
        let title = format!("`{name}` would make {instances} instances with {modules} modules");
        let at = [&u.n, &u.part, &u.file].into_iter().flatten().next().map_or(u.span, |e| e.span);
        let help = format!("a model must have fewer than {LARGEST} of each; for real time, a few thousand");
        self.diags.push(Diag::error("E027", title).at(at, "too many").help(help));
        false
    }

    fn size(&mut self, part: &Part, home: &Home) -> Size {
        let key = (home.file.clone(), part.name.clone());
        if let Some(known) = self.sizes.get(&key) {
            return *known;
        }
        // ends the recursion of a part that uses itself, which is refused elsewhere
        self.sizes.insert(key.clone(), [0, 0]);
        let mut all: Size = [part.body.items.len(), 1 + part.body.groups.len()];
        for u in &part.body.uses {
            let inner = match (&u.part, &u.file) {
                (Some(e), None) => {
                    home.model.parts.iter().find(|p| matches!(&e.value, Value::Text(t) if t.trim() == p.name))
                }
                _ => None,
            };
            let one = inner.map_or([0, 1], |p| self.size(p, home));
            let n = match u.n.as_ref().map(|e| &e.value) {
                Some(Value::Num(v)) if *v >= 1.0 => *v as usize,
                _ => 1,
            };
            for (sum, one) in all.iter_mut().zip(one) {
                *sum = sum.saturating_add(one.saturating_mul(n));
            }
        }
        self.sizes.insert(key, all);
        all
    }
}
