//! Oversampling: what runs between two samples, where a sample has several ticks.
//!
//! Decides for one pass before all others that runs the ticks between the last sample and this one, rather than a loop
//! around the tick: whoever plays a scene sees samples, the two halves of a tick included, and a scene that does not
//! ask has nothing of it. The tick at the sample itself is what the scene runs anyway, so that probes and hands get what is
//! there at that moment.

use crate::net::Pruned;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::op::layout::{Layout, Substeps};
use ca_core::op::{Op, lowpass, substep};
use ca_core::scene::InputRole;
use ca_core::state::State;

/// Puts the ticks between samples in front of the passes of a sample, if the model asks for some.
pub fn oversample(
    net: &Pruned,
    layout: &mut Layout,
    reads: &mut Vec<Op>,
    forces: &[Op],
    writes: &mut Vec<Op>,
    moves: &mut Vec<Op>,
) {
    if net.oversample == 1 {
        return;
    }
    // a device has its border instead
    let slow = (0..).zip(&net.inputs).filter(|(_, i)| i.role != InputRole::Device);
    let inputs: Vec<u32> = slow.map(|(place, _)| place).collect();
    if !inputs.is_empty() {
        reads.insert(0, Op::pass("inputs", substep::inputs, inputs.len()));
    }
    // between samples nobody listens but the filter
    let unheard = |op: &Op| if op.name == "low pass" { Op { kernel: lowpass::remember, ..*op } } else { *op };
    let heard = writes.iter().filter(|_| !layout.lowpass.is_empty()).map(unheard);
    let ops: Vec<Op> = reads.iter().chain(forces).copied().chain(heard).chain(moves.iter().copied()).collect();
    let tick = Arc::new(move |layout: &Layout, s: &mut State| ops.iter().for_each(|op| (op.kernel)(op, layout, s)));
    layout.substeps = Some(Substeps { times: net.oversample, tick, inputs });
    let count = |name, kernel| Op::pass(name, kernel, 1);
    reads.insert(0, Op::pass("ticks between", substep::between, net.oversample as usize - 1));
    writes.push(count("to samples", substep::to_samples));
    moves.insert(0, count("to ticks", substep::to_ticks));
    moves.push(count("to samples", substep::to_samples));
}
