//! Counts pass by pass, for the table of `ca_compile::cost`.

use crate::TICKS;
use ca_compile::cost;
use ca_core::internal::op::Op;
use ca_core::{Scene, State};
use std::hint::black_box;
use std::io::Write as _;

/// Sizes of the networks; only several sizes separate the fixed part from the part per module.
pub const SIZES: [usize; 9] = [11, 14, 16, 20, 40, 64, 120, 250, 500];

/// Runs one pass; callgrind counts this function.
#[inline(never)]
fn counted_pass(op: &Op, scene: &Scene, state: &mut State) {
    (op.kernel)(op, &scene.layout, state);
}

/// Ends the count of a pass.
#[inline(never)]
fn counted_all(pass: usize) -> usize {
    black_box(pass)
}

/// Counts each pass of a scene separately, in complete ticks, and prints its name.
pub fn passes(name: &str, scene: &Scene) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    let all = || {
        [&scene.passes.reads[..], scene.passes.summed(), &scene.passes.writes, &scene.passes.moves]
            .into_iter()
            .flatten()
    };
    for (i, op) in all().enumerate() {
        let mut state = scene.state();
        for _ in 0..TICKS {
            for (k, op) in all().enumerate() {
                if k == i {
                    counted_pass(black_box(op), scene, &mut state);
                } else {
                    (op.kernel)(op, &scene.layout, &mut state);
                }
            }
            state.tick += 1;
        }
        counted_all(i);
        let predicted = cost::of_pass(scene, op).map_or(-1.0, f64::round);
        let form = match (op.law.is_some(), op.form) {
            (false, _) => String::new(),
            (_, f) if f.set => "set".into(),
            (_, f) => format!(
                "{:?}, stride {}, hub {:?}, {:?}{}, {:?}",
                f.measure,
                f.stride,
                f.hub,
                f.integrate,
                if f.folded { " folded" } else { "" },
                f.band
            ),
        };
        writeln!(out, "{TICKS} {predicted} 0 {name:<18} {:<15} n {:<5} {form}", op.name(), op.n)?;
    }
    Ok(())
}
