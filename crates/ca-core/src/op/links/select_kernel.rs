//! Selects the kernel of a law for each form of a batch of links, at load.
//!
//! Vector kernels ([`band`](super::band), [`folded`](super::folded), [`radial`](super::radial)) are for `f64` alone.

use super::band::Banded;
use super::folded::Folded;
use super::fused::Fused;
use super::radial::{Blocks, by_law};
use super::{fan, gather, measure, pair_set, run, space};
use crate::law::Phi;
use crate::numeric::{Precision, Real};
use crate::op::{Band, Form, Hub, Integrate, Kernel, MeasureKind, wide};
use core::any::Any;

pub(crate) fn kernel<R: Real, P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Kernel<R> {
    if form.set {
        return if form.tap {
            wide::wide::<R, pair_set::All<P, C, M, true>>
        } else {
            wide::wide::<R, pair_set::All<P, C, M, false>>
        };
    }
    // evaluated at compile time, so that other number types do not instantiate these kernels
    if const { matches!(R::PRECISION, Precision::Double) && P::WIDE } && form.folded {
        if let Some(kernel) = folded::<P, C, M>(form).and_then(as_real) {
            return kernel;
        }
    }
    if P::WIDE && form.hub != Hub::None {
        return if form.offset {
            wide::wide::<R, fan::Fan<P, C, M, true>>
        } else {
            wide::wide::<R, fan::Fan<P, C, M, false>>
        };
    }
    if P::LINEAR && M == 0 {
        match (form.integrate, form.offset) {
            (Integrate::No, _) => {}
            (Integrate::Mas, false) => return wide::wide::<R, Fused<P, C, M, false, false>>,
            (Integrate::Mas, true) => return wide::wide::<R, Fused<P, C, M, true, false>>,
            (Integrate::Cel, false) => return wide::wide::<R, Fused<P, C, M, false, true>>,
            (Integrate::Cel, true) => return wide::wide::<R, Fused<P, C, M, true, true>>,
        }
    }
    if const { matches!(R::PRECISION, Precision::Double) && !(P::CONTACT && M == 0) }
        && form.measure == MeasureKind::Radial
    {
        if let Some(kernel) = as_real(radial::<P, C, M>(form)) {
            return kernel;
        }
    }
    match (form.measure, form.stride > 0, form.offset, form.tap) {
        (MeasureKind::Line, false, false, false) => gather::gather::<R, P, C, M, false, false>,
        (MeasureKind::Line, false, false, true) => gather::gather::<R, P, C, M, false, true>,
        (MeasureKind::Line, false, true, false) => gather::gather::<R, P, C, M, true, false>,
        (MeasureKind::Line, false, true, true) => gather::gather::<R, P, C, M, true, true>,
        (MeasureKind::Line, true, false, _) => wide::wide::<R, run::Run<P, C, M, false>>,
        (MeasureKind::Line, true, true, _) => wide::wide::<R, run::Run<P, C, M, true>>,
        (MeasureKind::Along, _, _, false) => space::space::<R, P, measure::Along, C, M, false>,
        (MeasureKind::Along, _, _, true) => space::space::<R, P, measure::Along, C, M, true>,
        (MeasureKind::Radial, _, _, false) => space::space::<R, P, measure::Radial, C, M, false>,
        (MeasureKind::Radial, _, _, true) => space::space::<R, P, measure::Radial, C, M, true>,
    }
}

/// Converts a kernel over `f64` to one over `R`, if `R` is `f64`.
fn as_real<R: Real>(kernel: Kernel) -> Option<Kernel<R>> {
    let any: &dyn Any = &kernel;
    any.downcast_ref::<Kernel<R>>().copied()
}

/// Returns the kernel of a folded row or mesh. Only these forms have one, so that other passes are not instantiated.
fn folded<P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Option<Kernel> {
    let alone = form.band == Band::None;
    Some(match (form.integrate, form.offset) {
        (Integrate::No, _) => return None,
        (Integrate::Mas, false) if !alone => wide::widest::<Banded<P, C, M, false, false>>,
        (Integrate::Mas, true) if !alone => wide::widest::<Banded<P, C, M, true, false>>,
        (Integrate::Cel, false) if !alone => wide::widest::<Banded<P, C, M, false, true>>,
        (Integrate::Cel, true) if !alone => wide::widest::<Banded<P, C, M, true, true>>,
        (Integrate::Mas, false) => wide::widest::<Folded<P, C, M, false, false>>,
        (Integrate::Mas, true) => wide::widest::<Folded<P, C, M, true, false>>,
        (Integrate::Cel, false) => wide::widest::<Folded<P, C, M, false, true>>,
        (Integrate::Cel, true) => wide::widest::<Folded<P, C, M, true, true>>,
    })
}

fn radial<P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Kernel {
    // evaluated at compile time, so that a law instantiates only one of the two
    if const { P::WIDE && M == 0 } {
        return if form.tap { wide::widest::<Blocks<P, C, M, true>> } else { wide::widest::<Blocks<P, C, M, false>> };
    }
    if form.tap { by_law::<P, C, M, true> } else { by_law::<P, C, M, false> }
}
