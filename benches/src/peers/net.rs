//! Networks as plain records, in units of a sample, from which the input of every peer is made.
//!
//! The networks of `ca bench` do not serve here, because they are texts in SI units for one reader. Peers need exactly
//! the same numbers in a table, a Faust program and a model.

/// Type of a MAT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A mass.
    Mas,
    /// A mass with its own spring and damper.
    Cel {
        /// Stiffness.
        k: f64,
        /// Viscosity.
        z: f64,
    },
    /// A fixed point.
    Sol,
}

/// A MAT with its position and speed at the start, as in a model. For peers these are its position in the first sample
/// of the engine and the step that led there ([`super::player::Engine::started`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mat {
    /// Type.
    pub kind: Kind,
    /// Mass.
    pub m: f64,
    /// Position; on a line the first number.
    pub x: [f64; 3],
    /// Speed, or step.
    pub v: [f64; 3],
}

/// Law of a LIA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Spring with damper: k, z, length at rest.
    Ref(f64, f64, f64),
    /// Contact that keeps its ends `d` apart: k, z, d.
    But(f64, f64, f64),
    /// Hertz contact: k, d.
    Hrz(f64, f64),
    /// Smooth bow: f, v0.
    Bow(f64, f64),
    /// Contact that keeps its ends within `d`, in space: k, z, d.
    Inside(f64, f64, f64),
}

/// A LIA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lia {
    /// Law.
    pub law: Law,
    /// Index of its first end.
    pub a: usize,
    /// Index of its second end.
    pub b: usize,
}

/// A network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Net {
    /// Name of its row.
    pub name: String,
    /// True in space, false on a line.
    pub space: bool,
    /// Masses and fixed points.
    pub mats: Vec<Mat>,
    /// Links.
    pub lias: Vec<Lia>,
    /// Masses with an output, summed; in space along z.
    pub outputs: Vec<usize>,
    /// Masses with contacts between all pairs, on one line of a model; in `lias` the contacts are separate, and last.
    pub pairs: Option<Vec<usize>>,
}

impl Net {
    /// Makes an empty network.
    pub fn new(name: &str, space: bool) -> Net {
        Net { name: name.into(), space, ..Net::default() }
    }

    /// Returns the number of MATs and LIAs.
    pub fn modules(&self) -> usize {
        self.mats.len() + self.lias.len()
    }

    /// Returns the number of lines in a model, in which all pairs of grains are one.
    pub fn lines(&self) -> usize {
        let grains = self.pairs.as_ref().map_or(0, Vec::len);
        self.modules() - (grains * grains.saturating_sub(1) / 2).saturating_sub(usize::from(grains > 1))
    }

    /// Returns the summed rest positions of the masses with an output. A SOX subtracts them and a peer does not; in
    /// space they are the start positions.
    pub fn rest(&self) -> f64 {
        if self.space { self.outputs.iter().map(|i| self.mats[*i].x[2]).sum() } else { 0.0 }
    }

    /// Adds a MAT at rest on a line, at `x`.
    pub fn mat(&mut self, kind: Kind, m: f64, x: f64) -> usize {
        self.mats.push(Mat { kind, m, x: [x, 0.0, 0.0], v: [0.0; 3] });
        self.mats.len() - 1
    }

    /// Adds a link.
    pub fn lia(&mut self, law: Law, a: usize, b: usize) {
        self.lias.push(Lia { law, a, b });
    }
}
