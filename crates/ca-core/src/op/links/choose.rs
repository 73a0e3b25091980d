//! Which kernel runs a law: one for each form of a batch of links, chosen at load.

#[cfg(not(any(single, dual)))]
use super::band::Banded;
#[cfg(not(any(single, dual)))]
use super::folded::Folded;
use super::fused::Fused;
#[cfg(not(any(single, dual)))]
use super::radial::{Blocks, by_law};
use super::{fan, gather, measure, pair_set, run, space};
use crate::law::Phi;
#[cfg(not(any(single, dual)))]
use crate::op::Band;
use crate::op::{Form, Hub, Integrate, Kernel, MeasureKind, wide};

/// The kernel of a law for one form of a dipole.
pub(crate) fn kernel<P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Kernel {
    if form.set {
        return if form.tap {
            wide::wide::<pair_set::All<P, C, M, true>>
        } else {
            wide::wide::<pair_set::All<P, C, M, false>>
        };
    }
    // others are never asked for, so that their passes are not made
    #[cfg(not(any(single, dual)))]
    if P::WIDE && form.folded {
        let alone = form.band == Band::None;
        match (form.integrate, form.offset) {
            (Integrate::No, _) => {}
            (Integrate::Mas, false) if !alone => return wide::widest::<Banded<P, C, M, false, false>>,
            (Integrate::Mas, true) if !alone => return wide::widest::<Banded<P, C, M, true, false>>,
            (Integrate::Cel, false) if !alone => return wide::widest::<Banded<P, C, M, false, true>>,
            (Integrate::Cel, true) if !alone => return wide::widest::<Banded<P, C, M, true, true>>,
            (Integrate::Mas, false) => return wide::widest::<Folded<P, C, M, false, false>>,
            (Integrate::Mas, true) => return wide::widest::<Folded<P, C, M, true, false>>,
            (Integrate::Cel, false) => return wide::widest::<Folded<P, C, M, false, true>>,
            (Integrate::Cel, true) => return wide::widest::<Folded<P, C, M, true, true>>,
        }
    }
    if P::WIDE && form.hub != Hub::None {
        return if form.offset {
            wide::wide::<fan::Fan<P, C, M, true>>
        } else {
            wide::wide::<fan::Fan<P, C, M, false>>
        };
    }
    if P::LINEAR && M == 0 {
        match (form.integrate, form.offset) {
            (Integrate::No, _) => {}
            (Integrate::Mas, false) => return wide::wide::<Fused<P, C, M, false, false>>,
            (Integrate::Mas, true) => return wide::wide::<Fused<P, C, M, true, false>>,
            (Integrate::Cel, false) => return wide::wide::<Fused<P, C, M, false, true>>,
            (Integrate::Cel, true) => return wide::wide::<Fused<P, C, M, true, true>>,
        }
    }
    #[cfg(not(any(single, dual)))]
    if form.measure == MeasureKind::Radial && !(P::CONTACT && M == 0) {
        // known when this is compiled, so that only one of both is made for a law
        if const { P::WIDE && M == 0 } {
            return if form.tap {
                wide::widest::<Blocks<P, C, M, true>>
            } else {
                wide::widest::<Blocks<P, C, M, false>>
            };
        }
        return if form.tap { by_law::<P, C, M, true> } else { by_law::<P, C, M, false> };
    }
    match (form.measure, form.stride > 0, form.offset, form.tap) {
        (MeasureKind::Line, false, false, false) => gather::gather::<P, C, M, false, false>,
        (MeasureKind::Line, false, false, true) => gather::gather::<P, C, M, false, true>,
        (MeasureKind::Line, false, true, false) => gather::gather::<P, C, M, true, false>,
        (MeasureKind::Line, false, true, true) => gather::gather::<P, C, M, true, true>,
        (MeasureKind::Line, true, false, _) => wide::wide::<run::Run<P, C, M, false>>,
        (MeasureKind::Line, true, true, _) => wide::wide::<run::Run<P, C, M, true>>,
        (MeasureKind::Along, _, _, false) => space::space::<P, measure::Along, C, M, false>,
        (MeasureKind::Along, _, _, true) => space::space::<P, measure::Along, C, M, true>,
        (MeasureKind::Radial, _, _, false) => space::space::<P, measure::Radial, C, M, false>,
        (MeasureKind::Radial, _, _, true) => space::space::<P, measure::Radial, C, M, true>,
    }
}
