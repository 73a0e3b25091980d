//! Few: the forces that changed numbers of few links of a list, or of few masses, add to a derivative.
//!
//! Decides to take these one by one against vectors over all slots ([`Groups`](super::groups::Groups)): a link that is held apart
//! from a long string gives nothing to all but two of them.

use crate::parts::record::Row;
use ca_core::internal::numeric::Aligned;

/// What a force is added to.
#[derive(Clone, Copy)]
pub enum On {
    /// a mass, by its slot: per d, x and d'
    Mass(usize),
    /// a link: the slots of its ends, and its constant elongation; per e, per w and by itself
    Link([usize; 2], f64),
}

/// One of them.
struct One {
    on: On,
    by: [f64; 3],
    /// the force in each tick
    forces: Vec<f64>,
}

/// Those of each parameter.
pub struct Few(Vec<Vec<One>>);

impl Few {
    /// None yet, of so many parameters.
    pub fn new(parameters: usize) -> Few {
        Few((0..parameters).map(|_| Vec::new()).collect())
    }

    /// One that parameter `q` changes, for so many ticks at a time.
    pub fn put(&mut self, q: usize, on: On, by: [f64; 3], ticks: usize) {
        self.0[q].push(One { on, by, forces: vec![0.0; ticks] });
    }

    /// Finds the forces of tick `k`, which began with `row`; `next` are the motions behind it.
    pub fn measure(&mut self, k: usize, row: &Row, next: &[f64]) {
        for One { on, by, forces } in self.0.iter_mut().flatten() {
            let with = match on {
                On::Mass(m) => [row.d[*m], row.x[*m], next[*m]],
                On::Link([a, b], e0) => [row.x[*b] - row.x[*a] + *e0, row.d[*b] - row.d[*a], 1.0],
            };
            forces[k] = by[0] * with[0] + by[1] * with[1] + by[2] * with[2];
        }
    }

    /// Adds those of tick `k` to the derivatives by parameter `q`.
    pub fn add(&self, k: usize, q: usize, f: &mut Aligned) {
        for One { on, forces, .. } in &self.0[q] {
            match on {
                On::Mass(m) => f[*m] += forces[k],
                On::Link([a, b], _) => {
                    f[*a] += forces[k];
                    f[*b] -= forces[k];
                }
            }
        }
    }
}
