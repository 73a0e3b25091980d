//! Certify: what can be said of stability before anything moves, and which module to blame.
//!
//! Four steps: [`accumulate`](accumulate::accumulate) adds up what pulls at each mass, [`bound`](bound::bound) bounds the
//! largest eigenvalue from both sides, [`decide`](decide::decide) settles it, [`report`](report::report) says so.
//!
//! Decides for the cheap bounds of docs/numerics.md §1.3 first (two sums per module, no matrix), which settle almost
//! every scene. With h = T²k + 2Tz for each link and d_i their sum at mass i: d_i/m_i ≥ 4 is certainly unstable and
//! this module is the cause; the smaller of the Gershgorin and the link bound below 4 is certainly stable. Between
//! them, and with the feature `analysis`, one sparse factorisation decides. Contacts and other non-linear links are
//! judged by rule (docs/numerics.md §3.2) and said to be.

mod accumulate;
mod blame;
mod bound;
mod decide;
#[cfg_attr(not(feature = "analysis"), path = "no_exact.rs")]
mod exact;
mod keys;
mod negative;
mod reach;
mod report;
mod rigid;
mod ripple;
mod rules;
mod together;

use crate::net::Pruned;
use crate::options::Effort;
use blame::overflow;
use ca_core::internal::scene::certificate::Rules;
use ca_core::{Certificate, Level};
use ca_model::Model;
use ca_model::diag::Diags;

/// Judges the network; warnings name the module and what would mend it.
pub fn certify(model: &Model, net: &Pruned, effort: Effort, diags: &mut Diags) -> Certificate {
    let sums = accumulate::accumulate(net);
    if overflow(model, net, &sums, diags) {
        return Certificate::default();
    }
    let bounds = bound::bound(net, &sums);
    let decided = decide::decide(net, &sums, &bounds, effort);
    report::report(model, net, &sums, &bounds, &decided, effort == Effort::Largest, diags)
}

/// The certificate of a scene and of its groups at the gesture rate together, from one of each by itself: what crosses between them is
/// exact, if not `compensated`, so that each is as stable as alone with what the other holds of it fixed (docs/numerics.md §5.4).
pub fn beside(own: Certificate, slow: Certificate, compensated: bool) -> Certificate {
    let nearer = slow.bound > own.bound;
    let closer = slow.margin() < own.margin();
    let largest = match (own.largest, slow.largest) {
        (Some(a), Some(b)) => Some(if b.1 > a.1 { b } else { a }),
        (a, b) => a.or(b),
    };
    let depth = match (own.rules.depth, slow.rules.depth) {
        (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
        (a, b) => a.or(b),
    };
    let stiffest = if slow.rules.contact > own.rules.contact { slow.rules.stiffest } else { own.rules.stiffest };
    let decides = if closer || own.rules.decides.is_empty() { slow.rules.decides } else { own.rules.decides };
    let open = own.rules.open.into_iter().chain(slow.rules.open).collect();
    Certificate {
        level: own.level.max(slow.level).max(if compensated { Level::NotProven } else { Level::Proven }),
        bound: own.bound.max(slow.bound),
        lower: own.lower.max(slow.lower),
        exact: own.exact || slow.exact,
        largest,
        // of a scene that is left alone
        ripple: None,
        worst: if nearer { slow.worst } else { own.worst },
        rules: Rules {
            contact: own.rules.contact.max(slow.rules.contact),
            stiffest,
            closed: own.rules.closed.max(slow.rules.closed),
            decides,
            open,
            depth,
            friction: own.rules.friction.max(slow.rules.friction),
        },
        ..own
    }
}
