//! Plays a model by its own gesture and checks the requirements common to all models.

use super::closed_forms::sin2;
use crate::acoustics::{cents, damping, db, mode, partial, peak, stiffness};
use ca_compile::Compiled;
use ca_compile::{Options, compile};
use ca_core::Scene;
use ca_io::gesture::{Gesture, Track};
use ca_io::perform::Performance;
use ca_model::read::read;
use ca_model::{Model, render};
use ca_tests::catalog;
use std::path::PathBuf;

pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../models")
}

pub fn file_names() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter_map(|n| n.strip_suffix(".ca.toml").map(String::from))
        .collect();
    names.sort();
    names
}

pub fn load(name: &str) -> Model {
    let text = std::fs::read_to_string(folder().join(format!("{name}.ca.toml"))).unwrap();
    let (model, found) = read(&text, &format!("{name}.ca.toml"), &catalog());
    assert!(found.list.is_empty(), "{}", render::text(&found, &model, false));
    model
}

/// Outputs of a performance.
pub struct Rendering {
    pub model: Model,
    pub rate: f64,
    /// Sound by channel.
    pub sound: Vec<Vec<f64>>,
    /// Probes in the requested order.
    pub probe: Vec<Vec<f64>>,
}

/// Plays a model by its own gesture and checks the requirements common to all models.
pub fn play(name: &str, probes: &[&str]) -> Rendering {
    let model = load(name);
    for word in ["Play:", "Try:", "Source:"] {
        assert!(model.header.contains(word), "{name}: the header has no `{word}`");
    }
    assert!(model.title().len() > 10 && !model.title().contains('\n'));
    let scene = scene(&model, probes);
    let reported = scene.findings.list.iter().any(|d| d.code.starts_with('W'));
    assert!(!reported, "{}", render::text(&scene.findings, &model, false));
    let rendering = perform(model, &scene, None, scene.about.seconds.expect("a model says how long it sounds"));
    let level = rendering.sound.iter().map(|c| db(peak(c))).fold(f64::MIN, f64::max);
    assert!((-12.0..=-0.5).contains(&level), "{name} peaks at {level:.2} dBFS");
    rendering
}

pub fn scene(model: &Model, probes: &[&str]) -> Compiled {
    let options = Options { probes: probes.iter().map(|p| (*p).into()).collect(), energy: true, ..Options::default() };
    compile(model, &catalog(), &options).unwrap_or_else(|d| panic!("{}", render::text(&d, model, false)))
}

pub fn perform(model: Model, scene: &Scene, gesture: Option<&Gesture>, seconds: f64) -> Rendering {
    let mut p = Performance::new(scene, gesture).unwrap();
    assert!(gesture.is_some() || p.duration() <= seconds, "the gesture is longer than the sound");
    let n = (seconds * scene.rate) as usize;
    let mut out = vec![Vec::with_capacity(n); scene.counts.n_out];
    for _ in 0..n {
        p.tick();
        out.iter_mut().zip(&p.state.output).for_each(|(o, v)| o.push(*v));
    }
    assert!(!p.diverged && out.iter().flatten().all(|v| v.is_finite()), "{}: diverged", scene.about.title);
    // the ledgers balance, and contacts and hard springs are soft enough for the scheme to make almost no energy
    let ledger = p.state.ledger.as_ref().unwrap().balance();
    let (open, made) = (ledger.residual.abs() / ledger.peak, ledger.scheme_error.abs() / ledger.peak);
    assert!(
        ledger.peak == 0.0 || (open < 1e-9 && made < 0.02),
        "{}: open {open:e}, made {made:e} {}",
        scene.about.title,
        ledger.scheme_error
    );
    let probe = out.split_off(scene.counts.channels);
    Rendering { model, rate: scene.rate, sound: out, probe }
}

impl Rendering {
    pub fn cut<'a>(&self, x: &'a [f64], t0: f64, t1: f64) -> &'a [f64] {
        &x[(t0 * self.rate) as usize..((t1 * self.rate) as usize).min(x.len())]
    }
    /// Sound of channel `c` from `t0` to `t1` [s].
    pub fn at(&self, c: usize, t0: f64, t1: f64) -> &[f64] {
        self.cut(&self.sound[c], t0, t1)
    }
    /// Probe number `i` from `t0` to `t1` [s].
    pub fn probed(&self, i: usize, t0: f64, t1: f64) -> &[f64] {
        self.cut(&self.probe[i], t0, t1)
    }
    /// Points [s, SI] of the model's own gesture for a port.
    pub fn gesture(&self, port: &str) -> Vec<(f64, f64)> {
        let scene = scene(&self.model, &[]);
        let found = scene.about.gestures.iter().find(|g| g.0 == port).unwrap_or_else(|| panic!("no gesture of {port}"));
        found.1.iter().map(|p| (p[0], p[1])).collect()
    }
    /// Values of a parameter as written, in SI.
    pub fn numbers(&self, owner: &str, key: &str) -> Vec<f64> {
        ca_benches::instruments::numbers(&self.model, owner, key)
    }
    pub fn number(&self, owner: &str, key: &str) -> f64 {
        self.numbers(owner, key)[0]
    }

    /// Partial `j` of the STRING or hinged STIFFSTRING `name`: frequency [Hz] and T60 [s], link viscosity included.
    pub fn string(&self, name: &str, j: usize) -> (f64, f64) {
        let n1 = self.number(name, "n") as usize + 1;
        let zo = damping(self.number(name, "t60"), self.rate);
        let f = self.number(name, "f");
        let item = self.model.items.iter().find(|i| i.name == name).unwrap();
        // a plain string is sin², a stiff one k sin² + 4B sin⁴ through its first two partials
        let one = stiffness(f, zo, self.rate) / sin2(1, n1);
        let bend = item.args.iter().find(|e| e.key == "b").map_or(0.0, |_| {
            let b = self.number(name, "b");
            let second = 2.0 * f * ((1.0 + 4.0 * b) / (1.0 + b)).sqrt();
            (stiffness(second, zo, self.rate) / sin2(2, n1) - one) / (sin2(2, n1) - sin2(1, n1))
        });
        let a = (one + bend * (sin2(j, n1) - sin2(1, n1))) * sin2(j, n1);
        // dampers act along the links, without bending
        let z = self.number(name, "z") / (self.number(name, "m") * self.rate) * 4.0 * sin2(j, n1);
        mode(a, zo + z, self.rate)
    }

    /// Asserts that partials of the sound are within `within` cents of their frequencies.
    pub fn assert_partials(
        &self,
        c: usize,
        t: [f64; 2],
        partials: impl IntoIterator<Item = f64>,
        reach: f64,
        within: f64,
    ) {
        for f in partials {
            let found = partial(self.at(c, t[0], t[1]), self.rate, f, reach).0;
            let off = cents(found, f);
            assert!(off.abs() < within, "{}: {found:.3} Hz is {off:+.2} cents from {f:.3} Hz", self.model.title());
        }
    }
}

/// A gesture of these ports alone [s, SI]. Other ports of the model's own gesture stay at its first value.
pub fn ports_gesture(scene: &Scene, ports: &[(&str, &[(f64, f64)])]) -> Gesture {
    let moved = |name: &str| ports.iter().find(|p| p.0 == name).map(|p| p.1.to_vec());
    let still =
        scene.about.gestures.iter().filter(|g| moved(&g.0).is_none()).map(|g| (g.0.as_str(), vec![(0.0, g.1[0][1])]));
    let tracks = ports.iter().map(|p| (p.0, p.1.to_vec())).chain(still);
    Gesture::new(tracks.map(|(name, points)| Track::points(name, points).unwrap()).collect()).unwrap()
}

/// Plays the model for `seconds` with these ports alone.
pub fn by_hand(model: &Model, probes: &[&str], ports: &[(&str, &[(f64, f64)])], seconds: f64) -> Rendering {
    let scene = scene(model, probes);
    let gesture = ports_gesture(&scene, ports);
    perform(model.clone(), &scene, Some(&gesture), seconds)
}

/// Number of blows in a force: how often it begins after 2 ms of zero.
pub fn count_contacts(force: &[f64], rate: f64) -> usize {
    let pause = (0.002 * rate) as usize;
    let mut last = None;
    let mut count = 0;
    for (n, _) in force.iter().enumerate().filter(|(_, f)| **f != 0.0) {
        count += usize::from(last.is_none_or(|l| n - l > pause));
        last = Some(n);
    }
    count
}
