//! The arrays of a state for links, ports and outputs.

use super::{ActiveContacts, Border, Cell};
use crate::numeric::{Aligned, Real, VerletList};
use alloc::vec::Vec;

/// Numbers that links and moving points store between ticks or pass on within one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkState<R: Real = f64> {
    /// memory of laws, then of waves (n_mem); written by `forces`, departing waves by `moves`
    pub mem: Vec<R>,
    /// forces of links that outputs or the ledger read, and temporary ones \[N\] (n_tap); written by `forces`
    pub tap: Aligned<R>,
    /// distances one tick before \[m\], of ports that are measured in every tick, in the order of
    /// [`LinkArrays::reach`](crate::op::layout::LinkArrays::reach); −1 where unknown, to be had from motion; written by
    /// `forces`
    pub lengths: Aligned<R>,
    /// near members of sets (pair sets); written by `forces`, without effect on the future
    pub near: Vec<VerletList>,
    /// cells of the moving points (moving_points); written by `aim`
    pub cells: Vec<Cell<R>>,
    /// temporary, of implicit links: changes of motion \[m/tick²\] (places), then the part of MATs \[N\] (places); by
    /// `forces`
    pub implicit: Vec<R>,
    /// contacts solved together; empty between ticks, written by `forces`
    pub touches: ActiveContacts<R>,
}

/// Numbers that ports and output filters store.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PortState<R: Real = f64> {
    /// last valid value of each input (inputs); written by `reads`
    pub last_input: Vec<f64>,
    /// number of inputs that were not finite and were held or replaced by zero
    pub refused: u64,
    /// device ports (tgr); written by the border
    pub border: Vec<Border>,
    /// delayed positions of devices, absolute \[m\] (tgr x latency), a ring each; written by the border
    pub late: Vec<f64>,
    /// last and present value of inputs given once per sample of several ticks (inputs); written by `reads`
    pub glide: Vec<[f64; 2]>,
    /// last input and last result of each high-pass of an output (blockers); written by `writes`
    pub blocked: Vec<[R; 2]>,
    /// present and next position \[m\] of ports that run a tick late
    /// ([`PortArrays::ahead`](crate::op::layout::PortArrays::ahead)) (ahead); written by `reads`
    pub under_way: Vec<[R; 2]>,
    /// change of motion of such a port in this tick \[m\] (n_mat, or none); written by `reads`
    pub turns: Vec<R>,
    /// past of the sound channels before the low-pass (channels x 2n), one ring each, stored twice; written by `writes`
    pub lowpass: Vec<R>,
}
