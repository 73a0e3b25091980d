//! Specialise: replaces each law by the cheapest one for its parameters, and drops links without effect. Parameters
//! that may change while playing are never specialised.

use crate::net::Wired;
use alloc::format;
use alloc::vec::Vec;
use ca_core::ParamBinding;
use ca_core::internal::live::Source;
use ca_core::internal::op::loaded;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Specialises the laws of all links and drops links without effect.
pub fn specialise(model: &Model, net: &mut Wired, diags: &mut Diags) {
    // Result for the previous link: generators make thousands of links with the same values.
    let mut last: Option<(u32, alloc::sync::Arc<[Source]>, &'static ca_core::Law, bool)> = None;
    let mut lias = core::mem::take(&mut net.lias);
    let mut reported = None;
    let mut zero = 0;
    let mut keep = Vec::with_capacity(lias.len());
    for l in &mut lias {
        if let Some((item, values, law, nothing)) = &last {
            if *item == l.item && (alloc::sync::Arc::ptr_eq(values, &l.values) || values[..] == l.values[..]) {
                l.law = law;
                keep.push(!nothing);
                zero += usize::from(*nothing);
                continue;
            }
        }
        let item = &net.items[l.item as usize];
        // Any value of a generator may be live, since a slot may depend on every argument.
        let generated = matches!(item.kind.role, ca_core::Role::Generator(_));
        let fixed: Vec<ParamBinding> = l
            .values
            .iter()
            .map(|s| match (s, s.get(&item.slots)) {
                (Source::Slot(i), Some(_)) if item.follows.iter().any(|f| generated || f.0 == *i as usize) => {
                    ParamBinding::Live
                }
                (_, Some(v)) => ParamBinding::At(v),
                (_, None) => ParamBinding::Absent,
            })
            .collect();
        while let Some(simpler) = (l.law.cheaper.simpler)(&fixed) {
            l.law = simpler;
        }
        let live = fixed.contains(&ParamBinding::Live);
        let values: Vec<Option<f64>> = l.values.iter().map(|s| s.get(&item.slots)).collect();
        let nothing = !live && l.law.linear && loaded(l.law, &values, net.tick_dt).iter().all(|c| *c == 0.0);
        if nothing {
            zero += 1;
            if reported != Some(l.item) && !generated {
                reported = Some(l.item);
                let span = model.items[item.model].name_span;
                let d = Diag::warning("W106", format!("`{}` has no effect: its parameters are 0", l.name));
                diags.push(d.at(span, "left out").help("remove it, or use a parameter with `live = true`"));
            }
        }
        keep.push(!nothing);
        last = Some((l.item, l.values.clone(), l.law, nothing));
    }
    if zero > 0 {
        net.left_out.push(format!("{zero} links without effect"));
        net.drop_links(lias, &keep);
    } else {
        net.lias = lias;
    }
}

impl Wired {
    /// Keeps the links marked in `keep` and renumbers references to them.
    pub fn drop_links(&mut self, lias: Vec<crate::net::LiaNode>, keep: &[bool]) {
        let mut renumber = alloc::vec![u32::MAX; lias.len()];
        let mut n = 0;
        for (r, k) in renumber.iter_mut().zip(keep) {
            if *k {
                *r = n;
                n += 1;
            }
        }
        self.lias = lias.into_iter().zip(keep).filter(|(_, k)| **k).map(|(l, _)| l).collect();
        self.families.renumber(&renumber);
        for o in &mut self.outs {
            if let crate::net::OutputTap::ForceOf(l) = &mut o.tap {
                *l = renumber[*l as usize];
            }
        }
        // Outputs of dropped links are dropped; their channels stay.
        self.outs.retain(|o| o.tap != crate::net::OutputTap::ForceOf(u32::MAX));
        // Probes of dropped links leave no gap in the numbering.
        let (mut was, mut next) = (None, self.channels.len() as u32);
        for o in self.outs.iter_mut().filter(|o| o.item.is_none()) {
            next += u32::from(was.is_some_and(|w| w != o.channel));
            was = Some(o.channel);
            o.channel = next;
        }
    }
}
