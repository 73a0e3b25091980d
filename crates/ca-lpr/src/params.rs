//! Parameters of LPR kinds, made at compile time from the parameters of their law, and the end of their page.
//!
//! Parameters, docs and alternatives are copied from the law, so they cannot differ. `along` is removed, since each
//! port measures in the dimensions of its world. So is `method`: contacts and LPR_BOW have a shorter one. `onto` follows, since a
//! law knows its parameters by number. They are not in [`crate::kinds`], because the law of LPR_BOW looks up its
//! parameters and a kind contains its law.

use ca_core::internal::op::ParamBinding;
use ca_core::internal::phi;
use ca_core::{Kind, Need, Param, Type};

/// End of each page: what all LPR have in common.
pub const PAGE: &str = " Its elongation `e` is the sum of the elongations of two pairs of ends, `between` and `onto`, \
                        each a distance in space or a difference on a line. The same force acts on both pairs, so \
                        energy crosses and none is created. The elongation of the second pair, or of the pair on a \
                        line if only one is in space, is 0 at rest. The kind without `LPR_` describes the law.";

const ONTO: Param = Param::new(
    "onto",
    Type::Between,
    Need::Required,
    "the two ends of the second pair, in the other world; each side is one end, or as many ends as `between` makes \
     links",
);

const fn is_kept(p: &Param) -> bool {
    !matches!(p.ty, Type::Direction) && !matches!(p.name.as_bytes(), b"method" | b"theta")
}

/// Counts the parameters of the LPR of `kind`.
pub const fn count(kind: &Kind) -> usize {
    let (mut n, mut i) = (1, 0);
    while i < kind.params.len() {
        n += is_kept(&kind.params[i]) as usize;
        i += 1;
    }
    n
}

/// Makes the parameters of the LPR of `kind`.
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

/// Replaces the last parameters of `all` by `more`.
const fn with<const N: usize>(mut all: [Param; N], more: &[Param]) -> [Param; N] {
    let mut i = 0;
    while i < more.len() {
        all[N - more.len() + i] = more[i];
        i += 1;
    }
    all
}

const DRY: Param = Param::new(
    "method",
    Type::Choice(&["ca", "set-valued"]),
    Need::Default(0.0),
    "ca: explicit; set-valued, for the curve coulomb: while it sticks, the sum of both elongations does not change",
);

const STABLE: Param = Param::new(
    "method",
    Type::Choice(&["ca", "stable"]),
    Need::Default(0.0),
    "ca: explicit; stable: conserves energy at any stiffness, by the method `stable3d` of a contact in space",
);

/// Parameters of LPR_BUT.
pub const BUT: &[Param] = {
    const ALL: [Param; count(&phi::but::KIND) + 1] = with(params(&phi::but::KIND), &[STABLE]);
    &ALL
};

/// Parameters of LPR_HRZ.
pub const HRZ: &[Param] = {
    const ALL: [Param; count(&phi::hrz::KIND) + 1] = with(params(&phi::hrz::KIND), &[STABLE]);
    &ALL
};

/// Returns whether a parameter of a kind, a choice, is fixed at a word.
pub fn is(params: &[Param], values: &[ParamBinding], name: &str, word: &str) -> Option<bool> {
    let at = params.iter().position(|p| p.name == name)?;
    let (Type::Choice(words), Some(v)) = (params[at].ty, values.get(at)?.number()) else { return None };
    Some(words.get(v as usize) == Some(&word))
}

/// Parameters of LPR_BOW.
pub const BOW: &[Param] = {
    const ALL: [Param; count(&phi::bow::KIND) + 1] = with(params(&phi::bow::KIND), &[DRY]);
    &ALL
};
