//! Added forces ([`added`](super::added)) of few links or masses, computed one by one.
//!
//! For one link beside a long string, vectors of [`Groups`](super::groups::Groups) would be 0 but for two slots.

use crate::parts::record::Row;
use ca_core::internal::numeric::Aligned;

/// Target of an added force.
#[derive(Clone, Copy)]
pub enum On {
    /// Slot of a mass; the force is per d, x and d'.
    Mass(usize),
    /// End slots and constant elongation of a link; the force is per e, per w and constant.
    Link([usize; 2], f64),
}

struct One {
    on: On,
    by: [f64; 3],
    /// Force in each tick.
    forces: Vec<f64>,
}

pub struct Few(Vec<Vec<One>>);

impl Few {
    pub fn new(parameters: usize) -> Few {
        Few((0..parameters).map(|_| Vec::new()).collect())
    }

    /// Registers the added force of parameter `q` on one target, for `ticks` ticks at a time.
    pub fn put(&mut self, q: usize, on: On, by: [f64; 3], ticks: usize) {
        self.0[q].push(One { on, by, forces: vec![0.0; ticks] });
    }

    /// Computes the forces of tick `k`, which began with `row`; `next` holds the motions after it.
    pub fn measure(&mut self, k: usize, row: &Row, next: &[f64]) {
        for One { on, by, forces } in self.0.iter_mut().flatten() {
            let with = match on {
                On::Mass(m) => [row.d[*m], row.x[*m], next[*m]],
                On::Link([a, b], e0) => [row.x[*b] - row.x[*a] + *e0, row.d[*b] - row.d[*a], 1.0],
            };
            forces[k] = by[0] * with[0] + by[1] * with[1] + by[2] * with[2];
        }
    }

    /// Adds the forces of tick `k` to the derivatives by parameter `q`.
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
