//! What every LPR has in common: its parameters, made of those of its law at compile time, and the end of its page.
//!
//! Decides that parameters, their docs and their alternatives are those of the law, copied as data, so that they cannot
//! fall apart; what is taken away is `along`, since both ports measure what their world is made of, and `method`, of which
//! only LPR_BOW has one; what is added is `onto`, behind the others, since a law knows its parameters by number. They stand
//! here and not with the kinds, since the law of LPR_BOW looks up its own, and a kind holds its law.

use ca_core::internal::phi;
use ca_core::{Kind, Need, Param, Type};

/// What every LPR is, behind what its law is.
pub const PAGE: &str = " Its elongation `e` is the sum of those of two pairs of ends, `between` and `onto`, each a distance \
                        in space or a difference on a line; the same force pulls at both, so energy crosses and none is made. \
                        The second port, or the one on a line where only one is in space, is slack at rest. For the law itself \
                        see the kind without `LPR_`.";

const ONTO: Param = Param::new(
    "onto",
    Type::Between,
    Need::Required,
    "the two ends of the second port, in the other world; each side one end, or as many as `between` makes links",
);

const fn is_kept(p: &Param) -> bool {
    // methods other than the explicit one know of one port
    !matches!(p.ty, Type::Direction) && !matches!(p.name.as_bytes(), b"method" | b"theta")
}

/// How many parameters the LPR of `kind` has.
pub const fn count(kind: &Kind) -> usize {
    let (mut n, mut i) = (1, 0);
    while i < kind.params.len() {
        n += is_kept(&kind.params[i]) as usize;
        i += 1;
    }
    n
}

/// They.
pub const fn params<const N: usize>(kind: &Kind) -> [Param; N] {
    let mut all = [ONTO; N];
    let (mut n, mut i) = (0, 0);
    while i < kind.params.len() {
        if is_kept(&kind.params[i]) {
            all[n] = kind.params[i];
            n += 1;
        }
        i += 1;
    }
    all
}

/// They, the last of them from `more`.
const fn with<const N: usize>(mut all: [Param; N], more: &[Param]) -> [Param; N] {
    let mut i = 0;
    while i < more.len() {
        all[N - more.len() + i] = more[i];
        i += 1;
    }
    all
}

/// The methods of LPR_BOW.
const DRY: Param = Param::new(
    "method",
    Type::Choice(&["ca", "set-valued"]),
    Need::Default(0.0),
    "ca: explicit; set-valued, of the curve coulomb: what sticks stands still in the sum of both",
);

/// The parameters of LPR_BOW.
pub const BOW: &[Param] = {
    const ALL: [Param; count(&phi::bow::KIND) + 1] = with(params(&phi::bow::KIND), &[DRY]);
    &ALL
};
