//! A network as plain records, in the units of a sample: what every peer is made from.
//!
//! Decides for records of its own, not for the networks of `ca bench`: those are texts in SI units for one reader, and
//! peers need the very same numbers in a table, in a Faust program and in a model.

/// What a MAT is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// a mass
    Mas,
    /// a mass on a spring and a damper of its own
    Cel {
        /// stiffness
        k: f64,
        /// viscosity
        z: f64,
    },
    /// a fixed point
    Sol,
}

/// A MAT. Its place and speed are at the start, as in a model; for peers, its place in the first sample of the engine and the
/// step that led there ([`super::player::Engine::started`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mat {
    /// what it is
    pub kind: Kind,
    /// mass
    pub m: f64,
    /// place; on a line the first number
    pub x: [f64; 3],
    /// speed, or step
    pub v: [f64; 3],
}

/// What a LIA does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// a spring with damper: k, z, length at rest
    Ref(f64, f64, f64),
    /// a contact that keeps its ends `d` apart: k, z, d
    But(f64, f64, f64),
    /// a Hertz contact: k, d
    Hrz(f64, f64),
    /// the smooth bow: f, v0
    Bow(f64, f64),
    /// a contact that keeps its ends within `d`, in space: k, z, d
    Inside(f64, f64, f64),
}

/// A LIA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lia {
    /// what it does
    pub law: Law,
    /// its first end
    pub a: usize,
    /// its second end
    pub b: usize,
}

/// A network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Net {
    /// of its row
    pub name: String,
    /// in space, or on a line
    pub space: bool,
    /// masses and fixed points
    pub mats: Vec<Mat>,
    /// links
    pub lias: Vec<Lia>,
    /// masses that are heard, summed; in space along z
    pub heard: Vec<usize>,
    /// contacts between all pairs of these, in one line of a model; in `lias` they are one by one, and last
    pub pairs: Option<Vec<usize>>,
}

impl Net {
    /// Nothing yet.
    pub fn new(name: &str, space: bool) -> Net {
        Net { name: name.into(), space, ..Net::default() }
    }

    /// MATs and LIAs.
    pub fn modules(&self) -> usize {
        self.mats.len() + self.lias.len()
    }

    /// Lines of a model: all pairs of grains are in one.
    pub fn lines(&self) -> usize {
        let grains = self.pairs.as_ref().map_or(0, Vec::len);
        self.modules() - (grains * grains.saturating_sub(1) / 2).saturating_sub(usize::from(grains > 1))
    }

    /// Where the heard masses rest, summed. A SOX takes it off and a peer does not; in space they rest where they start.
    pub fn rest(&self) -> f64 {
        if self.space { self.heard.iter().map(|i| self.mats[*i].x[2]).sum() } else { 0.0 }
    }

    /// A MAT at rest on a line, at `x`.
    pub fn mat(&mut self, kind: Kind, m: f64, x: f64) -> usize {
        self.mats.push(Mat { kind, m, x: [x, 0.0, 0.0], v: [0.0; 3] });
        self.mats.len() - 1
    }

    /// A link.
    pub fn lia(&mut self, law: Law, a: usize, b: usize) {
        self.lias.push(Lia { law, a, b });
    }
}
