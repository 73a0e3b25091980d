//! LIA: the laws of interaction between two MATs, one file each. [`crate::law`] defines the shape of a law. The files
//! are public, since other crates provide other forms of the same laws (LPR).

use crate::kind::{ANY, Kind, Need, POSITIVE, Param, Type, Unit};
use crate::law::{Bound, Phi};
use crate::numeric::Real;
use crate::op::{Law, LawEntry, LawFns, Laws, ParamBinding};

pub mod att;
pub mod bow;
pub mod but;
pub mod cub;
pub mod fro;
pub mod hrz;
pub mod implicit;
pub mod lnl;
pub mod plk;
pub mod pow;
pub mod ref_;
pub mod res;

/// Lists the files that have a kind and a law, in the order of the documentation.
macro_rules! files {
    ($($file:ident)*) => {
        /// All LIA kinds.
        pub const KINDS: &[&Kind] = &[$(&$file::KIND),*];

        /// Returns the functions of all laws over `R`, for [`Scene::bind`](crate::Scene::bind).
        pub fn laws<R: Real>() -> Laws<R> {
            Laws::default()$(.with($file::laws()))*.with(implicit::laws())
        }
    };
}

// To add a law: add its file, its `mod` above and its name here.
files! { res fro ref_ but cub pow hrz lnl plk att bow }

pub use ref_::KIND as REF;

/// Parameter `between`: the two ends of a link.
pub const BETWEEN: Param =
    Param::new("between", Type::Between, Need::Required, "the two ends, first and second; lists are paired one to one");
/// Parameter `l0`: the rest length.
pub const L0: Param =
    Param::number("l0", Unit::METRE, ANY, Need::Optional, "length without force; if left out, the distance at rest")
        .for_good();

/// Parameter `along`: a direction, for links with one end on a line, or with a difference along one direction of space.
pub const ALONG: Param = Param::new(
    "along",
    Type::Direction,
    Need::Optional,
    "in space: the difference along this direction counts, as on a line, instead of the distance",
);
/// Parameter `soften`: the softening length.
pub const SOFTEN: Param = Param::number(
    "soften",
    Unit::METRE,
    POSITIVE,
    Need::Default(0.0),
    "in space: the distance D becomes sqrt(D² + soften²), so that the ends may pass through each other",
)
.for_good();

crate::choice::choice! {
    /// Method of a one-sided spring.
    pub enum ContactMethod {
        /// explicit
        Ca = "ca",
        /// discrete gradient of the potential
        Stable = "stable",
        /// energy quadratisation with an auxiliary variable
        Stable3d = "stable3d",
    }
}

crate::choice::choice! {
    /// Method of a law that acts on both sides.
    pub enum ElasticMethod {
        /// explicit
        Ca = "ca",
        /// discrete gradient of the potential
        Stable = "stable",
    }
}

crate::choice::choice! {
    /// Side of its threshold on which a one-sided spring acts.
    pub enum Sense {
        /// below: keeps apart
        Outside = "outside",
        /// above: contains
        Inside = "inside",
    }
}
crate::choice::choice! {
    /// Pairing of two lists of ends.
    pub enum Pairs {
        /// one to one
        Each = "each",
        /// every pair, once
        All = "all",
    }
}

impl Sense {
    /// Returns +1 if it acts below its threshold, −1 above.
    pub fn sign(self) -> f64 {
        match self {
            Sense::Outside => 1.0,
            Sense::Inside => -1.0,
        }
    }
}

/// Parameter [`ContactMethod`].
pub const METHOD: Param = Param::new(
    "method",
    Type::Choice(ContactMethod::WORDS),
    Need::Default(0.0),
    "ca: explicit; stable: conserves energy at any stiffness; stable3d: the same by the method for space, which stable \
     uses there",
);

/// Parameter [`ElasticMethod`].
pub const ELASTIC_METHOD: Param = Param::new(
    "method",
    Type::Choice(ElasticMethod::WORDS),
    Need::Default(0.0),
    "ca: explicit; stable: conserves energy at any stiffness, on a line or with `along`",
);

fn by_potential(p: &[ParamBinding], at: usize) -> bool {
    p.get(at).and_then(|p| p.number()).is_some_and(|word| ElasticMethod::of(word) == ElasticMethod::Stable)
}

/// Parameter `d` of a contact: its threshold.
pub const THRESHOLD: Param =
    Param::number("d", Unit::METRE, ANY, Need::Default(0.0), "threshold of the signed distance second − first");

/// Parameter [`Sense`] of a contact.
pub const SENSE: Param = Param::new(
    "sense",
    Type::Choice(Sense::WORDS),
    Need::Default(0.0),
    "outside: keeps the ends apart; inside: contains the second",
);

/// Parameter [`Pairs`].
pub const PAIRS: Param = Param::new(
    "pairs",
    Type::Choice(Pairs::WORDS),
    Need::Default(0.0),
    "each: lists are paired one to one; all: every pair, once",
);

/// Returns the linear energy between two ticks, with the negative mass of the damper (docs/numerics.md §2.1).
#[inline(always)]
fn linear_stored<R: Real>(k: R, z: R, e0: R, e1: R) -> R {
    R::of(0.5) * k * e0 * e1 - R::of(0.25) * z * (e1 - e0) * (e1 - e0)
}

/// Returns the heat of a linear damper in one tick (docs/numerics.md §2.1); `z` is in N per m/tick.
#[inline(always)]
fn linear_lost<R: Real>(z: R, e: [R; 3]) -> R {
    R::of(0.25) * z * (e[2] - e[0]) * (e[2] - e[0])
}
