//! The laws of the core with the kernels of quadripoles: law list × op.
//!
//! Decides that a record is that of the core, bounds, energy, table and all, with another kernel, so that no law is
//! written twice. Here are those of `kind!`; the others are made by [`crate::quadripoles`]. Where the core knows
//! a cheaper law for some parameters, its quadripole here takes the place; one that had no quadripole would not be
//! taken, and the general law would run.

use crate::op::kernel;
use crate::{dry, params};
use ca_core::internal::op::{Cheaper, LawEntry, LawFns};
use ca_core::internal::phi;
use ca_core::{Law, Phi, Real, Type};

/// Records `name`, `code`, law of the core, its [`Phi`](ca_core::Phi), its cheaper laws here; and the list of pairs.
macro_rules! laws {
    ($($name:ident $code:literal $of:path, $phi:ty $(: $($variant:ident)+)?;)*) => {
        $(
            pub static $name: Law = Law {
                code: $code,
                cheaper: Cheaper {
                    simpler: |p| quadripole(($of.cheaper.simpler)(p)?),
                    variants: &[$($(&$variant),+)?],
                },
                fns: LawFns { kernel: kernel::<f64, $phi, _, _>, ..$of.fns },
                ..$of
            };
        )*

        /// Their functions over `R`.
        fn own<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
            [$(($code, fns::<R, $phi, _, _>())),*]
        }

        static QUADRIPOLES: &[(&Law, &Law)] = &[$((&$of, &$name)),*];
    };
}

laws! {
    RES "LPR_RES" phi::res::LAW, phi::res::Res;
    FRO "LPR_FRO" phi::fro::LAW, phi::fro::Fro;
    REF "LPR" phi::ref_::LAW, phi::ref_::Ref: RES ZONLY;
    ZONLY "LPR_FRO" phi::ref_::ZONLY, phi::fro::Fro;
    BUT "LPR_BUT" phi::but::LAW, phi::but::But;
    CUB "LPR_CUB" phi::cub::LAW, phi::cub::Cub;
    HRZ "LPR_HRZ" phi::hrz::LAW, phi::hrz::Hrz;
    LNL "LPR_LNL" phi::lnl::LAW, phi::lnl::Lnl: SPRING FRICTION;
    SPRING "LPR_LNL spring" phi::lnl::SPRING, phi::lnl::TableSpring;
    FRICTION "LPR_LNL friction" phi::lnl::FRICTION, phi::lnl::TableFriction;
    PLK "LPR_PLK" phi::plk::LAW, phi::plk::Plk;
    ATT "LPR_ATT" phi::att::LAW, phi::att::Att;
    PIECEWISE "LPR_BOW piecewise" phi::bow::PIECEWISE, phi::bow::Piecewise;
    COULOMB "LPR_BOW coulomb" phi::bow::COULOMB, phi::bow::Coulomb;
    TABLE "LPR_BOW table" phi::bow::TABLE, phi::lnl::TableFriction;
}

/// That of LPR_BOW, by its words: the curve, and the method, which has fewer words than that of BOW.
pub static BOW: Law = Law {
    code: "LPR_BOW smooth",
    fns: LawFns { kernel: kernel::<f64, phi::bow::Smooth, _, _>, ..phi::bow::SMOOTH.fns },
    cheaper: Cheaper {
        simpler: |p| {
            let position = |name: &str| params::BOW.iter().position(|p| p.name == name);
            let is = |name: &str, word: &str| {
                let at = position(name)?;
                let (Type::Choice(words), Some(v)) = (params::BOW[at].ty, p.get(at)?.number()) else {
                    return None;
                };
                Some(words.get(v as usize) == Some(&word))
            };
            if is("method", "set-valued") == Some(true) && is("curve", "coulomb") == Some(true) {
                return Some(&dry::LAW);
            }
            // the law of the core would take the method for one of its own
            let method = position("method")?;
            quadripole((phi::bow::SMOOTH.cheaper.simpler)(p.get(..method)?)?)
        },
        variants: &[&PIECEWISE, &COULOMB, &TABLE, &dry::LAW],
    },
    ..phi::bow::SMOOTH
};

/// The functions over `R` of the quadripole of a law.
pub fn fns<R: Real, P: Phi<C, M> + 'static, const C: usize, const M: usize>() -> LawFns<R> {
    LawFns { kernel: kernel::<R, P, C, M>, ..LawFns::of::<P, C, M>() }
}

/// The functions over `R` of the laws of this file.
pub fn laws<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
    let bow = [(BOW.code, fns::<R, phi::bow::Smooth, _, _>())];
    own().into_iter().chain(bow)
}

/// The law of this crate that is the form of `law`.
pub fn quadripole(law: &'static Law) -> Option<&'static Law> {
    QUADRIPOLES.iter().find(|(of, _)| core::ptr::eq(*of, law)).map(|(_, own)| *own)
}
