//! The state of a scene: all numbers that change while it plays, as flat arrays.
//!
//! A state is plain data: a clone is a snapshot, an assignment restores it, and a hash of its bits serves tests.
//! Positions are relative to rest and motion is the change per tick, which drifts less than two absolute positions
//! (docs/numerics.md §1.6).

pub(crate) mod active_contacts;
pub(crate) mod ledger;
mod parts;
mod snapshot;

use crate::numeric::word_hash::word;
use crate::numeric::{Aligned, Real};
pub use active_contacts::ActiveContacts;
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::hash::Hasher;
pub use ledger::{Balance, Exchange, Extremes, GroupAccount, Ledger, set_kick};
pub use parts::{LinkState, PortState};
pub use snapshot::{NotRestored, SNAPSHOT_VERSION, checksum};

/// Nodes under a moving point, and their weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Cell<R: Real = f64> {
    /// number of nodes used: 2 on a string, 4 on a mesh
    pub n: usize,
    /// slots of the MATs
    pub node: [u32; 4],
    /// weights, which sum to 1
    pub weight: [R; 4],
}

/// One degree of freedom of a device within its gesture frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Border {
    /// position at the start of the frame \[m\]
    pub from: f64,
    /// position at the end of the frame \[m\]
    pub to: f64,
    /// force summed so far in the frame \[N\]
    pub sum: f64,
    /// force on the device in the last whole frame \[N\]
    pub force: f64,
}

/// One MAT of a group at the gesture rate within its frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Between {
    /// position at the start of the frame \[m\], relative to rest
    pub from: f64,
    /// position at the end of the frame \[m\]
    pub to: f64,
    /// force of the links across the border at the last tick \[N\]
    pub force: f64,
}

/// Mean forces of frames \[N\] on one MAT of a group with `border = "compensated"`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Unknown {
    /// sum so far of the links across the border in the current frame
    pub(crate) sum: f64,
    /// force given to the group for this frame
    pub(crate) given: f64,
    /// part of `given` that was not known in advance, extrapolated from the three frames before
    pub(crate) expected: f64,
    /// actual value of that part in the last whole frame and the one before
    pub(crate) last: [f64; 2],
}

/// State of the groups at the gesture rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlowState<R: Real = f64> {
    /// their own state, one tick per frame: positions half a frame after the frame just played, `d` since half a frame
    /// before
    pub state: State<R>,
    /// MATs in the order of [`SlowGroup::ports`](crate::op::layout::SlowGroup::ports)
    pub ports: Vec<Between>,
    /// MATs that links across the border join, if the border is compensated (coupled, or none)
    pub unknown: Vec<Unknown>,
    /// working memory: motion in the frame without the response to it \[m\] (coupled)
    pub(crate) free: Vec<f64>,
}

impl<R: Real> SlowState<R> {
    /// Makes the state at load. `ports` and `coupled` are counts; the border is `compensated` or exact.
    pub fn new(state: State<R>, ports: usize, coupled: usize, compensated: bool) -> SlowState<R> {
        let unknown = if compensated { coupled } else { 0 };
        SlowState {
            state,
            ports: alloc::vec![Between::default(); ports],
            unknown: alloc::vec![Unknown::default(); unknown],
            free: alloc::vec![0.0; coupled],
        }
    }
}

/// Coefficients that are moving to a new value (one entry per live coefficient).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ramps<R: Real = f64> {
    /// index of each into [`State::coef`]
    pub(crate) index: Vec<u32>,
    pub(crate) left: Vec<u32>,
    pub(crate) step: Vec<R>,
    pub(crate) target: Vec<R>,
    /// entries with ticks left: the first `moving` ones count (full length, so that a clone has the capacity too)
    pub(crate) active: Vec<u32>,
    pub(crate) moving: usize,
    /// entries from here on change in one tick, together with all that depends on them
    pub(crate) instant: u32,
}

impl<R: Real> Ramps<R> {
    /// Makes ramps of the live coefficients at these indices into [`State::coef`]; from `whole` on they change in one
    /// tick.
    pub fn new(index: Vec<u32>, whole: u32) -> Ramps<R> {
        let n = index.len();
        Ramps {
            index,
            left: alloc::vec![0; n],
            step: alloc::vec![R::ZERO; n],
            target: alloc::vec![R::ZERO; n],
            active: alloc::vec![0; n],
            moving: 0,
            instant: whole,
        }
    }

    /// Returns true while a coefficient is moving.
    pub fn is_moving(&self) -> bool {
        self.moving > 0
    }
}

/// Eight stretches of an array side by side, the order of long rows (`op/links/folded.rs`): number i is at
/// [`Fold::at`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fold {
    /// index of the first number
    pub first: u32,
    /// numbers per stretch
    pub rows: u32,
}

impl Fold {
    /// Number of stretches.
    pub const LANES: usize = 8;

    /// Returns the index of number `i`.
    pub fn at(self, i: usize) -> usize {
        let rows = self.rows as usize;
        self.first as usize + i % rows * Fold::LANES + i / rows
    }
}

/// Identifies the scene of a state or a patch; the default belongs to no scene. It is computed in `scene/identity.rs`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Identity(pub(crate) u64);

/// Largest number of pointers at a time, one for each finger.
pub const FINGERS: usize = 10;

/// Marks an unknown length in [`LinkState::lengths`].
pub const UNKNOWN: f64 = -1.0;

/// All numbers that change, as made by [`Scene::state`](crate::Scene::state). Shapes are in parentheses, and each array
/// names the stage of a tick that writes it: `reads`, `forces`, `writes` or `moves`.
///
/// A caller may change values but not the lengths of arrays, on which a tick relies. After changing the position or
/// motion of points in space while a state plays, call [`State::placed`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<R: Real = f64> {
    /// scene of the state; written at load
    pub(crate) scene: Identity,
    /// displacement from rest \[m\] (n_mat); written by `moves`, ports by `reads`
    pub x: Aligned<R>,
    /// x_n − x_{n−1} \[m/tick\] (n_mat); written with `x`
    pub d: Aligned<R>,
    /// summed force \[N\] (n_mat), without the links that `moves` sums; written by `forces`, cleared by `moves`
    pub f: Aligned<R>,
    /// coefficients (n_coef): P, Q, C of MATs, then weights, links, points, outputs; written at load and by changes
    pub coef: Aligned<R>,
    /// port inputs, absolute \[m\] or \[N\]; written by the caller before a tick (devices: before a frame)
    pub input: Vec<f64>,
    /// output values (n_out); written by `writes`
    pub output: Vec<R::Outer>,
    /// numbers of links
    pub links: LinkState<R>,
    /// numbers of ports and outputs
    pub ports: PortState<R>,
    /// groups at the gesture rate; boxed, since a pass takes it out while writing it
    pub slow: Option<Box<SlowState<R>>>,
    /// coefficients moving to a new value
    pub ramps: Ramps<R>,
    /// indices into `x` and `d`, and into `coef`, in document order; empty if rows are in that order; written at load
    pub(crate) written: [Arc<[u32]>; 2],
    /// energy ledger, if the scene has one; boxed, since a pass takes it out while writing it
    pub ledger: Option<Box<Ledger<R>>>,
    /// samples played (equal to ticks unless a sample has several); while passes run, always ticks
    pub tick: u64,
}

/// Returns the scene of a state.
pub fn scene_of<R: Real>(state: &State<R>) -> Identity {
    state.scene
}

/// Assigns a state to a scene.
pub fn give_to<R: Real>(state: &mut State<R>, scene: Identity) {
    state.scene = scene;
}

/// Sets the document order of MATs and coefficients, as indices into `x` and `d`, and into `coef`; empty if unchanged.
pub fn set_order<R: Real>(state: &mut State<R>, order: [Arc<[u32]>; 2]) {
    state.written = order;
}

/// Returns the number of MAT slots and of coefficients in a state, without padding of rows.
pub fn shape<R: Real>(state: &State<R>) -> [usize; 2] {
    let [slots, coefs] = &state.written;
    [(slots, &state.x), (coefs, &state.coef)].map(|(order, all)| if order.is_empty() { all.len() } else { order.len() })
}

impl<R: Real> State<R> {
    /// Returns a hash of everything that determines the future: FNV-1a over the bits of positions, motions,
    /// coefficients, memory, border, inputs under way, output filters and tick.
    ///
    /// Equal states have equal hashes on every machine, whatever the order of their rows.
    pub fn bits(&self) -> u64 {
        let mut h = fnv::FnvHasher::default();
        let [slots, coefs] = &self.written;
        for (all, order) in [(&self.x, slots), (&self.d, slots), (&self.coef, coefs)] {
            let mut each = |v: &R| word(&mut h, v.wide().to_bits());
            if order.is_empty() {
                all.iter().for_each(&mut each);
            } else {
                order.iter().for_each(|i| each(&all[*i as usize]));
            }
        }
        let flat = self.links.mem.iter().map(|v| v.wide());
        let filters = self.ports.lowpass.iter().chain(self.ports.blocked.iter().flatten()).map(|v| v.wide());
        // unknown lengths have no effect
        let lengths = self.links.lengths.iter().filter(|l| **l != R::of(UNKNOWN)).map(|l| l.wide());
        for v in flat
            .chain(self.ports.late.iter().copied())
            .chain(filters)
            .chain(self.ports.glide.iter().flatten().copied())
            .chain(self.ports.under_way.iter().flatten().map(|v| v.wide()))
            .chain(lengths)
        {
            word(&mut h, v.to_bits());
        }

        for b in &self.ports.border {
            for v in [b.from, b.to, b.sum] {
                word(&mut h, v.to_bits());
            }
        }
        if let Some(slow) = &self.slow {
            word(&mut h, slow.state.bits());
            let unknown = slow.unknown.iter().flat_map(|u| [u.sum, u.given, u.expected, u.last[0], u.last[1]]);
            let ports = slow.ports.iter().flat_map(|p| [p.from, p.to, p.force]);
            ports.chain(unknown).for_each(|v| word(&mut h, v.to_bits()));
        }
        h.write(&self.tick.to_le_bytes());
        h.finish()
    }

    /// Must be called after writing positions or motion from outside. Distances of the tick before are then computed
    /// from the motion again. Kept distances would act as a blow.
    pub fn placed(&mut self) {
        self.links.lengths.fill(R::of(UNKNOWN));
    }

    /// Returns true while every position and motion is finite and below `limit` \[m\].
    pub fn is_bounded(&self, limit: f64) -> bool {
        // testing each number takes as long as a tick; a fold over a block is vectorised
        let within = |block: &[R]| block.iter().fold(true, |all, v| all & (v.abs().wide() < limit));
        self.x.chunks(64).chain(self.d.chunks(64)).all(within)
    }

    /// Returns the value of a position input. A value that is not finite is counted and replaced by the last valid one.
    pub(crate) fn valid_input(&mut self, input: u32) -> f64 {
        let i = input as usize;
        let v = self.input[i];
        if v.is_finite() {
            self.ports.last_input[i] = v;
        } else {
            self.ports.refused += 1;
        }
        self.ports.last_input[i]
    }
}
