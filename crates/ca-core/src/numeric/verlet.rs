//! Finds the pairs of two sets of points that are closer than a distance.
//!
//! It is a Verlet neighbour list with a skin: it lists the pairs within distance + skin, and is valid until a point has
//! moved half the skin. The caller measures each listed pair again, and an unlisted pair cannot have come near. All
//! pairs are tested instead if a list would not last long enough to pay, would not fit, or if rounding of large
//! positions consumes the skin. Both ways give pairs in the same order, so sums over them have the same bits. A grid in
//! every tick and a sweep along one axis were measured too; both are slower at any speed that sounds.
//!
//! Measured (`benches/contacts.rs`), in ns per tick, for grains at 0.001 diameters per tick that fill a tenth of a
//! shell, in brackets a third. At ten times the speed the list takes up to twice as long and is still the fastest:
//!
//! | grains | each pair a module | all tested (no skin) | list |
//! |---|---|---|---|
//! | 4 | 32 (73) | 59 (91) | 39 (59) |
//! | 8 | 137 (183) | 108 (108) | 71 (125) |
//! | 16 | 620 (490) | 205 (214) | 113 (181) |
//! | 64 | 8 000 (10 900) | 1 900 (2 100) | 510 (1 300) |
//! | 256 | 129 000 (124 000) | 15 700 (14 700) | 2 600 (4 700) |
//! | 1024 | | 215 000 (306 000) | 21 000 (45 000) |
//!
//! A pair that does not touch costs 4 ns and more as a module, and 0.4 to 0.8 ns where all are tested. Skins of a
//! quarter and of three quarters of the distance are within a fifth of the time with a half.
//!
//! The list is made with a uniform grid that wraps around, so that one point far away costs nothing and no bounding box
//! is needed. Points are sorted into its cells by counting. All arrays have their size from the start.
//!
//! Nothing here changes the future of a scene, so the hash of a state leaves it out. A restored state is correct
//! because displacements are measured from where the points were when the list was made.

use crate::numeric::Real;
use alloc::vec::Vec;

/// Skin at load, as a fraction of the distance asked for.
const SKIN: f64 = 0.5;
/// Cost of listing by the grid, per point, in tests of one pair.
const GRID: f64 = 400.0;
/// Factor by which the saving of a list must exceed its cost.
const WORTH: f64 = 2.0;
/// Capacity of the list, per point.
const ROOM: usize = 16;
/// Distances computed at a time when all pairs are tested.
const LANES: usize = 8;
/// Edge of a grid cell over the reach. It is above 1 so that rounding cannot put near points two cells apart.
const WIDER: f64 = 1.01;
/// Rounding error of a position, relative to the numbers it is the sum of, with a generous margin.
const ROUNDING: f64 = 4096.0 * f64::EPSILON;

/// Points and the pairs of them that are near. Pairs are (row, column): each row is paired with all columns after it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VerletList {
    /// number of points; the last ones may only be columns
    n: usize,
    rows: usize,
    first: usize,
    /// positions \[m\] (3 x n, padded with points that are never near)
    at: [Vec<f64>; 3],
    /// positions when the list was made \[m\] (3 x n)
    was: [Vec<f64>; 3],
    /// largest distance a point has moved since \[m\]; infinite if one is not finite
    moved: f64,
    /// largest rounding error of a distance \[m\]
    rounding: f64,
    /// distance up to which pairs are listed \[m\]
    reach: f64,
    /// true if the pairs did not fit in the list
    full: bool,
    /// first entry of each row in `list` (rows + 1)
    start: Vec<u32>,
    list: Vec<u32>,
    /// cells along each axis of the grid, as the exponent of 2
    bits: u32,
    /// cell of each column (columns)
    cell: Vec<u32>,
    /// first entry of each cell in `order`, shifted by one (cells + 2)
    head: Vec<u32>,
    /// columns by cell (columns)
    order: Vec<u32>,
    /// skin as a fraction of the distance asked for; at 0 all pairs are tested
    pub skin: f64,
    /// number of lists made so far
    pub lists: u64,
}

impl VerletList {
    /// Makes a list for `n` points. The first `rows` are paired with those from `first` on that come after them.
    pub fn new(n: usize, rows: usize, first: usize) -> VerletList {
        let columns = n - first;
        // at least four, so that a cell and its two neighbours are three different ones
        let bits = (2..10).find(|b| 1usize << (3 * b) >= columns).unwrap_or(10);
        let none = || alloc::vec![f64::INFINITY; n];
        let at = || alloc::vec![f64::INFINITY; n + LANES];
        VerletList {
            n,
            rows,
            first,
            at: [at(), at(), at()],
            was: [none(), none(), none()],
            moved: f64::INFINITY,
            rounding: f64::INFINITY,
            start: alloc::vec![0; rows + 1],
            list: alloc::vec![0; (ROOM * n).min(rows.saturating_mul(columns))],
            skin: SKIN,
            bits,
            cell: alloc::vec![0; columns],
            head: alloc::vec![0; (1 << (3 * bits)) + 2],
            order: alloc::vec![0; columns],
            ..VerletList::default()
        }
    }

    /// Returns the number of pairs.
    pub fn pairs(&self) -> f64 {
        let (n, rows) = (self.n as f64, self.rows as f64);
        if self.first == 0 { 0.5 * n * (n - 1.0) } else { rows * (n - rows) }
    }

    /// Returns the number of pairs in the list, or 0 if all are tested instead.
    pub fn listed(&self) -> usize {
        if self.full { 0 } else { self.start.last().map_or(0, |end| *end as usize) }
    }

    /// Sets the positions: `point` gives the rest position and the displacement of each point \[m\].
    #[inline(always)]
    pub fn place(&mut self, point: impl Fn(usize) -> [[f64; 3]; 2]) {
        let n = self.n;
        let [x, y, z] = &mut self.at;
        let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
        let [x0, y0, z0] = &self.was;
        let (x0, y0, z0) = (&x0[..n], &y0[..n], &z0[..n]);
        let (mut moved, mut size): (f64, f64) = (0.0, 0.0);
        for k in 0..n {
            let [r, d] = point(k);
            (x[k], y[k], z[k]) = (r[0] + d[0], r[1] + d[1], r[2] + d[2]);
            let step = [x[k] - x0[k], y[k] - y0[k], z[k] - z0[k]];
            moved = moved.max(finite(step[0] * step[0] + step[1] * step[1] + step[2] * step[2]));
            let sum = (r[0].abs() + r[1].abs() + r[2].abs()) + (d[0].abs() + d[1].abs() + d[2].abs());
            size = size.max(finite(sum));
        }
        self.moved = Real::sqrt(moved);
        self.rounding = ROUNDING * size;
    }

    /// Returns true if the list, provided that it is not full, is valid for pairs closer than `radius` \[m\].
    fn serves(&self, radius: f64) -> bool {
        radius + 2.0 * self.moved + 4.0 * self.rounding <= self.reach
    }

    /// Makes a new list for pairs closer than `radius` \[m\] if the old one is no longer valid and a new one pays. This
    /// depends on the square of the `speed` \[m/tick\] of the points.
    #[inline(always)]
    pub fn renew(&mut self, radius: f64, speed: impl Fn(usize) -> f64) {
        let skin = self.skin * radius;
        if self.serves(radius) || !(skin > 0.0 && skin < f64::INFINITY) {
            return;
        }
        let fastest = (0..self.n).map(speed).fold(0.0, |a: f64, v| a.max(finite(v)));
        // a list lasts until the fastest point has moved half the skin, and saves testing all pairs in each tick
        let (pairs, grid) = (self.pairs(), GRID * self.n as f64);
        let (half, cost) = (0.5 * skin * pairs, WORTH * pairs.min(grid));
        if half * half >= cost * cost * fastest && 8.0 * self.rounding <= skin {
            self.list(radius + skin, grid < pairs);
        }
    }

    /// Calls `visit` for every pair that may be closer than `radius` \[m\], by rows and then by columns. Some visited
    /// pairs are farther apart, so the caller must measure each. An infinite radius visits all pairs.
    #[inline(always)]
    pub fn each(&self, radius: f64, mut visit: impl FnMut(usize, usize)) {
        let far = self.far(radius);
        if self.full || !self.serves(radius) {
            return self.all(far, visit);
        }
        let [x, y, z] = &self.at;
        for i in 0..self.rows {
            for j in &self.list[self.start[i] as usize..self.start[i + 1] as usize] {
                let j = *j as usize;
                let (dx, dy, dz) = (x[j] - x[i], y[j] - y[i], z[j] - z[i]);
                if !is_far(dx * dx + dy * dy + dz * dz, far) {
                    visit(i, j);
                }
            }
        }
    }

    /// Returns the squared distance from which on a pair is not closer than `radius`; NaN for an infinite `radius`.
    fn far(&self, radius: f64) -> f64 {
        let far = radius + 4.0 * self.rounding;
        if far < f64::INFINITY { far * far } else { f64::NAN }
    }

    /// Calls `visit` for every pair that is not `far`, by testing all pairs.
    #[inline(always)]
    fn all(&self, far: f64, mut visit: impl FnMut(usize, usize)) {
        let [x, y, z] = &self.at;
        for i in 0..self.rows {
            let (xi, yi, zi) = (x[i], y[i], z[i]);
            let mut j = self.first.max(i + 1);
            while j < self.n {
                let (x, y, z) = (&x[j..][..LANES], &y[j..][..LANES], &z[j..][..LANES]);
                let mut square = [0.0; LANES];
                for k in 0..LANES {
                    let (dx, dy, dz) = (x[k] - xi, y[k] - yi, z[k] - zi);
                    square[k] = dx * dx + dy * dy + dz * dz;
                }
                if !square.iter().fold(true, |all, s| all & is_far(*s, far)) {
                    for (k, square) in square.iter().enumerate().take(self.n - j) {
                        if !is_far(*square, far) {
                            visit(i, j + k);
                        }
                    }
                }
                j += LANES;
            }
        }
    }

    #[inline(always)]
    fn list(&mut self, reach: f64, by_grid: bool) {
        self.reach = reach;
        self.moved = 0.0;
        self.lists += 1;
        for (was, at) in self.was.iter_mut().zip(&self.at) {
            was.copy_from_slice(&at[..self.n]);
        }
        let far = self.far(reach);
        let (mut list, mut start) = (core::mem::take(&mut self.list), core::mem::take(&mut self.start));
        let mut end = 0;
        if by_grid {
            self.fill_grid(1.0 / (reach * WIDER));
            for i in 0..self.rows {
                let begin = end;
                self.around(i, 1.0 / (reach * WIDER), far, |j| {
                    list.get_mut(end).into_iter().for_each(|entry| *entry = j as u32);
                    end += 1;
                });
                start[i + 1] = end as u32;
                list.get_mut(begin..end).into_iter().for_each(<[u32]>::sort_unstable);
            }
        } else {
            start.fill(0);
            self.all(far, |i, j| {
                list.get_mut(end).into_iter().for_each(|entry| *entry = j as u32);
                end += 1;
                start[i + 1] = end as u32;
            });
            // a row without pairs ends where the row before it ends
            (0..self.rows).for_each(|i| start[i + 1] = start[i + 1].max(start[i]));
        }
        self.full = end > list.len();
        (self.list, self.start) = (list, start);
    }

    fn fill_grid(&mut self, inverse: f64) {
        let grid = Grid { bits: self.bits, inverse };
        self.head.fill(0);
        for (k, c) in self.cell.iter_mut().enumerate() {
            let p = grid.place(grid.cell(&self.at, self.first + k));
            *c = p as u32;
            self.head[p + 1] += 1;
        }
        let mut sum = 0;
        for h in &mut self.head {
            sum += *h;
            *h = sum;
        }
        // filling moves each end back to its start: afterwards the columns of cell c begin at head[c + 1]
        for (k, c) in self.cell.iter().enumerate().rev() {
            let end = &mut self.head[*c as usize + 1];
            *end -= 1;
            self.order[*end as usize] = (self.first + k) as u32;
        }
    }

    /// Calls `visit` for the columns after row `i` that are not `far` from it, cell by cell.
    #[inline(always)]
    fn around(&self, i: usize, inverse: f64, far: f64, mut visit: impl FnMut(usize)) {
        let grid = Grid { bits: self.bits, inverse };
        let [x, y, z] = &self.at;
        let least = self.first.max(i + 1);
        for cells in grid.around(grid.cell(&self.at, i)) {
            let [from, to] = [cells.start, cells.end].map(|c| self.head[c + 1] as usize);
            for j in &self.order[from..to] {
                let j = *j as usize;
                let (dx, dy, dz) = (x[j] - x[i], y[j] - y[i], z[j] - z[i]);
                if j >= least && !is_far(dx * dx + dy * dy + dz * dz, far) {
                    visit(j);
                }
            }
        }
    }
}

/// A grid of cubes that wraps around.
struct Grid {
    /// cells along each axis, as the exponent of 2
    bits: u32,
    /// one over the edge of a cell \[1/m\]
    inverse: f64,
}

impl Grid {
    #[inline(always)]
    fn cell(&self, at: &[Vec<f64>; 3], k: usize) -> [i64; 3] {
        [0, 1, 2].map(|a| {
            let v = at[a][k] * self.inverse;
            let whole = v as i64;
            whole.wrapping_sub(i64::from(v < whole as f64))
        })
    }

    #[inline(always)]
    fn place(&self, cell: [i64; 3]) -> usize {
        let [i, j, k] = cell.map(|c| c as usize & ((1 << self.bits) - 1));
        i | j << self.bits | k << (2 * self.bits)
    }

    /// Returns the indices of a cube and its neighbours. Three along the first axis are one range, unless they wrap.
    #[inline(always)]
    fn around(&self, [i, j, k]: [i64; 3]) -> impl Iterator<Item = core::ops::Range<usize>> + use<> {
        let (bits, mask) = (self.bits, (1usize << self.bits) - 1);
        let i = i as usize & mask;
        let whole = i > 0 && i < mask;
        let along = if whole {
            [(i - 1, i + 2), (0, 0), (0, 0)]
        } else {
            [i.wrapping_sub(1), i, i + 1].map(|c| (c & mask, (c & mask) + 1))
        };
        let runs = if whole { 1 } else { 3 };
        (0..9i64).flat_map(move |s| {
            let row = |c: i64, step: i64| c.wrapping_add(step - 1) as usize & mask;
            let base = row(j, s % 3) << bits | row(k, s / 3) << (2 * bits);
            (0..runs).map(move |r| base + along[r].0..base + along[r].1)
        })
    }
}

/// Replaces a number that is not finite by infinity.
#[inline(always)]
fn finite(v: f64) -> f64 {
    if v < f64::INFINITY { v } else { f64::INFINITY }
}

#[inline(always)]
fn is_far(square: f64, far: f64) -> bool {
    square >= far
}
