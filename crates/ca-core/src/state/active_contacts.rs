//! Links that are solved together in a tick, as data: the methods of `method` gather them, and `method/together.rs` solves.
//!
//! Decides for one record per contact with the vectors of the solver in it, instead of an array per vector: few are
//! ever active at once, and all numbers of one are used together. Room for all is made at load, so no tick allocates.

use crate::numeric::{Real, Table};
use alloc::vec::Vec;

/// The push of a contact as a curve over the motion to come (`method/cluster.rs`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve<R: Real> {
    /// the push \[N\] and how it rises \[N/m\], without viscosity
    pub push: AtChange<R, [R; 2]>,
    /// the potential before the tick less that after it \[J\]
    pub released: AtChange<R, R>,
}

/// A function of the coefficients of a law, the tables, the penetration before the tick \[m\] and its change over two ticks \[m\].
pub(crate) type AtChange<R, T> = fn(&[R; COEFS], &[Table<R>], R, R) -> T;

/// Coefficients of a law whose push is a curve.
pub(crate) const COEFS: usize = 5;

/// The part of a contact in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Part {
    /// it touches
    #[default]
    Acts,
    /// it touches nothing unless another contact pushes it
    Waits,
    /// it is left out, since it would pull
    LeftOut,
}

/// One link that acts in this tick; of friction, γ and ψ are 0, and the elongation is a penetration that shrinks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ActiveContact<R: Real = f64> {
    /// first slot of either end
    pub ends: [u32; 2],
    /// axes of an end: 1 on a line, 3 in space
    pub axes: usize,
    /// gradient of the penetration against the second end; its negative against the first
    pub g: [R; 3],
    /// its memory
    pub mem: usize,
    /// where its force is heard, if it is
    pub tap: Option<usize>,
    /// sign that turns its push into the tension of a link
    pub side: R,
    /// may only push
    pub clip: bool,
    /// lets go: is not pressed together any more, but still holds energy
    pub open: bool,
    /// change of ψ per change of penetration \[√(N/m)\]
    pub gamma: R,
    /// ψ before the tick \[√J\]; the energy stored is ψ²/2
    pub psi: R,
    /// viscosity \[N per m/tick\]
    pub z: R,
    /// push per change of penetration over two ticks, γ²/4 + z/2 \[N/m\]
    pub stiff: R,
    /// the change of penetration over two ticks that all other forces would cause \[m\]
    pub free: R,
    /// diagonal of the system \[m/N\]
    pub diag: R,
    /// push beyond `bias` \[N\]: the unknown
    pub y: R,
    /// its push where that is not a straight line over the motion to come; none of what goes by ψ and of friction
    pub curve: Option<&'static Curve<R>>,
    /// coefficients of its law, of a curve
    pub coef: [R; COEFS],
    /// penetration before the tick \[m\], of a curve
    pub from: R,
    /// the change of penetration over two ticks \[m\]: assumed, then found
    pub at: R,
    /// push without motion \[N\]: γψ, or of the tangent
    pub bias: R,
    /// mobility of its ends \[m/N\]
    pub own: R,
    /// the part it takes in this tick
    pub part: Part,
    /// push, change of penetration and `y` as found, whose derivatives take a step more
    pub found: [R; 3],
    /// where a step began: the change of penetration, the push, and by how much the curve is above it there
    pub last: [R; 3],
    /// residual \[m\]
    pub r: R,
    /// direction of search \[N\]
    pub p: R,
    /// what the system makes of the direction \[m\]
    pub q: R,
}

/// The contacts of this tick.
#[derive(Clone, Debug, Default)]
pub struct ActiveContacts<R: Real = f64> {
    /// how many act so far
    pub(crate) n: usize,
    /// the first `n` of them act (as long as there are contacts that may)
    pub(crate) list: Vec<ActiveContact<R>>,
    /// ticks in which curves were not solved within the bound on iterations
    pub unsolved: u64,
    /// pushes on places, nothing between solutions (`n_mat`, none without such contacts)
    pub(crate) push: Vec<R>,
}

/// The list is room for numbers of one tick, and is not compared.
impl<R: Real> PartialEq for ActiveContacts<R> {
    fn eq(&self, other: &ActiveContacts<R>) -> bool {
        (self.n, self.unsolved) == (other.n, other.unsolved)
    }
}

impl<R: Real> ActiveContacts<R> {
    /// Room for `contacts` among `places`.
    pub fn new(contacts: usize, places: usize) -> ActiveContacts<R> {
        let places = if contacts == 0 { 0 } else { places };
        ActiveContacts {
            n: 0,
            unsolved: 0,
            list: alloc::vec![ActiveContact::default(); contacts],
            push: alloc::vec![R::ZERO; places],
        }
    }
}
