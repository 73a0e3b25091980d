//! Clouds: points in space and the pairs of them that are joined, as read from the file of a body.
//!
//! The compiler never opens a file. Its caller passes the contents of the files named in a model, or why they could not
//! be read. So a model compiles the same way from a disk, in a browser and in a test.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// Points, and the pairs of them that are joined.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Cloud {
    /// points, in units of the file
    pub points: Vec<[f64; 3]>,
    /// indices into `points`, the smaller first, each pair once
    pub edges: Vec<[u32; 2]>,
    /// number of points left out because another has the same position
    pub merged: usize,
    /// number of faces left out because they have fewer than three different corners, or one corner twice
    pub flat: usize,
}

/// Why a file could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// what is wrong, and where in the file
    pub what: String,
    /// suggested remedy
    pub help: String,
}

/// Contents of the files named in a model, by the name as written there.
pub type Clouds = BTreeMap<String, Result<Arc<Cloud>, Unread>>;

impl Cloud {
    /// Returns all pairs at most `reach` apart, in order, or `None` if there are more than `most`.
    pub fn pairs_within(&self, reach: f64, most: usize) -> Option<Vec<[u32; 2]>> {
        // sort along the axis of largest extent, where each point has few neighbours
        let extent = |k: &usize| {
            let (low, high) =
                self.points.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (f64::min(a, p[*k]), f64::max(b, p[*k])));
            high - low
        };
        let axis = (0..3usize).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        let at = |i: u32| self.points[i as usize];
        order.sort_by(|a, b| at(*a)[axis].total_cmp(&at(*b)[axis]));
        let mut pairs = Vec::new();
        for (n, i) in order.iter().enumerate() {
            for j in order[n + 1..].iter().take_while(|j| at(**j)[axis] - at(*i)[axis] <= reach) {
                let d: [f64; 3] = core::array::from_fn(|k| at(*j)[k] - at(*i)[k]);
                if libm::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) <= reach {
                    if pairs.len() == most {
                        return None;
                    }
                    pairs.push([*i.min(j), *i.max(j)]);
                }
            }
        }
        pairs.sort_unstable();
        Some(pairs)
    }
}
