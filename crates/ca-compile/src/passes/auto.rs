//! Auto: with `method = "auto"` of the model, each link whose force is not linear gets the energy-consistent method of its
//! kind, unless its line names a method.
//!
//! Later passes refuse such a method where the links around do not allow it. A refused link stays explicit, and the
//! network is made again without it. A second list of their conditions here could differ from theirs.

use crate::findings::no_method;
use crate::net::{Chosen, LiaNode, NetItem, Wired};
use crate::options::Options;
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use ca_core::Type;
use ca_core::internal::live::Source;
use ca_core::internal::tuning::Method;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Methods that keep the energy of a link, in the order in which a kind is asked for them.
const CONSISTENT: [&str; 2] = ["stable", "newton"];

/// Largest number of pairs of a set that become single links, so that their energy is conserved.
pub const MOST_PAIRS: usize = 512;

/// Largest number of networks; then all links stay explicit.
const TRIES: usize = 8;

/// Items whose links `auto` leaves explicit, each with the reason.
#[derive(Default)]
pub struct Left {
    items: Chosen,
    tries: usize,
    all: bool,
}

impl Left {
    /// Collects the links of a network that have to stay explicit. Returns true if the network has to be made again.
    pub fn learn(&mut self, chosen: &mut Chosen, diags: &Diags) -> bool {
        self.tries += 1;
        let mut refused = core::mem::take(chosen);
        let any = !refused.is_empty();
        refused.retain(|_, why| !why.is_empty());
        let open = !refused.is_empty() || any && diags.has_errors();
        // an error that names none of them may still come of one
        self.all |= open && (refused.is_empty() || self.tries >= TRIES);
        self.items.append(&mut refused);
        open
    }

    /// Notes the links that stay explicit.
    pub fn report(&self, model: &Model, items: &[NetItem], diags: &mut Diags) {
        for (item, why) in &self.items {
            let item = &items[*item as usize];
            let d = Diag::note("N207", format!("`auto` leaves `{}` explicit: {why}", item.name));
            let d = d.at(model.items[item.model].name_span, "explicit");
            diags.push(d.help("to accept this, write `method = \"ca\"` for the link"));
        }
    }
}

/// Gives links the energy-consistent method of their kind.
pub fn choose(model: &Model, net: &mut Wired, left: &Left, options: &Options) {
    if left.all || !net.media.iter().any(|m| m.method == Method::Auto) {
        return;
    }
    let mut chosen = Chosen::new();
    let mut last: Option<[Arc<[Source]>; 2]> = None;
    for i in 0..net.lias.len() {
        let l = &net.lias[i];
        let Some((at, word)) = method_of(model, net, l).filter(|_| !left.items.contains_key(&l.item)) else { continue };
        // takes from before have explicit sets and quadripoles
        if !options.is_since(8) && (l.sets.is_some() || l.onto.is_some()) {
            continue;
        }
        if let Some(why) = without(net, l) {
            chosen.insert(l.item, why);
            continue;
        }
        let known = last.as_ref().filter(|[old, _]| Arc::ptr_eq(old, &l.values));
        let values = known.map_or_else(
            || {
                let mut values = l.values.to_vec();
                values[at] = Source::Const(word as f64);
                Arc::from(values)
            },
            |[_, new]| new.clone(),
        );
        last = Some([l.values.clone(), values.clone()]);
        chosen.insert(l.item, String::new());
        net.lias[i].values = values;
    }
    net.chosen = chosen;
}

/// The place of the parameter `method` of a link, and the number of the word that `auto` gives it.
fn method_of(model: &Model, net: &Wired, l: &LiaNode) -> Option<(usize, usize)> {
    let at = l.kind.param("method").filter(|at| *at < l.values.len())?;
    let Type::Choice(words) = l.kind.params[at].ty else { return None };
    let word = CONSISTENT.iter().find_map(|c| words.iter().position(|w| w == c))?;
    let item = &net.items[l.item as usize];
    let written = model.items[item.model].args.iter().any(|e| e.key == "method");
    // groups at the gesture rate lack such a method
    if written || net.medium_of(item.group).method != Method::Auto {
        return None;
    }
    let slow = |m: u32| net.medium_of(net.mats[m as usize].group).slow;
    (!l.ends.into_iter().any(|e| net.under(e).into_iter().any(slow))).then_some((at, word))
}

/// Returns why such a method cannot be used for a link, although its kind knows it.
fn without(net: &Wired, l: &LiaNode) -> Option<String> {
    if let Some([first, second]) = l.sets.as_deref() {
        let pairs = if second.is_empty() { first.len() * (first.len() - 1) / 2 } else { first.len() * second.len() };
        return Some(format!("it is a set of {pairs} pairs; up to {MOST_PAIRS} become single links"));
    }
    let modal = |m: u32| net.medium_of(net.mats[m as usize].group).method == Method::Modal;
    let at_modes = l.onto.is_some() && l.all_ends().any(|e| net.under(e).into_iter().any(modal));
    at_modes.then(|| "it acts on two worlds, and a mass of one has `method = \"modal\"`".into())
}

/// The links that passes refuse: an error for a method that its author wrote, a reason for `auto`.
pub struct Refusals<'m> {
    model: &'m Model,
    chosen: Chosen,
    reported: BTreeSet<u32>,
}

impl<'m> Refusals<'m> {
    /// Takes the choices of a network, which [`Refusals::end`] gives back.
    pub fn begin(model: &'m Model, net: &mut Wired) -> Refusals<'m> {
        Refusals { model, chosen: core::mem::take(&mut net.chosen), reported: BTreeSet::new() }
    }

    /// Gives the choices back.
    pub fn end(self, net: &mut Wired) {
        net.chosen = self.chosen;
    }

    /// Returns whether `auto` chose the method of an item.
    pub fn is_chosen(&self, item: u32) -> bool {
        self.chosen.contains_key(&item)
    }

    /// Returns whether the item was refused before.
    pub fn knows(&self, item: u32) -> bool {
        self.reported.contains(&item)
    }

    /// Refuses the method of an item, once.
    pub fn refuse(
        &mut self,
        items: &[NetItem],
        item: u32,
        (title, label, help): (String, &str, &str),
        diags: &mut Diags,
    ) {
        if !self.reported.insert(item) {
            return;
        }
        match self.chosen.get_mut(&item) {
            Some(why) => *why = title,
            None => diags.push(no_method(&self.model.items[items[item as usize].model], title, label, help)),
        }
    }
}
