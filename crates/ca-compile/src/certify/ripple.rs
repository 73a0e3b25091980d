//! Ripple: bounds the rise of the energy of a scene with distances in space, left alone.
//!
//! Without viscosity the scheme is symplectic: it conserves an energy near the energy H of the ledger, without drift.
//! The ripple bounds the difference of the two. With λ = ω²T² of a mode:
//! - The conserved energy is Σ ρ Hᵢ over the modes, ρ = θ/sin θ with 2 sin(θ/2) = √λ. Lengths couple the modes. Energy
//!   that moves from a mode of λ to one without stiffness is ρ times as large in the ledger.
//! - A spring under tension acts sideways too, with the mean of its energies before and after a tick instead of the
//!   product: ¼ dᵀKd more than the mode conserves. This is up to λ/2 of its kinetic energy, which is at most
//!   1/(1 − λ/4) of its total.
//!
//! Together the factor is at most (1 + λ/4)/(1 − λ/4), with the largest λ; viscosity only lowers the energy. The bound
//! is proven for small motions, not measured. A mass between two springs stretched from almost zero length reaches it.
//! It rises with λ, so that a higher rate lowers it.

use crate::certify::exact::Exact;
use crate::net::Pruned;
use ca_core::{Certificate, Level};

/// Returns the share by which the energy of small motions may exceed any earlier value. Returns `None` if it is
/// unknown: an implicit contact conserves the energy of the ledger, and so changes the one that the other modules
/// conserve.
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
