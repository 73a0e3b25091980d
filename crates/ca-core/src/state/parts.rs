//! The arrays of a state that links, ports and outputs keep.

use super::{ActiveContacts, Border, Cell};
use crate::numeric::{Aligned, Real, VerletList};
use alloc::vec::Vec;

/// Numbers that links and their moving points keep from tick to tick, or hand on within one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkState<R: Real = f64> {
    /// memory of laws, then of waves (n_mem); written by `forces`, waves that leave by `moves`
    pub mem: Vec<R>,
    /// forces of links that are heard, audited or in passing \[N\] (n_tap); written by `forces`
    pub tap: Aligned<R>,
    /// distances of points in space one tick before, of ports that are measured in every tick \[m\], as
    /// [`LinkArrays::reach`](crate::op::layout::LinkArrays::reach); −1 where none is known, and motion has to say it; written by `forces`
    pub lengths: Aligned<R>,
    /// which members of sets are near (pair sets); written by `forces`, and no part of what decides the future
    pub near: Vec<VerletList>,
    /// cells of the moving points (moving_points); written by `aim`
    pub cells: Vec<Cell<R>>,
    /// in passing, of implicit links: changes of motion \[m/tick²\] (places), then what MATs add to them by
    /// themselves \[N\] (places); written by `forces`
    pub implicit: Vec<R>,
    /// contacts that are solved together; empty between ticks, written by `forces`
    pub touches: ActiveContacts<R>,
}

/// Numbers that ports and the filters of outputs keep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PortState<R: Real = f64> {
    /// the last good value of each input (inputs); written by `reads`
    pub last_input: Vec<f64>,
    /// inputs that were not finite and were held or zeroed instead
    pub refused: u64,
    /// device ports (tgr); written by the border
    pub border: Vec<Border>,
    /// positions of devices that are under way, absolute \[m\] (tgr x latency), a ring each; written by the border
    pub late: Vec<f64>,
    /// inputs that are given once a sample, where that has several ticks: the last and the present value (inputs);
    /// written by `reads`
    pub glide: Vec<[f64; 2]>,
    /// outputs with a high pass (blockers): what they heard last, and what they gave; written by `writes`
    pub blocked: Vec<[R; 2]>,
    /// ports that run a tick late ([`PortArrays::ahead`](crate::op::layout::PortArrays::ahead)): where they are and where they go
    /// \[m\] (ahead); written by `reads`
    pub under_way: Vec<[R; 2]>,
    /// what such a port adds to its last motion in this tick \[m\] (n_mat, or none); written by `reads`
    pub turns: Vec<R>,
    /// past of the sound channels before the low-pass (channels x 2n), a ring each, twice; written by `writes`
    pub lowpass: Vec<R>,
}
