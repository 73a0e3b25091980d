//! Which kernel runs a law: one for each form of a batch of links, chosen at load.

use super::{Form, Gauge, Kernel, gather, gauge, pair_set, run, space, wide};
use crate::law::Phi;

/// The kernel of a law for one form of a dipole.
pub(crate) fn kernel<P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Kernel {
    if form.set {
        return if form.tap {
            wide::wide::<pair_set::All<P, C, M, true>>
        } else {
            wide::wide::<pair_set::All<P, C, M, false>>
        };
    }
    match (form.gauge, form.stride > 0, form.offset, form.tap) {
        (Gauge::Line, false, false, false) => gather::gather::<P, C, M, false, false>,
        (Gauge::Line, false, false, true) => gather::gather::<P, C, M, false, true>,
        (Gauge::Line, false, true, false) => gather::gather::<P, C, M, true, false>,
        (Gauge::Line, false, true, true) => gather::gather::<P, C, M, true, true>,
        (Gauge::Line, true, false, _) => wide::wide::<run::Run<P, C, M, false>>,
        (Gauge::Line, true, true, _) => wide::wide::<run::Run<P, C, M, true>>,
        (Gauge::Along, _, _, false) => space::space::<P, gauge::Along, C, M, false>,
        (Gauge::Along, _, _, true) => space::space::<P, gauge::Along, C, M, true>,
        (Gauge::Radial, _, _, false) => space::space::<P, gauge::Radial, C, M, false>,
        (Gauge::Radial, _, _, true) => space::space::<P, gauge::Radial, C, M, true>,
    }
}
