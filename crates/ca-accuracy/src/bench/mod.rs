//! Bench: how many modules of each kind fit into real time on one core of this machine, as in the first paper's Table 1.
//!
//! Decides that a module is a MAT or a LIA, as there, and that parameters differ from module to module: an engine that is
//! fast only where all are alike is another row of that table. A network is made larger or smaller until its tick takes
//! nearly as long as a sample lasts; what is said to be in time was measured to be. What was too late is measured again, since other programs
//! make a tick longer and never shorter.

mod networks;
pub mod page;

use crate::timing::Timing;
use ca_compile::Options;
use ca_core::{Scene, tick};
use ca_io::perform::Performance;
use ca_io::play::{BLOCK, play};
use ca_lab::Failure;
pub use networks::{NETWORKS, Network};
use std::collections::BTreeMap;

/// What the first paper measured on a DSP chip, 2013: engine, and modules at 44.1 kHz.
pub const PAPER: [(&str, u32); 3] = [
    ("GENESIS engine, modular", 20),
    ("new engine of that paper, any topology and parameters", 140),
    ("ERGON_X engine, written by hand for one topology and the same parameters", 200),
];
/// Sound rates of the table \[Hz\].
pub const RATES: [f64; 2] = [44_100.0, 48_000.0];
/// Sizes of the curve of cost against size, in modules.
pub const SIZES: [usize; 13] =
    [100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000];
/// Bytes of a string that a tick reads, for each module: x, d and the number a MAT moves by, k and z of a LIA. x and d, two
/// fifths of them, are written back.
pub const BYTES: usize = 8 * (3 + 2) / 2;
/// The smallest network that is measured, in masses.
const SMALLEST: usize = 32;
/// Sizes that are tried at each rate.
const TRIES: usize = 12;
/// How often one is measured before it is too late.
const AGAIN: usize = 3;
/// Playing so long brings a network into motion \[ticks\].
const WARM: u32 = 200;

/// A network at one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// MATs and LIAs that are computed
    pub modules: usize,
    /// time of a tick \[ns\]
    pub ns: f64,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Fits {
    /// name of the network
    pub name: &'static str,
    /// what it is made of
    pub about: &'static str,
    /// the largest that was in time, at each of [`RATES`]
    pub at: [Size; 2],
}

/// An instrument of those that are built in.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    /// its name
    pub name: &'static str,
    /// its size and time at each of [`RATES`]; none where it cannot be played at that rate
    pub at: [Option<Size>; 2],
}

impl Instrument {
    /// How many of it play at once in real time, at each of [`RATES`].
    pub fn at_once(&self) -> [Option<usize>; 2] {
        [0, 1].map(|k| self.at[k].map(|size| (1e9 / RATES[k] / size.ns) as usize))
    }
}

/// The time of a tick in motion.
pub fn cost(scene: &Scene) -> f64 {
    let mut state = scene.state();
    for _ in 0..WARM {
        tick(scene, &mut state);
    }
    let (begin, mut state) = (state.clone(), state);
    Timing::default().fastest(&mut state, |s| s.clone_from(&begin), |s| tick(scene, s))
}

/// A string of so many modules, and the time in which this machine reads and writes the bytes it stands in \[ns\].
///
/// # Errors
/// As [`measure`].
pub fn beside_streaming(modules: usize) -> Result<(Size, f64), Failure> {
    // a mass and a link are two modules
    let size = measure(&NETWORKS[0], modules / 2)?;
    Ok((size, crate::timing::streaming(BYTES * size.modules)))
}

/// A network with so many masses.
///
/// # Errors
/// Where it does not compile: a defect of the bench.
pub fn measure(network: &Network, masses: usize) -> Result<Size, Failure> {
    let loaded = ca_lab::Loaded::read(&(network.text)(masses), network.name);
    let scene = loaded.compile(&Options::default())?.scene;
    Ok(Size { modules: scene.symbols.len(), ns: cost(&scene) })
}

/// Masses of the reference of [`ns_per_instruction`]: all of it stays in the first cache.
const REFERENCE: usize = 120;

/// The time of an instruction that [`ca_compile::cost`] predicts, on this machine \[ns\]: that of a tick of the network
/// `random`, whose links are looked up one by one, over its prediction. Its kernel has no vectors, so it is the same on every
/// processor; where vectors are wider than those of AVX2, passes that use them take less than is predicted.
///
/// # Errors
/// As [`measure`].
pub fn ns_per_instruction() -> Result<f64, Failure> {
    let found = NETWORKS.iter().find(|n| n.name == "random");
    let network = found.unwrap_or(&NETWORKS[0]);
    let loaded = ca_lab::Loaded::read(&(network.text)(REFERENCE), network.name);
    let scene = loaded.compile(&Options::default())?.scene;
    Ok(cost(&scene) / ca_compile::cost::of_tick(&scene))
}

/// How much of a network is in time at each of [`RATES`]; `look` is asked in between whether to go on.
///
/// # Errors
/// As [`measure`], and what `look` returns.
pub fn fits(network: &Network, mut look: impl FnMut() -> Result<(), Failure>) -> Result<Fits, Failure> {
    let mut known: BTreeMap<usize, Size> = BTreeMap::new();
    let mut at = |masses: usize, budget: f64| -> Result<Size, Failure> {
        look()?;
        let mut size = known.get(&masses).map_or_else(|| measure(network, masses), |s| Ok(*s))?;
        for _ in 1..AGAIN {
            if size.ns <= budget {
                break;
            }
            look()?;
            let again = measure(network, masses)?;
            size.ns = size.ns.min(again.ns);
        }
        known.insert(masses, size);
        Ok(size)
    };
    for rate in RATES {
        let budget = 1e9 / rate;
        // in time with `low` masses, too late with `high`
        let (mut low, mut high, mut masses) = (0, network.most + 1, SMALLEST);
        for _ in 0..TRIES {
            let size = at(masses, budget)?;
            if size.ns <= budget {
                low = masses;
            } else {
                high = masses;
            }
            let left = budget / size.ns;
            if high - low < 2 || (1.0..1.02).contains(&left) {
                break;
            }
            // as if every mass took as long as the mean of these
            let next = (0.99 * left * masses as f64) as usize;
            masses = if low < next && next < high { next } else { usize::midpoint(low, high).max(1) };
        }
    }
    // what was in time for one rate is so for a lower one
    let at = RATES.map(|rate| {
        let in_time = known.values().rev().find(|s| s.ns <= 1e9 / rate);
        in_time.copied().unwrap_or(Size { modules: 0, ns: 0.0 })
    });
    Ok(Fits { name: network.name, about: network.about, at })
}

/// A bundled instrument, played by its own gesture for a moment at each of [`RATES`].
///
/// # Errors
/// Where it cannot be played at any of them: a defect.
pub fn instrument(name: &'static str, text: &str) -> Result<Instrument, Failure> {
    let loaded = ca_lab::Loaded::read(text, name);
    let at = |rate: f64| {
        let options = Options { rate: Some(rate), ..Options::default() };
        let scene = loaded.compile(&options)?.scene;
        let warm = (0.2 * scene.rate) as u64;
        let played = play(Performance::new(&scene, None)?, warm, BLOCK, &mut |_, _, _| Ok::<(), Failure>(()))?;
        let begin = played.performance.player.state;
        let mut state = begin.clone();
        let ns = Timing::default().fastest(&mut state, |s| s.clone_from(&begin), |s| tick(&scene, s));
        Ok(Size { modules: scene.symbols.len(), ns })
    };
    let mut found = match RATES.map(at) {
        [Err(error), Err(_)] => return Err(error),
        [a, b] => Instrument { name, at: [a.ok(), b.ok()] },
    };
    for _ in 1..AGAIN {
        // fewer where there is more time: something else ran meanwhile
        let ([Some(low), Some(high)], [Some(slow), Some(_)]) = (found.at_once(), found.at) else { break };
        if low >= high {
            break;
        }
        let again = at(RATES[0])?;
        found.at[0] = Some(Size { ns: slow.ns.min(again.ns), ..slow });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ca_compile::Options;
    use ca_core::tick;

    /// What is measured moves and stays where it is: numbers that fade out or grow take another time.
    #[test]
    fn every_network_compiles_moves_and_stays_bounded() {
        for network in NETWORKS {
            for masses in [32, 200] {
                let text = (network.text)(masses);
                let loaded = ca_lab::Loaded::read(&text, network.name);
                let scene = loaded.compile(&Options::default()).unwrap_or_else(|_| panic!("{}", network.name)).scene;
                let modules = scene.symbols.len();
                assert!(4 * modules > 3 * masses, "{}: {modules} modules of {masses} masses", network.name);
                let mut state = scene.state();
                for _ in 0..5000 {
                    tick(&scene, &mut state);
                }
                assert!(state.is_bounded(10.0), "{} of {masses} masses", network.name);
                assert!(state.d.iter().any(|d| d.abs() > 1e-12), "{} of {masses} masses rests", network.name);
                assert!(state.output[0].is_finite());
            }
        }
    }

    #[test]
    fn a_string_is_measured_beside_what_it_stands_in() {
        let (size, bytes) = beside_streaming(1000).unwrap_or_else(|_| panic!("a string"));
        assert!((990..=1010).contains(&size.modules) && size.ns > 0.0 && bytes > 0.0);
    }

    /// A law across two worlds costs what it costs on a line and what an LPR adds: it has no network of its own.
    #[test]
    fn every_kind_of_link_is_measured() {
        let texts: String = NETWORKS.iter().map(|n| (n.text)(32)).collect();
        let catalog = ca_lab::catalog();
        let links = catalog.iter().filter(|k| k.params.iter().any(|p| p.name == "between"));
        let of_one_world: Vec<_> = links.map(|k| k.code).filter(|code| !code.starts_with("LPR_")).collect();
        assert!(of_one_world.len() >= 12, "{of_one_world:?}");
        for code in of_one_world.iter().chain(&["MAS", "CEL", "WAVEGUIDE"]) {
            assert!(texts.contains(&format!("[{code}]")), "no network has {code}");
        }
    }

    #[test]
    fn an_instrument_is_measured_at_both_rates() {
        let found = instrument("piano_key", ca_lab::load::bundled("piano_key").unwrap());
        let Ok(found) = found else { panic!("it is played") };
        let [Some(a), Some(b)] = found.at else { panic!("{found:?}") };
        assert!(a.modules == b.modules && a.ns > 0.0 && b.ns > 0.0);
        let twice = Instrument { name: "slow", at: [Some(Size { modules: 1, ns: 1e4 }), None] };
        assert_eq!(twice.at_once(), [Some(2), None], "of 22.7 us");
    }

    #[test]
    fn sizes_are_what_is_asked_for() {
        for network in NETWORKS {
            let count = |n: usize| {
                let loaded = ca_lab::Loaded::read(&(network.text)(n), network.name);
                loaded.compile(&Options::default()).unwrap_or_else(|_| panic!("{}", network.name)).scene.symbols.len()
            };
            let ratio = count(900) as f64 / count(90) as f64;
            assert!((8.0..=12.5).contains(&ratio), "{}: {ratio}", network.name);
        }
    }
}
