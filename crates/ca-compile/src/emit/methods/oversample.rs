//! Oversampling: the ticks between two samples.
//!
//! One pass, before all others, runs the ticks since the last sample. A loop around the tick is not used, so that
//! callers of a scene see only samples, also in the two halves of a tick, and other scenes do not change. The tick at
//! the sample itself is the ordinary one of the scene, so that probes and devices get the values of that moment.

use crate::net::Pruned;
use alloc::vec::Vec;
use ca_core::InputRole;
use ca_core::internal::op::layout::{Layout, Substeps};
use ca_core::internal::op::{Op, Pass};

/// Inserts the ticks between samples before the passes of a sample, if the model asks for oversampling.
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
    // A device has its border instead.
    let slow = (0..).zip(&net.inputs).filter(|(_, i)| i.role != InputRole::Device);
    let inputs: Vec<u32> = slow.map(|(place, _)| place).collect();
    if !inputs.is_empty() {
        reads.insert(0, Op::pass(Pass::Inputs, inputs.len()));
    }
    // Between samples only the filter reads the outputs.
    let without_output = |op: &Op| if op.pass == Pass::LowPass { Op::pass(Pass::Remember, op.n) } else { *op };
    let writes_between = writes.iter().filter(|_| !layout.out.lowpass.is_empty()).map(without_output);
    let ops: Vec<Op> = reads.iter().chain(forces).copied().chain(writes_between).chain(moves.iter().copied()).collect();
    layout.rates.substeps = Some(Substeps { times: net.oversample, tick: ops.into(), inputs });
    reads.insert(0, Op::pass(Pass::Between, net.oversample as usize - 1));
    writes.push(Op::pass(Pass::ToSamples, 1));
    moves.insert(0, Op::pass(Pass::ToTicks, 1));
    moves.push(Op::pass(Pass::ToSamples, 1));
}
