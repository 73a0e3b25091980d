//! The linear network of a scene as matrices see it: dofs that move, and links as rows b with a stiffness and a
//! viscosity, so that K = Σ k b bᵀ and C = Σ z b bᵀ (docs/numerics.md §1.3).
//!
//! Decides to keep rows instead of matrices: stability wants T²K + 2TC at once, modes want them apart, and the largest
//! safe value of one link wants all the others.

use alloc::string::String;
use alloc::vec::Vec;

/// A place that moves: one axis of one MAT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dof {
    /// number of the MAT in document order
    pub mat: u32,
    /// its axis
    pub axis: u8,
    /// mobility T²/m \[m/N\]
    pub c: f64,
    /// its own stiffness to the ground \[N/m\]
    pub k: f64,
    /// its own viscosity to the ground \[N per m/tick\]
    pub z: f64,
    /// what an implicit method adds to its inertia \[N per m/tick²\]
    pub implicit: f64,
}

/// A link. Its elongation is the sum of its entries' weights times displacements.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkRow {
    /// number of the LIA in document order
    pub lia: u32,
    /// stiffness \[N/m\]
    pub k: f64,
    /// viscosity \[N per m/tick\]
    pub z: f64,
    /// what an implicit method adds to the inertia along it \[N per m/tick²\]
    pub implicit: f64,
    /// first of its entries, and how many
    entries: (u32, u32),
}

/// A link at a point that may stand anywhere on a string or a mesh: one list of entries for each node under it.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingLink {
    /// stiffness \[N/m\]
    pub k: f64,
    /// viscosity \[N per m/tick\]
    pub z: f64,
    /// entries at each node
    pub at: Vec<Vec<(u32, f64)>>,
}

/// The linear network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Linear {
    /// dofs that move
    pub dofs: Vec<Dof>,
    /// links between them, or to what is fixed
    pub rows: Vec<LinkRow>,
    /// links at moving points
    pub moving_links: Vec<MovingLink>,
    entries: Vec<(u32, f64)>,
}

impl Linear {
    /// Takes in a link; one that moves nothing is left out.
    pub fn link(&mut self, lia: u32, [k, z, implicit]: [f64; 3], entries: &[(u32, f64)]) {
        if !entries.is_empty() && (k != 0.0 || z != 0.0) {
            let first = self.entries.len() as u32;
            self.entries.extend_from_slice(entries);
            self.rows.push(LinkRow { lia, k, z, implicit, entries: (first, entries.len() as u32) });
        }
    }

    /// Entries of a link: dofs and weights.
    pub fn entries(&self, row: &LinkRow) -> &[(u32, f64)] {
        let (first, n) = row.entries;
        self.entries.get(first as usize..(first + n) as usize).unwrap_or_default()
    }
}

/// Where a network is driven or heard: a displacement there is the sum of its entries' weights times displacements.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// name of the output, the input or the link
    pub name: String,
    /// what it does: `hears`, `pushes`, or `acts` for a link that is not linear
    pub role: &'static str,
    /// dofs and weights
    pub at: Vec<(u32, f64)>,
}

/// The linear part of a model at load.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    /// tick \[s\]
    pub tick_dt: f64,
    /// ticks in a sample
    pub oversample: u32,
    /// true where its ticks go by the method of [`ca_core::internal::method::pefrl`]
    pub composed: bool,
    /// true where all of it goes by its modes, which the scheme then plays as they are
    pub modal: bool,
    /// its dofs and links
    pub linear: Linear,
    /// name of each place: its module, with `.x`, `.y` or `.z` in space
    pub names: Vec<String>,
    /// force on each place that nothing changes \[N\]: weight, and springs whose rest length is not what they measure at rest
    pub constant: Vec<f64>,
    /// displacement of each place at load \[m\]
    pub x: Vec<f64>,
    /// its speed \[m/s\]
    pub v: Vec<f64>,
    /// name of the link of each row
    pub link_names: Vec<String>,
    /// what of it a tick does in another way than by these matrices: a method, or nothing
    pub other_scheme: Option<&'static str>,
    /// name of each place that a position port moves, and `None` of an axis that none moves; they are numbered behind all dofs, and
    /// are there only where the network is for a tick
    pub driven: Vec<Option<String>>,
    /// where it is driven and heard
    pub ports: Vec<Port>,
    /// outputs that hear a speed or an acceleration: the displacement of which they hear a derivative. They are not among
    /// [`Network::ports`], which hear a displacement itself
    pub derivatives: Vec<Port>,
    /// outputs that hear a force, a speed or an acceleration, none of which is a displacement
    pub force_outputs: Vec<String>,
    /// links that are not linear, and so not in it: name and law
    pub left_out: Vec<(String, &'static str)>,
    /// what nothing hears, and so is not in it: modules, or of one that is heard in part its members
    pub unheard: Vec<String>,
}
