//! Plays networks and bundled models, for `benches/counts/run` to count the instructions of their ticks.
//!
//! A count is the same on every run, also while other programs run, so that a change of 3 % is visible. Waits for
//! memory or for an earlier result are not counted; the benches measure these. The networks are included as a source
//! file of `ca bench`, because its crate would pull in the whole command.

mod passes;

use ca_compile::{Options, compile, cost};
use ca_core::internal::op::Op;
use ca_core::{Scene, State, tick};
use std::hint::black_box;
use std::io::Write as _;

#[path = "../../src/grains.rs"]
mod grains;
#[path = "../../../crates/ca-accuracy/src/bench/networks.rs"]
#[allow(dead_code, reason = "a bench asks for more of a network than its text")]
mod networks;

/// Masses of a network for vectors: more than the lanes of a processor, less than its first cache holds.
const MASSES: usize = 120;

/// Ticks counted: enough for hammers to strike and grains to meet.
const TICKS: usize = 2000;

/// One model for each way of playing a scene; the kernels of all others are in the networks.
const MODELS: &[&str] = &[
    "hammered_string",
    "hammer_piano",
    "membrane",
    "plate",
    "gong",
    "marimba",
    "bowed_string",
    "pinched_string",
    "wave_guitar",
    "slide_guitar",
    "rattle",
    "rain_stick",
    "jack",
    "wind",
];

/// Grains with contacts between all pairs, and the share of their shell that they fill.
const GRAINS: [(&str, f64); 2] = [("grains", 0.1), ("packed grains", 0.35)];

/// Largest error of a prediction \[%\]: for a network, which has one kind of links, and for a model and for grains,
/// whose contacts close only at times.
const WITHIN: [u32; 2] = [10, 35];

/// Callgrind counts this function, by its name.
#[inline(never)]
fn counted(scene: &Scene, state: &mut State) {
    for _ in 0..TICKS {
        tick(scene, state);
    }
}

/// Returns whether all links by the method `stable` have a predicted cost. Those that are solved iteratively have none, so
/// nothing is compared.
fn is_priced(scene: &Scene) -> bool {
    let stable = |op: &&Op| op.law.is_some_and(|law| law.code.contains(" stable"));
    scene.passes.summed().iter().filter(stable).all(|op| cost::of_pass(scene, op).is_some())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // for the table of costs: each pass alone, in networks of many sizes
    let by_pass = std::env::args().nth(1).is_some_and(|asked| asked == "passes");
    let sizes = if by_pass { &passes::SIZES[..] } else { &[MASSES] };
    let within = |name| if name == "GRAINS" { WITHIN[1] } else { WITHIN[0] };
    let networks = sizes
        .iter()
        .flat_map(|n| networks::NETWORKS.iter().map(|net| (net.name, Ok((net.text)(*n)), within(net.name))));
    let grains =
        sizes.iter().flat_map(|n| GRAINS.map(|(name, fill)| (name, Ok(grains::grains(*n, fill, 1e-3)), WITHIN[1])));
    let path = |name: &str| format!("{}/../../models/{name}.ca.toml", env!("CARGO_MANIFEST_DIR"));
    let models = MODELS.iter().map(|name| (*name, std::fs::read_to_string(path(name)), WITHIN[1]));
    let catalog = ca_model::catalog().with(ca_lpr::KINDS);
    for (name, text, within) in networks.chain(grains).chain(models) {
        let (model, findings) = ca_model::read::read(&text?, name, &catalog);
        if findings.has_errors() {
            return Err(findings.to_string().into());
        }
        let scene = compile(&model, &catalog, &Options::default()).map_err(|found| found.to_string())?.scene;
        if by_pass {
            passes::passes(name, &scene)?;
            continue;
        }
        let mut state = scene.state();
        counted(black_box(&scene), black_box(&mut state));
        if !state.is_bounded(10.0) {
            return Err(format!("`{name}` diverged").into());
        }
        // one line for each call, in the same order
        let within = if is_priced(&scene) { within } else { 0 };
        writeln!(std::io::stdout(), "{TICKS} {:.0} {within} {name}", cost::of_tick(&scene))?;
    }
    Ok(())
}
