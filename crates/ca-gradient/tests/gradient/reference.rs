//! Derivative of a render by central differences of the eighth order, between renders in double precision.
//!
//! The step is the one at which the eighth and the sixth order agree best, among those at which each link has a force,
//! or none, in the same ticks: if a contact closes a tick later, the two renders differ by a jump. Both orders have the
//! same rounding, so the choice of the step adds an estimate of it to their distance.

use ca_gradient::{Forward, Parameter, Tangents};
use cordis_anima::ca_core::Location;
use cordis_anima::ca_io::perform::Performance;
use cordis_anima::ca_model::{Entry, Value};
use cordis_anima::{Loaded, Options, Scene};

/// Weights at 1 … 4 steps, less those at −1 … −4: eighth order, sixth order.
pub const WEIGHTS: [[f64; 4]; 2] =
    [[4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0], [3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0, 0.0]];

/// Rounding of a render, relative to its largest sample.
const ROUNDING: f64 = 2e-15;

pub fn read(text: &str) -> Loaded {
    Loaded::read(text, "test.ca.toml")
}

/// Tangents of `ticks` samples, by dual numbers.
pub fn tangents(loaded: &Loaded, ticks: usize, wrt: &[&str]) -> Tangents {
    let text = cordis_anima::ca_model::write::write(&loaded.model);
    let forward = Forward::by_dual_numbers(loaded, &Options::default(), wrt).unwrap_or_else(|e| panic!("{text}\n{e}"));
    forward.tangents(Some(ticks as f64 / forward.rate()), None, &mut || true).unwrap_or_else(|e| panic!("{text}\n{e}"))
}

/// Returns the model with a parameter, or one number of a list, at `value`.
pub fn with(loaded: &Loaded, p: &Parameter, value: f64) -> Loaded {
    let mut other = loaded.clone();
    let written = if p.unit.is_empty() { Value::Num(value) } else { format!("{value:e} {}", p.unit).into() };
    let (whole, index) = match p.name.strip_suffix(']').and_then(|n| n.rsplit_once('[')) {
        Some((whole, i)) => (whole, Some(i.parse::<usize>().expect("a place in a list"))),
        None => (&p.name[..], None),
    };
    let written = match index {
        None => written,
        Some(i) => {
            let (owner, key) = whole.rsplit_once('.').expect("a module and its parameter");
            let item = loaded.model.items.iter().find(|item| item.name == owner).expect("such a module");
            let Some(Value::List(list)) = item.args.iter().find(|e| e.key == key).map(|e| &e.value) else {
                panic!("{}", p.name)
            };
            let mut list = list.clone();
            list[i] = Entry::new("", written);
            Value::List(list)
        }
    };
    assert!(other.model.put(whole, written), "{whole}");
    other
}

/// Output of a render (ticks x channels), and whether each link has a force in each tick (ticks x links).
pub struct Played {
    pub output: Vec<f64>,
    pub acts: Vec<bool>,
}

fn compiled(loaded: &Loaded, probes: Vec<String>) -> Scene {
    loaded.compile(&Options { probes, ..Options::default() }).unwrap_or_else(|e| panic!("{:?}", e.diags)).scene
}

/// Names of modules whose force can be probed.
pub fn links(loaded: &Loaded) -> Vec<String> {
    let scene = compiled(loaded, Vec::new());
    let is_link = |name: &str| {
        let mut all = scene.symbols.iter();
        all.any(|s| matches!(s.location, Location::Lia(..)) && s.name == *name)
            && loaded.compile(&Options { probes: vec![name.into()], ..Options::default() }).is_ok()
    };
    loaded.model.items.iter().map(|i| i.name.clone()).filter(|n| is_link(n)).collect()
}

/// Plays a model by its own gesture and probes the forces of these links.
pub fn played(loaded: &Loaded, links: &[String], ticks: usize) -> Played {
    let scene = compiled(loaded, links.to_vec());
    let mut p = Performance::new(&scene, None).expect("its own gesture");
    let (mut output, mut acts) = (Vec::new(), Vec::new());
    for _ in 0..ticks {
        p.tick();
        let (sound, forces) = p.state.output.split_at(scene.counts.channels);
        output.extend_from_slice(sound);
        acts.extend(forces.iter().map(|f| *f != 0.0));
    }
    Played { output, acts }
}

/// Returns the derivative of the output by `p` and the relative distance of both orders; `None` without a usable step.
pub fn difference(loaded: &Loaded, p: &Parameter, ticks: usize) -> Option<(Vec<f64>, f64)> {
    let links = links(loaded);
    let base = played(loaded, &links, ticks);
    let largest = |all: &[f64]| all.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let mut best: Option<(Vec<f64>, f64, f64)> = None;
    for part in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let h = part * if p.value == 0.0 { 1e-3 } else { p.value.abs() };
        let at = |k: f64| played(&with(loaded, p, p.value + k * h), &links, ticks);
        let mut sums = [vec![0.0; base.output.len()], vec![0.0; base.output.len()]];
        let mut same = true;
        for (k, weights) in WEIGHTS[0].into_iter().zip(WEIGHTS[1]).enumerate() {
            let [up, down] = [at(k as f64 + 1.0), at(-(k as f64) - 1.0)];
            same &= up.acts == base.acts && down.acts == base.acts;
            for (sum, w) in sums.iter_mut().zip([weights.0, weights.1]) {
                for ((sum, up), down) in sum.iter_mut().zip(&up.output).zip(&down.output) {
                    *sum += w * (up - down) / h;
                }
            }
        }
        let [high, low] = sums;
        let off = apart(&low, &high);
        let with_rounding = off + ROUNDING * largest(&base.output) / (h * largest(&high));
        if same && best.as_ref().is_none_or(|b| with_rounding < b.2) {
            best = Some((high, off, with_rounding));
        }
    }
    best.map(|(derivative, off, _)| (derivative, off))
}

/// Column of one parameter.
pub fn column(t: &Tangents, k: usize) -> Vec<f64> {
    t.tangents.iter().skip(k).step_by(t.parameters.len()).copied().collect()
}

/// Largest difference of two signals, relative to the largest value of the second.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let most = b.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let off = a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    let numbers = a.iter().chain(b).all(|v| v.is_finite());
    if !numbers {
        f64::INFINITY
    } else if off == 0.0 {
        0.0
    } else {
        off / most
    }
}
