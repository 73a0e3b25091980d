//! Verifies live parameters: what a change reads and writes ([`Controls`](crate::live::Controls)).

use super::super::known::Known;
use super::{Verified, Wrong, each, ensure, in_bounds};
use crate::kind::Role;
use crate::live::{LiveImplicit, LiveItem, LiveModule, LiveTable, Loader};
use crate::method::implicit::Inertia;
use crate::op::layout::Layout;

/// Number of values that the modules of a generator pass to a law of REF: its parameters up to the rest length.
const OF_GENERATOR: usize = 4;

/// Verifies the live plan of a layout; `live` is the number of live coefficients of its state.
pub(super) fn plan(plan: &LiveTable, l: &Layout, live: usize, known: &Known) -> Verified {
    let coefs = plan.coefs.len() == live && each(&plan.coefs, l.counts.n_coef);
    ensure(coefs && each(&plan.driven_coefs, live), "a live coefficient does not exist")?;
    plan.items.iter().try_for_each(|i| item(i, live, known))?;
    plan.implicit.as_ref().map_or(Ok(()), |a| implicit(a, live))
}

fn item(item: &LiveItem, live: usize, known: &Known) -> Verified {
    let follows = item.follows.iter().all(|(arg, ..)| *arg < item.args.len());
    ensure(follows, "a live item follows a parameter that it does not have")?;
    let derived = item.generator.is_none() || item.args.len() == item.kind.params.len();
    ensure(derived, "a live item and its kind differ in parameters")?;
    item.modules.iter().try_for_each(|m| module(m, item, live, known))
}

fn module(m: &LiveModule, item: &LiveItem, live: usize, known: &Known) -> Verified {
    ensure(each(&m.to, live), "a live module sets a coefficient that does not exist")?;
    let least = match m.loader {
        Loader::Times(_) => 0,
        Loader::Mat(spec, _) => known.mat(spec.code).map_or(usize::MAX, |(kind, _)| kind.params.len()),
        // trailing parameters may be left out
        Loader::Lia(law) if law.implicit => 0,
        // the index of a table follows the parameters
        Loader::Lia(law) => {
            let of_kind = matches!(item.kind.role, Role::Lia(_)).then_some(item.kind.params.len());
            of_kind.unwrap_or(OF_GENERATOR) + usize::from(law.table.is_some())
        }
    };
    ensure(m.values.len() >= least, "a live module has fewer values than parameters")
}

fn implicit(a: &LiveImplicit, live: usize) -> Verified {
    let Inertia { pattern, mobility, links, entries, pairs: _ } = &a.made;
    ensure(super::arrays::pattern(pattern), "the live pattern of implicit links is not a factor")?;
    let rows = mobility.len();
    let entry = entries.iter().all(|(row, _)| (*row as usize) < rows);
    let link = links.iter().all(|(_, [first, n])| in_bounds(*first as usize, *n as usize, entries.len()));
    ensure(rows == pattern.size() && entry && link, "the live factor of implicit links differs in its rows")?;
    if in_bounds(a.first as usize, a.made.numbers(), live) {
        Ok(())
    } else {
        Err(Wrong("a live factor is beyond the coefficients"))
    }
}
