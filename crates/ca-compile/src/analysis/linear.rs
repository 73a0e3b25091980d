//! The linear network of a scene as input of matrices: moving dofs, and links as rows b with stiffness and viscosity.
//!
//! K = Σ k b bᵀ and C = Σ z b bᵀ (docs/numerics.md §1.3). Rows are stored instead of matrices: stability needs T²K +
//! 2TC, modes need K and C separately, and the largest safe value of one link needs all the others.

use alloc::string::String;
use alloc::vec::Vec;

/// A degree of freedom: one axis of one MAT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dof {
    /// Number of the MAT in document order.
    pub mat: u32,
    /// Axis.
    pub axis: u8,
    /// Mobility T²/m \[m/N\].
    pub c: f64,
    /// Own stiffness to ground \[N/m\].
    pub k: f64,
    /// Own viscosity to ground \[N per m/tick\].
    pub z: f64,
    /// Inertia that an implicit method adds \[N per m/tick²\].
    pub implicit: f64,
}

/// A link. Its elongation is the sum over its entries of weight times displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkRow {
    /// Number of the LIA in document order.
    pub lia: u32,
    /// Stiffness \[N/m\].
    pub k: f64,
    /// Viscosity \[N per m/tick\].
    pub z: f64,
    /// Inertia that an implicit method adds along the link \[N per m/tick²\].
    pub implicit: f64,
    /// Index of its first entry, and their number.
    entries: (u32, u32),
}

/// A link at a moving point on a string or a mesh: one list of entries for each node under the point.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingLink {
    /// Stiffness \[N/m\].
    pub k: f64,
    /// Viscosity \[N per m/tick\].
    pub z: f64,
    /// Entries at each node.
    pub at: Vec<Vec<(u32, f64)>>,
}

/// The linear network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Linear {
    /// Moving dofs.
    pub dofs: Vec<Dof>,
    /// Links between dofs, or between a dof and something fixed.
    pub rows: Vec<LinkRow>,
    /// Links at moving points.
    pub moving_links: Vec<MovingLink>,
    entries: Vec<(u32, f64)>,
}

impl Linear {
    /// Adds a link; one that moves nothing is left out.
    pub fn link(&mut self, lia: u32, [k, z, implicit]: [f64; 3], entries: &[(u32, f64)]) {
        if !entries.is_empty() && (k != 0.0 || z != 0.0) {
            let first = self.entries.len() as u32;
            self.entries.extend_from_slice(entries);
            self.rows.push(LinkRow { lia, k, z, implicit, entries: (first, entries.len() as u32) });
        }
    }

    /// Returns the entries of a link: dofs and weights.
    pub fn entries(&self, row: &LinkRow) -> &[(u32, f64)] {
        let (first, n) = row.entries;
        self.entries.get(first as usize..(first + n) as usize).unwrap_or_default()
    }
}

/// An input or output of a network. Its displacement is the sum over its entries of weight times displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Name of the output, the input or the link.
    pub name: String,
    /// `hears` for an output, `pushes` for an input, `acts` for a link that is not linear.
    pub role: &'static str,
    /// Dofs and weights.
    pub at: Vec<(u32, f64)>,
}

/// The linear part of a model at load.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    /// Tick \[s\].
    pub tick_dt: f64,
    /// Ticks per sample.
    pub oversample: u32,
    /// True if it uses the method of [`ca_core::internal::method::pefrl`].
    pub composed: bool,
    /// True if all of it is computed by its modes, which the scheme then renders exactly.
    pub modal: bool,
    /// Dofs and links.
    pub linear: Linear,
    /// Name of each dof: its module, with `.x`, `.y` or `.z` in space.
    pub names: Vec<String>,
    /// Constant force on each dof \[N\]: weight, and springs that are not at their rest length at rest.
    pub constant: Vec<f64>,
    /// Displacement of each dof at load \[m\].
    pub x: Vec<f64>,
    /// Speed of each dof at load \[m/s\].
    pub v: Vec<f64>,
    /// Name of the link of each row.
    pub link_names: Vec<String>,
    /// Setting by which a tick computes some dofs otherwise than by these matrices, if any.
    pub other_scheme: Option<&'static str>,
    /// Name of each position that a position port moves; `None` for an axis without an input. They are numbered after
    /// all dofs, and exist only in a network made for a tick.
    pub driven: Vec<Option<String>>,
    /// Force inputs, outputs of a displacement, and links that are not linear.
    pub ports: Vec<Port>,
    /// Displacements whose derivative, a speed or an acceleration, is an output. They are not in [`Network::ports`].
    pub derivatives: Vec<Port>,
    /// Names of the outputs of a force, a speed or an acceleration.
    pub force_outputs: Vec<String>,
    /// Links that are not linear and therefore left out: name and law.
    pub left_out: Vec<(String, &'static str)>,
    /// Names of modules left out because no output depends on them; for an item kept in part, its members.
    pub unheard: Vec<String>,
}
