//! Filters at the ends of waveguides, as `ca check --schedule` prints them.

use crate::outcome::Failure;
use ca_core::internal::op::layout::{Delay, Termination};
use ca_core::internal::tuning::wave::Loss;
use ca_core::{Location, Scene};
use serde_json::{Value as Json, json};
use std::io::Write;

/// Delay that ends with a filter.
struct Filter {
    /// Name of the junction that the waves leave and reach.
    junction: String,
    /// Whole samples of the delay, without its filter.
    samples: usize,
    loss: Loss,
}

fn filters(scene: &Scene) -> Vec<Filter> {
    let name = |junction: usize| {
        let mat = scene.waves.junctions[junction].mat;
        scene.symbols.iter().find(|s| s.location == Location::Mat(mat)).map_or_else(String::new, |s| s.name.to_string())
    };
    let of = |d: &Delay| match d.end {
        // the taps and the allpass look back by three samples
        Termination::Lossy { loss, .. } => {
            Some(Filter { junction: name(d.junction), samples: d.len.saturating_sub(3), loss })
        }
        Termination::Open | Termination::Rigid => None,
    };
    scene.waves.delays.iter().filter_map(of).collect()
}

pub(super) fn text(scene: &Scene, out: &mut impl Write) -> Result<(), Failure> {
    let all = filters(scene);
    if !all.is_empty() {
        writeln!(out, "\nWaveguide filters: z^-(N+1) (a + b (z + 1/z)) (c + 1/z)/(1 + c/z)")?;
    }
    for Filter { junction, samples, loss: Loss { a, b, c } } in all {
        writeln!(out, "  from {junction} to the end and back: N {samples}, a {a:.12}, b {b:.12}, c {c:.12}")?;
    }
    Ok(())
}

pub(super) fn json(scene: &Scene) -> Json {
    let all = filters(scene).into_iter().map(|f| {
        let Loss { a, b, c } = f.loss;
        json!({"junction": f.junction, "samples": f.samples, "a": a, "b": b, "c": c})
    });
    all.collect()
}
