//! The model as plain modules: what reading it leaves and the interpreter plays. Data only.
//! Time counts in ticks T: `x` [m] is measured from the rest, `d` [m] is the way of the last tick, z stands for z/T.

use super::listed::Listed;
use super::waves::Line;

/// d ← p·d + q·x + c·f, then x ← x + d. A mass has p = 1, q = 0, c = T²/m; a cell p = 1 − zT/m, q = −kT²/m, c = T²/m;
/// what is fixed, moved from outside or between nodes has c = 0.
/// On a line only the first axis counts; in a plane two; `axes` says how many move.
#[derive(Default, Clone)]
pub struct Mat {
    pub axes: usize,
    pub x: [f64; 3],
    pub d: [f64; 3],
    pub f: [f64; 3],
    pub rest: [f64; 3],
    pub pqc: [f64; 3],
    pub weight: [f64; 3],
}

/// Breakpoints, joined by straight lines and held outside.
pub type Curve = Vec<[f64; 2]>;

/// A contact within distance d has side −1, one beyond it 1. Powers are in quarters; table velocities in m/s.
pub enum Law {
    Linear {
        k: f64,
        z: f64,
    },
    Cubic {
        k: f64,
        k3: f64,
        z: f64,
    },
    Power {
        k: f64,
        q: f64,
        quarters: u32,
        z: f64,
    },
    Buffer {
        k: f64,
        z: f64,
        d: f64,
        side: f64,
        sticky: bool,
    },
    Hertz {
        k: f64,
        quarters: u32,
        h: f64,
        d: f64,
        side: f64,
    },
    Attract {
        k: f64,
        z: f64,
        d: f64,
        rho: f64,
    },
    /// `side` is the sign of the elongation in which it holds, 0 where both do; `engaged` whether it may at load
    Pluck {
        k: f64,
        z: f64,
        d: f64,
        side: f64,
        engaged: bool,
        held: Option<bool>,
        last: f64,
    },
    Curves {
        spring: Option<Curve>,
        friction: Option<Curve>,
        tick_dt: f64,
    },
    Stribeck {
        f: f64,
        fd: f64,
        v0: f64,
        v1: f64,
    },
    Smooth {
        f: f64,
        v0: f64,
        bell: Curve,
    },
    Listed(Listed),
}

impl Law {
    /// Whether a link of two ends is not measured while nothing touches.
    pub fn passes(&self) -> bool {
        match self {
            Law::Buffer { .. } | Law::Hertz { .. } => true,
            Law::Listed(law) => law.passes(),
            _ => false,
        }
    }
}

/// How two ends are measured: these axes of them, their difference along a direction, or their distance, of which the
/// vector at rest and the square of the softening length are given, and how it knows what it was.
pub enum MeasureKind {
    Line([usize; 2]),
    Along([f64; 3]),
    Radial([f64; 3], f64, Past),
}

/// The distance one tick before: from motion, for contacts, which are not measured while nothing touches, or as it was
/// measured then, if it was.
pub enum Past {
    Motion,
    Kept(Option<f64>),
}

/// Sees the sum of what its ports measure, and e₀, and the change of that; its force pulls the first end of each port
/// and pushes the second. A dipole has one port, a quadripole two.
pub struct Link {
    pub ports: Vec<([usize; 2], MeasureKind)>,
    pub e0: f64,
    pub law: Law,
    pub f: f64,
}

/// A MAT between the nodes of a row or a mesh of `size`, where the MATs `at` stand, from 0 to 1, one for each axis.
pub struct Point {
    pub mat: usize,
    pub nodes: Vec<usize>,
    pub size: [usize; 2],
    pub at: Vec<usize>,
}

/// Pushes all MATs `to`, or moves one, straight over a period of this many ticks.
pub struct Port {
    pub name: String,
    pub to: Vec<usize>,
    /// axis it moves or pushes along
    pub axis: usize,
    pub period: Option<u64>,
    pub held: f64,
    pub from: f64,
}

/// What an output listens to, by number of the MAT and its axis, or of the link.
pub enum Heard {
    Position(usize, usize),
    Motion(usize, usize),
    ForceOn(usize, usize),
    ForceOf(usize),
}

#[derive(Default)]
pub struct Network {
    pub mats: Vec<Mat>,
    pub links: Vec<Link>,
    pub lines: Vec<Line>,
    pub points: Vec<Point>,
    pub ports: Vec<Port>,
    /// channel, gain and source
    pub outputs: Vec<(usize, f64, Heard)>,
    /// forces from outside on a line in the tick at hand: on which mass, and how much
    pub pushed: Vec<(usize, f64)>,
    /// ticks played
    pub n: u64,
}

impl Mat {
    /// A force from outside: in space before all others, on a line `later`.
    pub fn push(&mut self, (own, axis, force): (usize, usize, f64), later: &mut Vec<(usize, f64)>) {
        if self.axes == 1 { later.push((own, force)) } else { self.f[axis] += force }
    }
}

impl Network {
    pub fn channels(&self) -> usize {
        self.outputs.iter().map(|(channel, _, _)| channel + 1).max().unwrap_or(0)
    }
}
