//! The model as plain modules, made by `build` and played by `interpreter`; data only. Time is in ticks T: `x` [m] is
//! relative to rest, `d` [m] is the motion of the last tick, z stands for z/T.

use super::listed::Listed;
use super::waves::Line;

/// d ← p·d + q·x + c·f, then x ← x + d.
///
/// A mass has p = 1, q = 0, c = T²/m; a cell has p = 1 − zT/m, q = −kT²/m, c = T²/m. Fixed points, ports and moving
/// points have c = 0. `axes` is the number of axes that move: 1 on a line, 2 in a plane.
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

/// Breakpoints of a curve, linear between them and constant outside.
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
    /// `side` is the sign of elongation in which it holds, 0 for both; `engaged` tells if it may hold at load.
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
    /// True if a link of two ends is not measured while nothing touches.
    pub fn passes(&self) -> bool {
        match self {
            Law::Buffer { .. } | Law::Hertz { .. } => true,
            Law::Listed(law) => law.passes(),
            _ => false,
        }
    }
}

/// Measure of two ends: along these axes, along a direction, or by distance. A distance has the vector at rest,
/// the square of the softening length, and the source of its last value.
pub enum MeasureKind {
    Line([usize; 2]),
    Along([f64; 3]),
    Radial([f64; 3], f64, Past),
}

/// Distance one tick earlier: computed from motion for contacts, which are not measured while nothing touches, or the
/// value measured then, if any.
pub enum Past {
    Motion,
    Stored(Option<f64>),
}

/// Measures the sum over its ports plus e₀, and the change of that. The force pulls the first end of each port and
/// pushes the second. A dipole has one port, a quadripole two.
pub struct Link {
    pub ports: Vec<([usize; 2], MeasureKind)>,
    pub e0: f64,
    pub law: Law,
    pub f: f64,
}

/// A MAT between the nodes of a row or a mesh of `size`. The MATs `at` give its position from 0 to 1, one per axis.
pub struct Point {
    pub mat: usize,
    pub nodes: Vec<usize>,
    pub size: [usize; 2],
    pub at: Vec<usize>,
}

/// Pushes all MATs `to`, or moves one linearly over a period of this many ticks.
pub struct Port {
    pub name: String,
    pub to: Vec<usize>,
    /// Axis of the motion or force.
    pub axis: usize,
    pub period: Option<u64>,
    pub held: f64,
    pub from: f64,
}

/// Source of an output, by number of the MAT and its axis, or of the link.
pub enum OutputSignal {
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
    /// Channel, gain and source.
    pub outputs: Vec<(usize, f64, OutputSignal)>,
    /// Forces from outside on a line in this tick: mass and force.
    pub pushed: Vec<(usize, f64)>,
    /// Ticks played.
    pub n: u64,
}

impl Mat {
    /// Adds a force from outside: in space before all others, on a line `later`.
    pub fn push(&mut self, (own, axis, force): (usize, usize, f64), later: &mut Vec<(usize, f64)>) {
        if self.axes == 1 { later.push((own, force)) } else { self.f[axis] += force }
    }
}

impl Network {
    pub fn channels(&self) -> usize {
        self.outputs.iter().map(|(channel, _, _)| channel + 1).max().unwrap_or(0)
    }
}
