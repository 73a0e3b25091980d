//! The stability atlas: what the running engine does over a plane of parameters, beside what theory says it must.
//!
//! Decides on measuring by playing: a cell is a scene compiled from text and ticked, never a question to the
//! certificate, so that a mistake shared by certificate and theory would still be seen. A map is one entry of [`MAPS`];
//! theory is a function of the same two numbers, and may be silent where nothing is proven. A cell contradicts where
//! both speak and differ; next to the boundary, within [`Map::band`], a run of finite length cannot tell and is not
//! asked.

mod contact;
mod device;
mod friction;
mod linear;
pub mod orders;
pub mod page;
pub mod poison;
pub mod survival;
pub mod svg;
mod wave;

pub use contact::{contact, exact, ratio};
pub use device::limit;

/// One axis of a map.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// what it is, with its unit
    pub name: &'static str,
    /// its ends; exponents of ten where `log`
    pub ends: [f64; 2],
    /// the number is ten to the power of the place
    pub log: bool,
}

impl Axis {
    const fn of(name: &'static str, from: f64, to: f64) -> Axis {
        Axis { name, ends: [from, to], log: false }
    }

    /// An axis of powers of ten, from and to these exponents.
    pub const fn log(name: &'static str, from: f64, to: f64) -> Axis {
        Axis { name, ends: [from, to], log: true }
    }

    /// The number at a place from 0 to 1.
    pub fn at(&self, part: f64) -> f64 {
        let place = self.ends[0] + part * (self.ends[1] - self.ends[0]);
        if self.log { 10f64.powf(place) } else { place }
    }

    /// The place of a number, from 0 to 1 within the map.
    pub fn part(&self, value: f64) -> f64 {
        let place = if self.log { value.log10() } else { value };
        (place - self.ends[0]) / (self.ends[1] - self.ends[0])
    }
}

/// A line of theory.
#[derive(Clone, Debug)]
pub struct Line {
    /// its points, in the numbers of the axes
    pub points: Vec<[f64; 2]>,
    /// a rule or a special value, by which no cell is judged
    pub thin: bool,
}

impl Line {
    /// A boundary through these points.
    fn edge(points: Vec<[f64; 2]>) -> Line {
        Line { points, thin: false }
    }

    /// A straight line by which nothing is judged.
    fn rule(from: [f64; 2], to: [f64; 2]) -> Line {
        Line { points: vec![from, to], thin: true }
    }

    /// A boundary through the places that `at` gives from one number to another.
    fn curve(from: f64, to: f64, at: impl Fn(f64) -> [f64; 2]) -> Line {
        const N: u32 = 120;
        Line::edge((0..=N).map(|i| at(from + (to - from) * f64::from(i) / f64::from(N))).collect())
    }
}

/// One map.
pub struct Map {
    /// name of its file and its heading
    pub name: &'static str,
    /// a few words for the heading
    pub title: &'static str,
    /// what is played, and what theory says, with its source
    pub text: &'static str,
    /// across, upwards
    pub axes: [Axis; 2],
    /// what a cell is called where it does not grow, and where it does
    pub words: [&'static str; 2],
    /// whether the scene of these two numbers grows when it is played
    pub measured: fn(f64, f64) -> bool,
    /// whether theory says it grows; `None` where theory says nothing
    pub theory: fn(f64, f64) -> Option<bool>,
    /// what theory draws
    pub lines: fn() -> Vec<Line>,
    /// how near to a boundary a cell does not count, as a part of each axis
    pub band: f64,
}

/// All maps, in the order of the page. Another map is another entry.
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

/// A cell of a map that was played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// its middle, in the numbers of the axes
    pub at: [f64; 2],
    /// what the engine did
    pub grows: bool,
    /// what theory says, where it says the same all over the band around
    pub said: Option<bool>,
}

impl Cell {
    /// True where the engine did what theory excludes.
    pub fn contradicts(&self) -> bool {
        self.said.is_some_and(|said| said != self.grows)
    }
}

/// A map as it was played: cells across, then upwards.
pub struct Field {
    /// how many across
    pub across: usize,
    /// the cells
    pub cells: Vec<Cell>,
}

impl Map {
    /// What theory says of this place and of all within the band.
    pub fn said(&self, part: [f64; 2]) -> Option<bool> {
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
            Cell { at, grows: (self.measured)(at[0], at[1]), said: self.said(part) }
        };
        Field { across, cells: (0..across * up).map(cell).collect() }
    }
}

impl Field {
    /// Cells in which engine and theory contradict each other.
    pub fn contradictions(&self) -> usize {
        self.cells.iter().filter(|c| c.contradicts()).count()
    }

    /// Cells of which theory says something.
    pub fn judged(&self) -> usize {
        self.cells.iter().filter(|c| c.said.is_some()).count()
    }
}

/// A motion that is this many times what it began with has grown.
const FAR: f64 = 1e6;

/// How a motion of size 1 goes on: its largest size in the last quarter of `ticks` over that in the quarter before, or
/// infinity where it passed [`FAR`] or is not finite. Two quarters of a motion that neither grows nor dies are alike.
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
