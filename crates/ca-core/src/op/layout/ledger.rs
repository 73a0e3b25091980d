//! Ledger: the batches of links as the energy ledger sees them.

use super::Ports;
use crate::law::Idle;
use crate::numeric::Real;
use crate::op::{Energies, Law};
use alloc::vec::Vec;

/// Links whose ends stand one behind the other: link i joins `ends[0] + i` and `ends[1] + i`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Row {
    /// how many
    pub len: usize,
    /// ends of the first
    pub ends: [usize; 2],
}

impl Row {
    /// The first of some links with these ends, among `n_mat` MATs. A place that no link takes stands there as one from a
    /// MAT to itself, whose coefficients are 0, so that it may as well join others.
    pub fn of(ends: &[[u32; 2]], n_mat: usize) -> Row {
        let some = ends.iter().enumerate().find(|(_, e)| e[0] != e[1]);
        let Some([Some(p), Some(q)]) = some.map(|(k, e)| e.map(|m| (m as usize).checked_sub(k))) else {
            return Row::default();
        };
        let fits = |(i, e): &(usize, &[u32; 2])| {
            let here = [p + i, q + i];
            e.map(|m| m as usize) == here || (e[0] == e[1] && here.iter().all(|m| *m < n_mat))
        };
        Row { len: ends.iter().enumerate().take_while(fits).count(), ends: [p, q] }
    }

    /// Two of them, the second behind the first: a folded row goes on in the next lane where one ends.
    pub fn two(ends: &[[u32; 2]], n_mat: usize) -> [Row; 2] {
        let first = Row::of(ends, n_mat);
        [first, Row::of(&ends[first.len..], n_mat)]
    }
}

/// The functions that the ledger calls for the links of a batch.
#[derive(Clone, Copy)]
pub struct AccountFns<R: Real = f64> {
    /// what it stores between two ticks, and loses in one
    pub energies: Energies<R>,
    /// elongations at which a contact has no force
    pub idle: Idle<R>,
}

/// A batch of links as the ledger sees it.
#[derive(Clone, Copy)]
pub struct Account<R: Real = f64> {
    /// its place in the list of passes that sum forces
    pub op: usize,
    /// number of links
    pub n: usize,
    /// how they measure
    pub ports: Ports,
    /// first of them in [`LinkArrays::ends`](super::LinkArrays::ends), which is also their number in the ledger
    pub first: usize,
    /// first coefficient, as in a pass
    pub coef: usize,
    /// first number of memory, as in a pass
    pub mem: usize,
    /// first index into `LinkState::tap`, as in a pass
    pub tap: usize,
    /// the law of the links
    pub law: &'static Law,
    /// true where the identity holds exactly, so that nothing can be made
    pub linear: bool,
    /// true where a coefficient may change while playing, or an end is a point that moves
    pub live: bool,
    /// the first of its links, as far as their ends stand in two rows; none where they measure otherwise than on a line
    pub rows: [Row; 2],
    /// the functions of the law
    pub fns: AccountFns<R>,
}

/// What the ledger needs to find its way.
#[derive(Clone, Default)]
pub struct LedgerPlan<R: Real = f64> {
    /// batches of links, in the order of the passes
    pub accounts: Vec<Account<R>>,
    /// coefficient of the first weighed MAT
    pub weight: usize,
    /// true where a coefficient of a MAT, or its weight, may change while playing
    pub live: bool,
}
