//! State: all numbers that change while a scene plays, as flat arrays.
//!
//! Decides that a state is plain data: a clone is a snapshot, assigning it restores, a hash of its bits is a golden
//! number. Positions are relative to rest and motion is the change per tick, which drifts far less than keeping two
//! absolute positions (docs/numerics.md §1.6).

pub(crate) mod active_contacts;
pub(crate) mod ledger;
mod parts;
mod snapshot;

use crate::numeric::words::word;
use crate::numeric::{Aligned, Real};
pub use active_contacts::ActiveContacts;
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::hash::Hasher;
pub use ledger::{Balance, Exchange, Extremes, GroupAccount, Ledger, set_kick};
pub use parts::{LinkState, PortState};
pub use snapshot::{NotRestored, SNAPSHOT_VERSION, checksum};

/// Nodes and weights under a moving point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Cell<R: Real = f64> {
    /// how many of the four are used: 2 on a string, 4 on a mesh
    pub n: usize,
    /// places among the MATs
    pub node: [u32; 4],
    /// weights, which sum to 1
    pub weight: [R; 4],
}

/// One device degree of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Border {
    /// position at the start of the frame \[m\]
    pub from: f64,
    /// position at its end \[m\]
    pub to: f64,
    /// what has been collected of the force so far \[N\]
    pub sum: f64,
    /// force of the last whole frame \[N\], on the hand
    pub force: f64,
}

/// A place of a group at the gesture rate within its frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Between {
    /// position at the start of the frame \[m\], relative to rest
    pub from: f64,
    /// position at its end \[m\]
    pub to: f64,
    /// force of the links across on it at the last tick \[N\]
    pub force: f64,
}

/// What a place of a group is given by a border that does not know all of a frame as it begins (`border = "compensated"`):
/// mean forces \[N\] of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Unknown {
    /// of the links across in the frame being played: what has been summed of it
    pub(crate) sum: f64,
    /// what the group was given for this frame
    pub(crate) given: f64,
    /// of that, the part that was not known, as expected from the three frames before
    pub(crate) expected: f64,
    /// that part as it was, in the last whole frame and the one before
    pub(crate) last: [f64; 2],
}

/// The groups at the gesture rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlowState<R: Real = f64> {
    /// their own state, whose tick is a frame: positions are those half a frame after the one just played, `d` the motion
    /// since half a frame before
    pub state: State<R>,
    /// as [`SlowGroup::ports`](crate::op::layout::SlowGroup::ports)
    pub ports: Vec<Between>,
    /// of those that links across hold, where the border is compensated (coupled, or none)
    pub unknown: Vec<Unknown>,
    /// motion in the frame without what answers it \[m\], in passing (coupled)
    pub(crate) free: Vec<f64>,
}

impl<R: Real> SlowState<R> {
    /// At load: `state` as it begins, so many `ports`, so many of them `coupled`, by a border that is `compensated` or exact.
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

/// Coefficients on their way (live coefficients each).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ramps<R: Real = f64> {
    /// the coefficients
    pub(crate) index: Vec<u32>,
    pub(crate) left: Vec<u32>,
    pub(crate) step: Vec<R>,
    pub(crate) target: Vec<R>,
    /// those with ticks left: the first `moving` entries (as long as the others, so that a clone has room too)
    pub(crate) active: Vec<u32>,
    pub(crate) moving: usize,
    /// from here on they only change in one tick, and what changes with them does so too
    pub(crate) whole: u32,
}

impl<R: Real> Ramps<R> {
    /// Room for the live coefficients at these indices into [`State::coef`], those from `whole` on never half-way.
    pub fn new(index: Vec<u32>, whole: u32) -> Ramps<R> {
        let n = index.len();
        Ramps {
            index,
            left: alloc::vec![0; n],
            step: alloc::vec![R::ZERO; n],
            target: alloc::vec![R::ZERO; n],
            active: alloc::vec![0; n],
            moving: 0,
            whole,
        }
    }

    /// True while something is on its way.
    pub fn is_moving(&self) -> bool {
        self.moving > 0
    }
}

/// Eight stretches of an array side by side: number i of 8 `rows` stands at [`Fold::at`]. The order of long rows of links and
/// of their masses (`op/links/folded.rs`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fold {
    /// index of the first number
    pub first: u32,
    /// numbers of a stretch
    pub rows: u32,
}

impl Fold {
    /// Stretches.
    pub const LANES: usize = 8;

    /// Index of number `i`.
    pub fn at(self, i: usize) -> usize {
        let rows = self.rows as usize;
        self.first as usize + i % rows * Fold::LANES + i / rows
    }
}

/// Which scene a state or a patch belongs to; the default is that of no scene. How it comes about: `scene/identity.rs`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Identity(pub(crate) u64);

/// A length that is not kept yet, in [`LinkState::lengths`].
pub const UNKNOWN: f64 = -1.0;

/// All that changes, as [`Scene::state`](crate::Scene::state) makes it. Shapes in brackets; the writer of each array is
/// named. Values may be written from outside, lengths of arrays may not: a tick relies on them. Who writes places or motion of
/// points in space while a state plays calls [`State::placed`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<R: Real = f64> {
    /// the scene it belongs to; written at load
    pub(crate) scene: Identity,
    /// displacement from rest \[m\] (n_mat); written by `moves`, ports by `reads`
    pub x: Aligned<R>,
    /// x_n − x_{n−1} \[m/tick\] (n_mat); written with `x`
    pub d: Aligned<R>,
    /// summed force \[N\] (n_mat), without that of rows that `moves` sum; written by `forces`, cleared by `moves`
    pub f: Aligned<R>,
    /// coefficients (n_coef): P, Q and C of the MATs, then those of weights, links, points and outputs;
    /// written at load and by changes
    pub coef: Aligned<R>,
    /// what the ports are given, absolute \[m\] or \[N\]; written by the caller before a tick (devices: before a frame)
    pub input: Vec<f64>,
    /// what is heard (n_out); written by `writes`
    pub output: Vec<R::Outer>,
    /// what links keep
    pub links: LinkState<R>,
    /// what ports and outputs keep
    pub ports: PortState<R>,
    /// groups at the gesture rate; boxed, since a pass takes it out for the time it writes it
    pub slow: Option<Box<SlowState<R>>>,
    /// coefficients on their way to a new value
    pub ramps: Ramps<R>,
    /// indices into `x` and `d`, and into `coef`, in the order of the document, where rows stand otherwise; else empty;
    /// written at load
    pub(crate) written: [Arc<[u32]>; 2],
    /// energy ledger, where the scene keeps one; boxed, since a pass takes it out for the time it writes it
    pub ledger: Option<Box<Ledger<R>>>,
    /// samples done, which are ticks where a sample has one; while passes run, ticks in any case
    pub tick: u64,
}

/// The scene of a state.
pub fn scene_of<R: Real>(state: &State<R>) -> Identity {
    state.scene
}

/// Gives a state to a scene.
pub fn give_to<R: Real>(state: &mut State<R>, scene: Identity) {
    state.scene = scene;
}

/// Says where the places and the coefficients of the document stand: indices into `x` and `d`, and into `coef`; none where they
/// stand in its order.
pub fn set_order<R: Real>(state: &mut State<R>, order: [Arc<[u32]>; 2]) {
    state.written = order;
}

/// The number of places of masses and the number of coefficients in a state, without what fills up rows.
pub fn shape<R: Real>(state: &State<R>) -> [usize; 2] {
    let [slots, coefs] = &state.written;
    [(slots, &state.x), (coefs, &state.coef)].map(|(order, all)| if order.is_empty() { all.len() } else { order.len() })
}

impl<R: Real> State<R> {
    /// A hash of everything that decides the future: FNV-1a over the bits of positions, motions, coefficients, memory,
    /// border, inputs under way, filters of the outputs and tick. Equal states have equal hashes on every machine, wherever
    /// rows stand.
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
        // those that are not known decide nothing
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

    /// Places or motion were written from outside: what distances were one tick before follows from these again, and not from
    /// where points were then, which would be a blow.
    pub fn placed(&mut self) {
        self.links.lengths.fill(R::of(UNKNOWN));
    }

    /// True while every position and motion is finite and below `limit` \[m\].
    pub fn is_bounded(&self, limit: f64) -> bool {
        // a look at each number by itself takes as long as a tick; a block at a time is a loop of vectors
        let within = |block: &[R]| block.iter().fold(true, |all, v| all & (v.abs().wide() < limit));
        self.x.chunks(64).chain(self.d.chunks(64)).all(within)
    }

    /// The value of a position input; one that is not finite is replaced by the last good one, and counted.
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
