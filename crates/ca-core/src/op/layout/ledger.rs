//! Batches of links as the energy ledger sees them.

use super::Ports;
use crate::law::Idle;
use crate::numeric::Real;
use crate::op::{Energies, Law};
use alloc::vec::Vec;

/// Links whose ends are consecutive: link i joins `ends[0] + i` and `ends[1] + i`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Row {
    /// number of links
    pub len: usize,
    /// ends of the first link
    pub ends: [usize; 2],
}

impl Row {
    /// Finds the row at the start of `ends`. Padding entries, from a MAT to itself with coefficients of 0, may be part
    /// of it.
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

    /// Finds two rows, one after the other. A folded row continues in the next lane where one ends.
    pub fn two(ends: &[[u32; 2]], n_mat: usize) -> [Row; 2] {
        let first = Row::of(ends, n_mat);
        [first, Row::of(&ends[first.len..], n_mat)]
    }
}

/// Functions that the ledger calls for the links of a batch.
#[derive(Clone, Copy)]
pub struct AccountFns<R: Real = f64> {
    /// energy stored between two ticks, and lost in one
    pub energies: Energies<R>,
    /// elongations at which a contact exerts no force
    pub idle: Idle<R>,
}

/// A batch of links as the ledger sees it.
#[derive(Clone, Copy)]
pub struct Account<R: Real = f64> {
    /// index of the batch in the list of passes that sum forces
    pub op: usize,
    /// number of links
    pub n: usize,
    /// how the links measure
    pub ports: Ports,
    /// first link in [`LinkArrays::ends`](super::LinkArrays::ends), and its number in the ledger
    pub first: usize,
    /// first coefficient, as in the pass
    pub coef: usize,
    /// first number of memory, as in the pass
    pub mem: usize,
    /// first index into `LinkState::tap`, as in the pass
    pub tap: usize,
    /// law of the links
    pub law: &'static Law,
    /// true if the energy identity holds exactly, so that the scheme makes no energy
    pub linear: bool,
    /// true if a coefficient may change while the scene plays, or an end is a moving point
    pub live: bool,
    /// the two rows that the links begin with; empty for links that do not measure on a line
    pub rows: [Row; 2],
    /// functions of the law
    pub fns: AccountFns<R>,
}

/// Data of the ledger.
#[derive(Clone, Default)]
pub struct LedgerLayout<R: Real = f64> {
    /// batches of links, in the order of the passes
    pub accounts: Vec<Account<R>>,
    /// coefficient of the first MAT with weight
    pub weight: usize,
    /// true if a coefficient of a MAT, or its weight, may change while the scene plays
    pub live: bool,
}
