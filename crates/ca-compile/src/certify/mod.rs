//! Certify: judges stability before the scene runs, and names the module responsible.
//! [`accumulate`](accumulate::accumulate) adds up the links at each mass, [`bound`](bound::bound) bounds the largest
//! eigenvalue from both sides, [`decide`](decide::decide) decides, and [`report`](report::report) writes the
//! certificate.
//!
//! The cheap bounds of docs/numerics.md §1.3 come first: two sums per module, without a matrix, decide almost every
//! scene. With h = T²k + 2Tz for each link and the sum d_i at mass i, d_i/m_i ≥ 4 is certainly unstable, and this
//! module is the cause. If the smaller of the Gershgorin and the link bound is below 4, the scene is certainly stable.
//! Between them one sparse factorisation decides (feature `analysis`). Contacts and other non-linear links are judged
//! by rule (docs/numerics.md §3.2), and the certificate says so.

mod accumulate;
mod bound;
mod cause;
mod decide;
mod device_keys;
#[cfg_attr(not(feature = "analysis"), path = "no_exact.rs")]
mod exact;
mod lpr_support;
mod max_elongation;
mod negative;
mod report;
mod ripple;
mod rules;
mod simultaneous_contacts;

use crate::net::Pruned;
use crate::options::Effort;
use ca_core::internal::scene::certificate::Rules;
use ca_core::{Certificate, Level};
use ca_model::Model;
use ca_model::diag::Diags;
use cause::overflow;

/// Judges the network; warnings name the module and a fix.
pub fn certify(model: &Model, net: &Pruned, effort: Effort, diags: &mut Diags) -> Certificate {
    let sums = accumulate::accumulate(net);
    if overflow(model, net, &sums, diags) {
        return Certificate::default();
    }
    let bounds = bound::bound(net, &sums);
    let decided = decide::decide(net, &sums, &bounds, effort);
    report::report(model, net, &sums, &bounds, &decided, effort == Effort::Largest, diags)
}

/// Combines the certificates of the sound side and of the groups at the gesture rate. Unless `compensated`, the border
/// is exact, and each side is as stable as alone with the other side fixed (docs/numerics.md §5.4).
pub fn combine(own: Certificate, slow: Certificate, compensated: bool) -> Certificate {
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
        // Only for a scene without external motion.
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
