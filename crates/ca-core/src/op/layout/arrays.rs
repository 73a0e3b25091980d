//! The arrays of a layout, in groups.
//!
//! Each group is a plain structure, whose fields keep the order in which a plan stores them.

use super::{
    Crossing, DcBlocker, Driven, Enf, Enx, Modal, ModalCoupling, MovingPoint, Output, OutputLink, OutputRow, PairSet,
    SlowGroup, SolvedModal, Substeps,
};
use crate::numeric::Real;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// Rates of a layout, and what runs at another rate.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Rates<R: Real = f64> {
    /// duration of a sound sample \[s\], 1/rate
    pub sample_dt: f64,
    /// sound samples per gesture frame
    pub ratio: u32,
    /// ticks per gesture frame; equal to `ratio` unless a sample has several ticks
    pub frame: u32,
    /// groups at the gesture rate
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub slow: Option<Arc<SlowGroup<R>>>,
    /// ticks within a sample, if there are several
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub substeps: Option<Substeps<R>>,
}

/// Lengths of the arrays of a state.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// slots of MATs, moving points included: one for a MAT on a line, three in a row for one in space
    pub n_mat: usize,
    /// number of links, with the padding of rows
    pub n_lia: usize,
    /// number of coefficients
    pub n_coef: usize,
    /// number of memory values of laws and waves
    pub n_mem: usize,
    /// number of contacts that are solved together
    pub n_touch: usize,
    /// number of stored or temporary forces
    pub n_tap: usize,
    /// number of sound channels; probes follow them in [`State::output`](crate::state::State)
    pub channels: usize,
    /// number of values in [`State::output`](crate::state::State)
    pub n_out: usize,
}

/// Ends of links, and how they measure.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct LinkArrays<R: Real = f64> {
    /// ends of links, first slot of the first and of the second MAT (n_lia x 2)
    pub ends: Vec<[u32; 2]>,
    /// ends of the second ports of quadripoles (any x 2)
    pub onto: Vec<[u32; 2]>,
    /// data of a port in space beside its ends: for [`MeasureKind::Radial`](super::MeasureKind::Radial) the vector
    /// between the ends at rest \[m\] and the square of the softening length \[m²\]; for
    /// [`MeasureKind::Along`](super::MeasureKind::Along) the direction and an unused number (any x 4)
    pub reach: Vec<[R; 4]>,
    /// row lengths, one per entry of `reach`. A positive number is how many links of the batch, from this one on, form
    /// a row: they join consecutive points on both sides, the second ends after the first, as far apart at rest as
    /// `rest` says. A negative number counts links that form no row (as `reach`)
    pub rows: Vec<i32>,
    /// pair sets (any)
    pub pair_sets: Vec<PairSet>,
    /// constant part of the elongation \[m\] (n_lia)
    pub e0: Vec<R>,
    /// numbers of the clusters of links solved together, from 0, `u32::MAX` for other links (n_lia, none if there is
    /// one cluster)
    pub clusters: Vec<u32>,
}

/// Rest positions of MATs, and the MATs that follow others: moving points and modal masses.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Places<R: Real = f64> {
    /// rest positions \[m\] (n_mat)
    pub rest: Vec<R>,
    /// nodes under moving points (any)
    pub nodes: Vec<u32>,
    /// moving points (any)
    pub moving_points: Vec<MovingPoint>,
    /// modal masses (any)
    pub modal: Vec<Modal>,
    /// shares of modal masses in the modes (any)
    pub shares: Vec<R>,
    /// modal masses at which links are solved with the coming motion, group by group (any)
    pub solved_modal: Vec<SolvedModal>,
    /// groups with several such masses (any)
    pub modal_couplings: Vec<ModalCoupling>,
    /// motion of one such mass by a force on another, relative to the motion by a force on itself (any)
    pub couplings: Vec<R>,
}

/// Ports: inputs, and outputs to devices.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct PortArrays<R: Real = f64> {
    /// position ports (any)
    pub enx: Vec<Enx<R>>,
    /// force ports (any)
    pub enf: Vec<Enf>,
    /// device ports (any), across the border
    pub tgr: Vec<Enx<R>>,
    /// MATs of position and device ports that run a tick late, for links that are solved with the coming motion (any)
    pub ahead: Vec<u32>,
    /// parameters driven by ports (any)
    pub driven: Vec<Driven<R>>,
    /// how device ports cross the border
    pub crossing: Crossing,
}

/// The outputs and their filters.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct OutputArrays<R: Real = f64> {
    /// links of fused passes whose forces outputs read (any)
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub links: Vec<OutputLink<R>>,
    /// outputs (any), in this order: unfiltered, of motion, with a high-pass, of motion with a high-pass
    pub outputs: Vec<Output>,
    /// number of outputs of motion, without and with a high-pass. Their own lists save testing every output
    pub of_motion: [usize; 2],
    /// channels of unfiltered outputs, if one has enough outputs to be summed in lanes
    /// ([`pass::MANY`](crate::op::pass::MANY)) (channels, or none)
    pub output_rows: Vec<OutputRow>,
    /// high-pass filters of the last outputs (any)
    pub blockers: Vec<DcBlocker<R>>,
    /// low-pass of the sound channels: the first half of the coefficients, up to the middle one (any)
    pub lowpass: Vec<R>,
}
