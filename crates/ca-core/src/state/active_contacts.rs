//! Links solved together in a tick, as data. The modules of `method` collect them, and `method/together.rs` solves.
//!
//! Each contact is one record with its entries of the solver vectors: few contacts are active at once, and the numbers
//! of one are used together. Capacity for all is allocated at load.

use crate::numeric::{Real, Table};
use alloc::vec::Vec;

/// Push of a contact as a curve over the motion of the coming tick (`method/cluster.rs`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve<R: Real> {
    /// push \[N\] and its derivative \[N/m\], without viscosity
    pub push: AtChange<R, [R; 2]>,
    /// potential before the tick less that after it \[J\]
    pub released: AtChange<R, R>,
    /// change of penetration over two ticks at which Newton's method begins \[m\]
    pub begin: fn(&ActiveContact<R>) -> R,
}

/// Function of coefficients, tables, the penetration before the tick \[m\] and its change over two ticks \[m\].
pub(crate) type AtChange<R, T> = fn(&[R; COEFS], &[Table<R>], R, R) -> T;

/// Number of coefficients of a law whose push is a curve.
pub(crate) const COEFS: usize = 5;

/// Role of a contact in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Part {
    /// touches
    #[default]
    Acts,
    /// touches nothing, but another contact may push it
    Waits,
    /// is left out, since it would pull
    LeftOut,
}

/// One pair of ends of a link, and how its penetration depends on them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Port<R: Real = f64> {
    /// first slot of each end
    pub ends: [u32; 2],
    /// axes of an end: 1 on a line, 3 in space
    pub axes: usize,
    /// gradient of the penetration at the second end; at the first it is the negative
    pub g: [R; 3],
}

/// One link that acts in this tick. For friction, γ and ψ are 0, and the elongation is a penetration that shrinks.
#[derive(Clone, Copy, Debug, Default)]
// in this order: what sweeps read stands in the first cache lines
#[repr(C)]
pub(crate) struct ActiveContact<R: Real = f64> {
    /// role in this tick
    pub part: Part,
    /// true if it may only push
    pub clip: bool,
    /// true if it is opening and still stores energy
    pub open: bool,
    /// push \[N\]; inside `conjugate` the search direction
    pub p: R,
    /// change of penetration over two ticks, first assumed, then found \[m\]
    pub at: R,
    /// change of penetration over two ticks that all other forces would cause \[m\]
    pub free: R,
    /// mobility of its ends \[m/N\]
    pub own: R,
    /// penetration before the tick, of a curve \[m\]
    pub from: R,
    /// viscosity \[N per m/tick\]
    pub z: R,
    /// its ends
    pub port: Port<R>,
    /// its push, if that is not linear in the coming motion; none for links that use ψ and for friction
    pub curve: Option<&'static Curve<R>>,
    /// second pair of ends, of a quadripole
    pub onto: Option<Port<R>>,
    /// coefficients of the law of a curve
    pub coef: [R; COEFS],
    /// residual \[m\]; in sweeps 1/scale of the motion \[1/m\]
    pub r: R,
    /// twice the change of penetration in the tick before, at which sweeps begin; `free` for linear links \[m\]
    pub went: R,
    /// push per change of penetration over two ticks \[N/m\]: γ²/4 + z/2, or the slope h′ of a curve
    pub stiff: R,
    /// push without motion \[N\]: γψ; of a curve, the push that its tangent has without motion
    pub bias: R,
    /// first number of its memory
    pub mem: usize,
    /// index into [`LinkState::tap`](crate::state::LinkState::tap) if an output or the ledger reads its force
    pub tap: Option<usize>,
    /// sign that converts its push into the tension of a link
    pub side: R,
    /// change of ψ per change of penetration \[√(N/m)\]
    pub gamma: R,
    /// ψ before the tick \[√J\]; the energy stored is ψ²/2
    pub psi: R,
    /// diagonal of the system \[m/N\]
    pub diag: R,
    /// unknown of the system: push beyond `bias` \[N\]
    pub y: R,
    /// solution: push, change of penetration and `y`, whose derivatives take one more step
    pub found: [R; 3],
    /// values at the start of a step: change of penetration, push, and the excess of the curve over it
    pub last: [R; 3],
    /// system matrix times the search direction \[m\]
    pub q: R,
}

/// The entries of a cluster in the list of contacts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Region {
    /// place of its first entry
    pub first: usize,
    /// number of entries it has room for
    pub room: usize,
    /// number of contacts that are active in this tick
    pub n: usize,
}

/// Contacts of this tick.
#[derive(Clone, Debug, Default)]
pub struct ActiveContacts<R: Real = f64> {
    /// clusters, whose contacts are solved together
    pub(crate) regions: Vec<Region>,
    /// contacts of all clusters (length: all that can be active)
    pub(crate) list: Vec<ActiveContact<R>>,
    /// number of ticks in which curves were not solved within the iteration limit
    pub unsolved: u64,
    /// working memory: pushes on slots, zero between solutions (`n_mat`, none without such contacts)
    pub(crate) push: Vec<R>,
}

/// The list is working memory of one tick and is not compared.
impl<R: Real> PartialEq for ActiveContacts<R> {
    fn eq(&self, other: &ActiveContacts<R>) -> bool {
        self.unsolved == other.unsolved
    }
}

impl<R: Real> ActiveContacts<R> {
    /// Allocates for `contacts` links among `places` slots. `of` holds the cluster of each link, `u32::MAX` for links that
    /// are not solved together, or is empty for one cluster.
    pub fn in_clusters(of: &[u32], contacts: usize, places: usize) -> ActiveContacts<R> {
        let clusters = || of.iter().filter(|c| **c != u32::MAX).map(|c| *c as usize);
        let Some(last) = clusters().max() else { return ActiveContacts::new(contacts, places) };
        let mut regions = alloc::vec![Region::default(); last + 1];
        for cluster in clusters() {
            regions[cluster].room += 1;
        }
        let mut first = 0;
        for region in &mut regions {
            region.first = first;
            first += region.room;
        }
        ActiveContacts { regions, ..ActiveContacts::new(contacts, places) }
    }

    /// Allocates for one cluster of `contacts` links among `places` slots.
    pub fn new(contacts: usize, places: usize) -> ActiveContacts<R> {
        let places = if contacts == 0 { 0 } else { places };
        ActiveContacts {
            regions: alloc::vec![Region { first: 0, room: contacts, n: 0 }],
            unsolved: 0,
            list: alloc::vec![ActiveContact::default(); contacts],
            push: alloc::vec![R::ZERO; places],
        }
    }
}
