//! Stability atlas: behaviour of the running engine over a plane of parameters, compared with theory.
//!
//! Each cell of a map is measured by playing a scene compiled from text, without use of the certificate. A mistake
//! shared by certificate and theory would thus be found. A map is one entry of [`MAPS`]. Its theory is a function of
//! the same two numbers, with `None` where nothing is proven. A cell contradicts theory if both have an answer and
//! differ. Cells within [`Map::band`] of the boundary are not judged, because a run of finite length cannot decide
//! there.

mod contact;
mod device;
mod friction;
mod linear;
pub mod non_finite;
pub mod orders;
pub mod page;
pub mod survival;
pub mod svg;
mod wave;

pub use contact::{contact, exact, ratio};
pub use device::limit;

/// One axis of a map.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Name of the quantity, with its unit.
    pub name: &'static str,
    /// Ends of the axis; exponents of ten with `log`.
    pub ends: [f64; 2],
    /// True for a logarithmic axis.
    pub log: bool,
}

impl Axis {
    const fn of(name: &'static str, from: f64, to: f64) -> Axis {
        Axis { name, ends: [from, to], log: false }
    }

    /// Makes an axis of powers of ten between these exponents.
    pub const fn log(name: &'static str, from: f64, to: f64) -> Axis {
        Axis { name, ends: [from, to], log: true }
    }

    /// Returns the number at a place from 0 to 1.
    pub fn at(&self, part: f64) -> f64 {
        let place = self.ends[0] + part * (self.ends[1] - self.ends[0]);
        if self.log { 10f64.powf(place) } else { place }
    }

    /// Returns the place of a number, from 0 to 1 within the map.
    pub fn part(&self, value: f64) -> f64 {
        let place = if self.log { value.log10() } else { value };
        (place - self.ends[0]) / (self.ends[1] - self.ends[0])
    }
}

/// A line from theory.
#[derive(Clone, Debug)]
pub struct Line {
    /// Points, in the numbers of the axes.
    pub points: Vec<[f64; 2]>,
    /// True for a rule or a special value, which does not judge cells.
    pub thin: bool,
}

impl Line {
    fn edge(points: Vec<[f64; 2]>) -> Line {
        Line { points, thin: false }
    }

    /// Makes a straight line that does not judge cells.
    fn rule(from: [f64; 2], to: [f64; 2]) -> Line {
        Line { points: vec![from, to], thin: true }
    }

    /// Makes a boundary through the points that `at` returns from one number to another.
    fn curve(from: f64, to: f64, at: impl Fn(f64) -> [f64; 2]) -> Line {
        const N: u32 = 120;
        Line::edge((0..=N).map(|i| at(from + (to - from) * f64::from(i) / f64::from(N))).collect())
    }
}

/// One map.
pub struct Map {
    /// Name of its file.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Description of the scene and of the theory, with its source.
    pub text: &'static str,
    /// Horizontal and vertical axis.
    pub axes: [Axis; 2],
    /// Names of a cell that does not grow, and of one that does.
    pub words: [&'static str; 2],
    /// Plays the scene of these two numbers and returns true if it grows.
    pub measured: fn(f64, f64) -> bool,
    /// Returns true if it grows according to theory; `None` if theory says nothing.
    pub theory: fn(f64, f64) -> Option<bool>,
    /// Returns the lines of the theory.
    pub lines: fn() -> Vec<Line>,
    /// Distance from a boundary within which a cell is not judged, as a share of each axis.
    pub band: f64,
}

/// All maps, in the order of the page.
pub const MAPS: &[Map] = &[
    linear::OSCILLATOR,
    linear::CHAIN,
    linear::MESH,
    linear::PAIR,
    linear::PAIR_DAMPED,
    linear::LPR,
    wave::JUNCTION,
    wave::IMPEDANCE,
    friction::BOW,
    contact::PHASE,
    contact::VISCOUS,
    contact::STABLE,
    contact::STABLE3D,
    device::LINEAR,
    device::HOLD,
    device::LOOP_HALF,
    device::LOOP_ONE,
    device::LOOP_LATE,
    device::LOOP_LATER,
];

/// A cell of a map, after playing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Middle of the cell, in the numbers of the axes.
    pub at: [f64; 2],
    /// Result of the engine.
    pub grows: bool,
    /// Result of theory, if it is the same in the whole band around the cell.
    pub theory: Option<bool>,
}

impl Cell {
    /// Returns true if the engine contradicts theory.
    pub fn contradicts(&self) -> bool {
        self.theory.is_some_and(|said| said != self.grows)
    }
}

/// A map after playing: cells by rows, from the bottom.
pub struct Field {
    /// Number of cells in a row.
    pub across: usize,
    /// Cells.
    pub cells: Vec<Cell>,
}

impl Map {
    /// Returns the result of theory at this place, if it is the same in the whole band around it.
    pub fn theory_at(&self, part: [f64; 2]) -> Option<bool> {
        let near = |dx: f64, dy: f64| {
            let place = [part[0] + dx * self.band, part[1] + dy * self.band].map(|p| p.clamp(0.0, 1.0));
            (self.theory)(self.axes[0].at(place[0]), self.axes[1].at(place[1]))
        };
        let here = near(0.0, 0.0);
        let around =
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)];
        here.filter(|_| around.iter().all(|(dx, dy)| near(*dx, *dy) == here))
    }

    /// Plays `across` × `up` cells.
    pub fn play(&self, across: usize, up: usize) -> Field {
        let cell = |i: usize| {
            let part = [((i % across) as f64 + 0.5) / across as f64, ((i / across) as f64 + 0.5) / up as f64];
            let at = [self.axes[0].at(part[0]), self.axes[1].at(part[1])];
            Cell { at, grows: (self.measured)(at[0], at[1]), theory: self.theory_at(part) }
        };
        Field { across, cells: (0..across * up).map(cell).collect() }
    }
}

impl Field {
    /// Returns the number of cells in which engine and theory contradict each other.
    pub fn contradictions(&self) -> usize {
        self.cells.iter().filter(|c| c.contradicts()).count()
    }

    /// Returns the number of cells for which theory has a result.
    pub fn judged(&self) -> usize {
        self.cells.iter().filter(|c| c.theory.is_some()).count()
    }
}

/// Ratio to its initial size beyond which a motion has grown.
const FAR: f64 = 1e6;

/// Returns the growth of a motion of size 1: its largest size in the last quarter of `ticks` over the largest in the
/// quarter before. Returns infinity if it exceeds [`FAR`] or is NaN. Both quarters of a motion that neither grows nor
/// decays are equal.
fn growth(ticks: usize, mut step: impl FnMut() -> f64) -> f64 {
    let mut most = [0.0f64; 4];
    for n in 0..ticks {
        let size = step();
        if size.is_nan() || size > FAR {
            return f64::INFINITY;
        }
        let quarter = &mut most[4 * n / ticks];
        *quarter = quarter.max(size);
    }
    if most[2] > 0.0 { most[3] / most[2] } else { 0.0 }
}
