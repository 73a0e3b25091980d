//! Sets: a contact between all pairs of two sets of masses in space as one module.
//!
//! The law must measure distances, without memory and without force at a distance. There must be enough pairs, and no
//! output may read a single pair, since forces are not stored per pair. `auto` makes single links of few pairs. Otherwise
//! each pair becomes a module. With
//! [`KernelClass::Reference`](crate::KernelClass) it always does, as the plain form to compare with.

use crate::connect::wiring::Wiring;
use crate::net::{End, LiaNode, Measure};
use crate::options::Options;
use crate::passes::auto::MOST_PAIRS;
use alloc::collections::BTreeSet;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::tuning::Method;
use ca_core::{Law, Name};
use ca_model::part::instances;
use ca_model::select::parse;
use ca_model::{Model, Value};

/// Smallest number of pairs per member. Below it single links are cheaper: three grains, or one mass against many.
const FEWEST: f64 = 1.5;

/// Returns the names that outputs and probes refer to.
pub fn output_names(model: &Model, options: &Options) -> BTreeSet<String> {
    let from = model.items.iter().flat_map(|i| &i.args).filter(|e| e.key == "from");
    let texts = from.filter_map(|e| if let Value::Text(t) = &e.value { Some(t) } else { None });
    let probes = options.probes.iter().flat_map(|p| instances(model, p).unwrap_or_else(|| alloc::vec![p.clone()]));
    texts.cloned().chain(probes).filter_map(|t| parse(&t).ok()).map(|s| s.name).collect()
}

impl Wiring<'_> {
    /// Adds item `id` as one module between all pairs of `a` and `b`, if possible.
    pub(super) fn set(&mut self, id: u32, law: &'static Law, (a, b): (&[End], &[End]), options: &Options) -> bool {
        let item = &self.net.items[id as usize];
        let (name, kind) = (item.name.clone(), item.kind);
        let arg = |key: &str| kind.param(key).and_then(|i| item.args[i].num());
        let mats = |ends: &[End]| {
            let mat = |e: &End| {
                if let End::Mat(m) = e { Some(*m).filter(|m| self.net.mats[*m as usize].in_space()) } else { None }
            };
            ends.iter().map(mat).collect::<Option<Vec<u32>>>()
        };
        let (Some(first), Some(second)) = (mats(a), mats(b)) else { return false };
        let itself = first == second;
        let (n, m) = (first.len() as f64, second.len() as f64);
        let (pairs, members) = if itself { (0.5 * n * (n - 1.0), n) } else { (n * m, n + m) };
        let enough = pairs >= FEWEST * members;
        let by_auto = options.is_since(8) && self.net.medium_of(item.group).method == Method::Auto;
        let written = |key: &str| self.entry(id, key).is_some();
        // Other methods need memory per pair. A module joined to itself is left to the pairs, which report it.
        let plain = law.contact && law.mem == 0 && arg("method").is_none_or(|m| m == 0.0);
        if !plain
            || !enough
            || by_auto && pairs <= MOST_PAIRS as f64
            || self.output_names.contains(&*name)
            || ["along", "onto", "soften", "l0"].into_iter().any(written)
        {
            return false;
        }
        let mut all = BTreeSet::new();
        let twice = |m: &u32| !all.insert(*m);
        if first.iter().chain(if itself { &[] } else { &second[..] }).any(twice) {
            return false;
        }
        let ends = [a[0], if itself { a[1] } else { b[0] }];
        let sets = Some(Arc::new([first, if itself { Vec::new() } else { second }]));
        let values = self.net.own_values(kind.params.len());
        let number = self.net.lias.len() as u32;
        self.net.families.insert_links(&name, alloc::vec![number]);
        let (measure, onto, l0, soften) = (Measure::Radial, None, None, 0.0);
        self.net.lias.push(LiaNode {
            name: Name::from(&name),
            kind,
            law,
            values,
            ends,
            measure,
            onto,
            sets,
            l0,
            soften,
            item: id,
        });
        true
    }
}
