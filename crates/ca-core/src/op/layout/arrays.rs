//! The arrays of a layout, in groups.
//!
//! A group is a plain structure in the layout, so that a pass reads its numbers like the numbers of the layout,
//! and that fields keep the order in which a plan holds them.

use super::{
    Crossing, DcBlocker, Driven, Enf, Enx, HeardLink, Modal, ModalCoupling, MovingPoint, Output, OutputRow, PairSet,
    SlowGroup, SolvedModal, Substeps,
};
use crate::numeric::Real;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// The rates of a layout, and what runs at another than its own.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Rates<R: Real = f64> {
    /// sound sample \[s\], 1/rate
    pub sample_dt: f64,
    /// sound samples per gesture frame
    pub ratio: u32,
    /// ticks per gesture frame: as many, unless a sample has several
    pub frame: u32,
    /// groups at the gesture rate
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub slow: Option<Arc<SlowGroup<R>>>,
    /// where a sample has several ticks
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub substeps: Option<Substeps<R>>,
}

/// The lengths of the arrays of a state.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// slots of MATs, moving points included: one for a MAT on a line, three in a row for one in space
    pub n_mat: usize,
    /// links, and places in a row that no link takes
    pub n_lia: usize,
    /// coefficients
    pub n_coef: usize,
    /// numbers of memory of laws and waves
    pub n_mem: usize,
    /// contacts that are solved together
    pub n_touch: usize,
    /// places for forces kept or in passing
    pub n_tap: usize,
    /// channels of sound; probes come after them in [`State::output`](crate::state::State)
    pub channels: usize,
    /// indices into [`State::output`](crate::state::State)
    pub n_out: usize,
}

/// The ends of links, and their measures.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct LinkArrays<R: Real = f64> {
    /// ends of links, first slot of the first and of the second MAT (n_lia x 2)
    pub ends: Vec<[u32; 2]>,
    /// ends of the second ports of quadripoles (any x 2)
    pub onto: Vec<[u32; 2]>,
    /// what a port in space needs beside its ends: for [`MeasureKind::Radial`](super::MeasureKind::Radial) the vector between the ends at rest \[m\] and
    /// the square of the softening length \[m²\], for [`MeasureKind::Along`](super::MeasureKind::Along) the direction and nothing (any x 4)
    pub reach: Vec<[R; 4]>,
    /// for each entry of `reach` how many links of its batch, from that one on, are a row: they join points that follow each
    /// other on both sides, the second ends behind the first, as far apart at rest as `rest` says. Or, below 0, how many are
    /// none (as `reach`)
    pub rows: Vec<i32>,
    /// sets of which all pairs are joined (any)
    pub pair_sets: Vec<PairSet>,
    /// constant part of the elongation \[m\] (n_lia)
    pub e0: Vec<R>,
}

/// The places of MATs at rest, and the MATs that follow others: moving points, and masses that go by their modes.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Places<R: Real = f64> {
    /// rest positions \[m\] (n_mat)
    pub rest: Vec<R>,
    /// nodes under moving points (any)
    pub nodes: Vec<u32>,
    /// moving points (any)
    pub moving_points: Vec<MovingPoint>,
    /// masses in groups that go by their modes (any)
    pub modal: Vec<Modal>,
    /// their shares in the modes (any)
    pub shares: Vec<R>,
    /// those of the masses at which links count on the motion to come, group by group (any)
    pub solved_modal: Vec<SolvedModal>,
    /// groups with several of these (any)
    pub modal_couplings: Vec<ModalCoupling>,
    /// how much a force on one of them moves another, as a part of what one on that itself does (any)
    pub couplings: Vec<R>,
}

/// Ports: what comes in, and what goes to devices.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct PortArrays<R: Real = f64> {
    /// position ports (any)
    pub enx: Vec<Enx<R>>,
    /// force ports (any)
    pub enf: Vec<Enf>,
    /// device ports (any), across the border
    pub tgr: Vec<Enx<R>>,
    /// position and device ports that run a tick late, for links that count on the motion to come: MATs (any)
    pub ahead: Vec<u32>,
    /// parameters that ports drive (any)
    pub driven: Vec<Driven<R>>,
    /// how they cross it
    pub crossing: Crossing,
}

/// The outputs and their filters.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct OutputArrays<R: Real = f64> {
    /// links of fused passes whose forces are heard (any)
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub heard: Vec<HeardLink<R>>,
    /// what is heard (any): as it is first, then motion, then what goes through a high pass, and last motion that does
    pub outputs: Vec<Output>,
    /// how many of them hear motion: as it is, and through a high pass. A separate list, so that the others need not be asked
    pub of_motion: [usize; 2],
    /// channels with outputs as they are, where one has so many that they are summed in lanes
    /// ([`pass::MANY`](crate::op::pass::MANY)) (channels, or none)
    pub output_rows: Vec<OutputRow>,
    /// the high passes of the last of them (any)
    pub blockers: Vec<DcBlocker<R>>,
    /// low-pass of the sound channels: the first half of its coefficients, up to the middle one (any)
    pub lowpass: Vec<R>,
}
