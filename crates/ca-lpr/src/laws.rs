//! Laws of the core with the kernels of quadripoles.
//!
//! A record is a copy of the record of the core (bounds, energy, tables) with another kernel, so each law is written
//! once. Laws of `kind!` are here; [`crate::quadripoles`] makes the others. If the core has a cheaper law for some
//! parameters, its quadripole is used; without one the general law runs.

use crate::op::kernel;
use crate::{coulomb, params};
use ca_core::internal::op::{Cheaper, LawEntry, LawFns};
use ca_core::internal::phi;
use ca_core::{Law, Phi, Real};

/// Makes records and the list of pairs from name, code, law of the core, its [`Phi`](ca_core::Phi) and cheaper laws.
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

        /// Returns the functions of these laws over `R`.
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

/// Makes the law of a contact, chosen by its method: the explicit one, and one that keeps its energy in ψ.
macro_rules! contact {
    ($name:ident $explicit:ident, $stable:ident $code:literal $of:path, $params:path) => {
        pub static $name: Law = Law {
            cheaper: Cheaper {
                simpler: |p| (params::is($params, p, "method", "stable") == Some(true)).then_some(&$stable),
                variants: &[&$stable],
            },
            ..$explicit
        };
        static $stable: Law = Law { code: $code, ..$of };
    };
}

contact!(CONTACT_BUT BUT, BUT_STABLE "LPR_BUT stable" phi::but::STABLE3D, params::BUT);
contact!(CONTACT_HRZ HRZ, HRZ_STABLE "LPR_HRZ stable" phi::hrz::STABLE3D, params::HRZ);

/// Law of LPR_BOW, chosen by curve and method. Its `method` has fewer choices than that in BOW.
pub static BOW: Law = Law {
    code: "LPR_BOW smooth",
    fns: LawFns { kernel: kernel::<f64, phi::bow::Smooth, _, _>, ..phi::bow::SMOOTH.fns },
    cheaper: Cheaper {
        simpler: |p| {
            let is = |name: &str, word: &str| params::is(params::BOW, p, name, word) == Some(true);
            if is("method", "set-valued") && is("curve", "coulomb") {
                return Some(&coulomb::LAW);
            }
            // the core would read this method as its choice of method
            let method = params::BOW.iter().position(|p| p.name == "method")?;
            quadripole((phi::bow::SMOOTH.cheaper.simpler)(p.get(..method)?)?)
        },
        variants: &[&PIECEWISE, &COULOMB, &TABLE, &coulomb::LAW],
    },
    ..phi::bow::SMOOTH
};

/// Returns the functions over `R` of the quadripole of a law.
pub fn fns<R: Real, P: Phi<C, M> + 'static, const C: usize, const M: usize>() -> LawFns<R> {
    LawFns { kernel: kernel::<R, P, C, M>, ..LawFns::of::<P, C, M>() }
}

/// Returns the functions over `R` of the laws of this file.
pub fn laws<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
    let more = [
        (BOW.code, fns::<R, phi::bow::Smooth, _, _>()),
        (BUT_STABLE.code, phi::but::stable3d()),
        (HRZ_STABLE.code, phi::hrz::stable3d()),
    ];
    own().into_iter().chain(more)
}

/// Returns the quadripole of `law`, if there is one here.
pub fn quadripole(law: &'static Law) -> Option<&'static Law> {
    QUADRIPOLES.iter().find(|(of, _)| core::ptr::eq(*of, law)).map(|(_, own)| *own)
}
