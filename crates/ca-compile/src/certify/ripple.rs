//! How far the energy of a scene with distances in space may rise above itself, left alone.
//!
//! Without viscosity the scheme is symplectic, so beside the energy H of the ledger it keeps another one for as long as
//! anyone plays, and does not drift; what is left to bound is the difference of the two. With λ = ω²T² of a mode:
//! - What it keeps is Σ ρ Hᵢ over the modes, ρ = θ/sin θ with 2 sin(θ/2) = √λ. Lengths couple the modes, and
//!   energy that goes from a mode of λ to one without stiffness is ρ times as large in the ledger.
//! - A spring under tension holds sideways, with its energy before and after a tick in the mean and not in the product:
//!   ¼ dᵀKd above what the mode keeps, up to λ/2 of its energy in motion, which is at most 1/(1 − λ/4) of all of it.
//!
//! Together a factor of no more than (1 + λ/4)/(1 − λ/4), with the largest λ; viscosity only takes away from it.
//! Decides on a number that is proven for small motions over one that is measured: it is reached by a mass between two
//! springs drawn out of nothing, and rises with λ, so that a higher rate mends it.

use crate::certify::exact::Exact;
use crate::net::Pruned;
use ca_core::{Certificate, Level};

/// The share by which the energy of small motions may rise above what it was at any time before. `None` where nothing
/// is known of it: an implicit contact keeps the energy of the ledger, and so moves the one that the rest keeps.
pub fn ripple(net: &Pruned, exact: Option<&Exact>, cert: &Certificate) -> Option<f64> {
    if cert.level != Level::Linearised || net.is_composed() || net.lias.iter().any(|l| !l.law.stage.is_explicit()) {
        return None;
    }
    let most = match cert.largest {
        Some((_, most)) => most,
        None if cert.bound < 4.0 => cert.bound,
        None => exact?.largest(cert, false)?.1,
    };
    (most < 4.0).then(|| 2.0 * most / (4.0 - most))
}
