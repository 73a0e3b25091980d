//! Plays networks and bundled models, for `benches/counts/run` to count the instructions of their ticks.
//!
//! Decides to count instead of to time: a count is the same on every run, so that one in thirty is seen, also where other
//! programs run. What waits for memory or for a number before it is not seen; that is what the benches are for. The
//! networks are those of `ca bench`, taken as a file: their crate has all of the command below it.

mod passes;

use ca_compile::{Options, compile, cost};
use ca_core::{Scene, State, tick};
use std::hint::black_box;
use std::io::Write as _;

#[path = "../../src/grains.rs"]
mod grains;
#[path = "../../../crates/ca-accuracy/src/bench/networks.rs"]
#[allow(dead_code, reason = "a bench asks for more of a network than its text")]
mod networks;

/// Masses of a network, for those that run in vectors: more than a processor has lanes, less than its first cache.
const MASSES: usize = 120;

/// Ticks that are counted: enough that hammers have struck and grains have met.
const TICKS: usize = 2000;

/// One of each way a scene is played by; what is left out has its kernels in the networks.
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

/// Grains that may all touch, and the part of their shell that they fill.
const GRAINS: [(&str, f64); 2] = [("grains", 0.1), ("packed grains", 0.35)];

/// By how many percent a prediction may be off: of a network, which is of one kind of links, and of a model and of
/// grains, whose contacts press now and then.
const WITHIN: [u32; 2] = [10, 35];

/// What is counted, by its name.
#[inline(never)]
fn counted(scene: &Scene, state: &mut State) {
    for _ in 0..TICKS {
        tick(scene, state);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // to make the table anew: each pass by itself, of networks of many sizes
    let by_pass = std::env::args().nth(1).is_some_and(|asked| asked == "passes");
    let sizes = if by_pass { &passes::SIZES[..] } else { &[MASSES] };
    let within = |name| match name {
        "GRAINS" => WITHIN[1],
        // its contacts are solved again and again until they agree, which has no price: compared with nothing
        "stable" => 0,
        _ => WITHIN[0],
    };
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
        writeln!(std::io::stdout(), "{TICKS} {:.0} {within} {name}", cost::of_tick(&scene))?;
    }
    Ok(())
}
