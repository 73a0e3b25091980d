//! Oversampling: what runs between two samples, where a sample has several ticks.
//!
//! Decides for one pass before all others that runs the ticks between the last sample and this one, rather than a loop
//! around the tick: whoever plays a scene sees samples, the two halves of a tick included, and a scene that does not
//! ask has nothing of it. The tick at the sample itself is what the scene runs anyway, so that probes and hands get what is
//! there at that moment.

use crate::net::Pruned;
use alloc::vec::Vec;
use ca_core::InputRole;
use ca_core::internal::op::layout::{Layout, Substeps};
use ca_core::internal::op::{Op, Pass};

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
        reads.insert(0, Op::pass(Pass::Inputs, inputs.len()));
    }
    // between samples nobody listens but the filter
    let unheard = |op: &Op| if op.pass == Pass::LowPass { Op::pass(Pass::Remember, op.n) } else { *op };
    let heard = writes.iter().filter(|_| !layout.out.lowpass.is_empty()).map(unheard);
    let ops: Vec<Op> = reads.iter().chain(forces).copied().chain(heard).chain(moves.iter().copied()).collect();
    layout.rates.substeps = Some(Substeps { times: net.oversample, tick: ops.into(), inputs });
    reads.insert(0, Op::pass(Pass::Between, net.oversample as usize - 1));
    writes.push(Op::pass(Pass::ToSamples, 1));
    moves.insert(0, Op::pass(Pass::ToTicks, 1));
    moves.push(Op::pass(Pass::ToSamples, 1));
}
