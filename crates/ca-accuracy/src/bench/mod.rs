//! Bench: how many modules of each kind run in real time on one core, as in Table 1 of the first paper.
//!
//! As there, a module is a MAT or a LIA. Parameters differ from module to module: the table lists an engine for equal
//! parameters separately. The size of a network is adjusted until its tick takes almost as long as a sample; sizes
//! reported as in time were measured. A network that was too slow is measured again: other programs only lengthen
//! ticks.

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

/// Results of the first paper on a DSP chip, 2013: engine, and modules at 44.1 kHz.
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
/// Bytes per module that a tick of a string reads: x, d and one coefficient of a MAT, k and z of a LIA. Two fifths of
/// them, x and d, are written back.
pub const BYTES: usize = 8 * (3 + 2) / 2;
/// Smallest network measured, in masses.
const SMALLEST: usize = 32;
/// Sizes tried at each rate.
const TRIES: usize = 12;
/// Measurements of a network before it counts as too slow.
const AGAIN: usize = 3;
/// Ticks that bring a network into motion.
const WARM: u32 = 200;

/// Network of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Number of MATs and LIAs that are computed.
    pub modules: usize,
    /// Time per tick \[ns\].
    pub ns: f64,
}

/// Row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Fits {
    /// Name of the network.
    pub name: &'static str,
    /// Description of the network.
    pub about: &'static str,
    /// Largest size in time, at each of [`RATES`].
    pub at: [Size; 2],
}

/// Bundled instrument.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    /// Name of the instrument.
    pub name: &'static str,
    /// Size and time at each of [`RATES`]; `None` where it cannot play at that rate.
    pub at: [Option<Size>; 2],
}

impl Instrument {
    /// Number of copies that play at once in real time, at each of [`RATES`].
    pub fn at_once(&self) -> [Option<usize>; 2] {
        [0, 1].map(|k| self.at[k].map(|size| (1e9 / RATES[k] / size.ns) as usize))
    }
}

/// Time of a tick in motion \[ns\].
pub fn cost(scene: &Scene) -> f64 {
    let mut state = scene.state();
    for _ in 0..WARM {
        tick(scene, &mut state);
    }
    let (begin, mut state) = (state.clone(), state);
    Timing::default().fastest(&mut state, |s| s.clone_from(&begin), |s| tick(scene, s))
}

/// Measures a string of `modules` modules, and the time in which this machine reads and writes its bytes \[ns\].
///
/// # Errors
/// As [`measure`].
pub fn beside_streaming(modules: usize) -> Result<(Size, f64), Failure> {
    // a mass and a link are two modules
    let size = measure(&NETWORKS[0], modules / 2)?;
    Ok((size, crate::timing::streaming(BYTES * size.modules)))
}

/// Measures a network of `masses` masses.
///
/// # Errors
/// If it does not compile, which is a defect of the bench.
pub fn measure(network: &Network, masses: usize) -> Result<Size, Failure> {
    let loaded = ca_lab::Loaded::read(&(network.text)(masses), network.name);
    let scene = loaded.compile(&Options::default())?.scene;
    Ok(Size { modules: scene.symbols.len(), ns: cost(&scene) })
}

/// Masses of the reference of [`ns_per_instruction`], small enough for the first cache.
const REFERENCE: usize = 120;

/// Returns the time per instruction predicted by [`ca_compile::cost`] on this machine \[ns\]: the time of a tick of the
/// network `random` over its predicted instructions. Its links are looked up one by one, without vectors, so it is the
/// same on every processor. On processors with vectors wider than AVX2, passes that use them take less time.
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

/// Returns how much of a network is in time at each of [`RATES`]; `look` is called in between and can stop by an error.
///
/// # Errors
/// As [`measure`], and the errors of `look`.
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
        // in time with `low` masses, too slow with `high`
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
            // as if each further mass took the mean time
            let next = (0.99 * left * masses as f64) as usize;
            masses = if low < next && next < high { next } else { usize::midpoint(low, high).max(1) };
        }
    }
    // a size in time at one rate is in time at a lower one
    let at = RATES.map(|rate| {
        let in_time = known.values().rev().find(|s| s.ns <= 1e9 / rate);
        in_time.copied().unwrap_or(Size { modules: 0, ns: 0.0 })
    });
    Ok(Fits { name: network.name, about: network.about, at })
}

/// Measures a bundled instrument with its own gesture at each of [`RATES`], from a state in motion.
///
/// # Errors
/// If it cannot play at any of them, which is a defect.
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
        // fewer copies at the lower rate: the measurement was disturbed
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

    /// Networks move and stay bounded: values that decay or grow would change the time of a tick.
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

    /// A law across two worlds costs the law on a line plus an LPR, so it does not need a network.
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
