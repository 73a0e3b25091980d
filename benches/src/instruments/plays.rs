//! Plays an instrument for a claim, and measures it.
//!
//! Each take is played once, with all probes of the instrument, for any number of measures. Measures use the loudest
//! channel, because a sum of channels may cancel.

use super::Instrument;
use crate::acoustics;
use ca_compile::Options;
use ca_io::gesture::{Gesture, Track};
use ca_io::perform::{self, Performance};
use ca_io::play::{BLOCK, play};
use ca_model::{Model, Value, quantity};
use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

/// A way to play an instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Take {
    /// Changes, as for `--set`.
    set: &'static [&'static str],
    /// Motions of ports instead of the built-in gesture: time \[s\] and value in SI units.
    moved: &'static [(&'static str, &'static [[f64; 2]])],
    /// Factor on the duration of the built-in gesture.
    slower: f64,
    /// Factor on the motion of each track of the built-in gesture, from its first value.
    way: f64,
    /// Length \[s\]; 0 for the length of the model.
    seconds: f64,
}

/// Built-in gesture.
pub const BUILT: Take = Take { set: &[], moved: &[], slower: 1.0, way: 1.0, seconds: 0.0 };

impl Take {
    /// Applies changes, each as `name=value`.
    #[must_use]
    pub const fn set(self, set: &'static [&'static str]) -> Take {
        Take { set, ..self }
    }
    /// Moves ports differently: name, and points of time \[s\] and value in SI units.
    #[must_use]
    pub const fn moved(self, moved: &'static [(&'static str, &'static [[f64; 2]])]) -> Take {
        Take { moved, ..self }
    }
    /// Multiplies the duration of the built-in gesture.
    #[must_use]
    pub const fn slower(self, slower: f64) -> Take {
        Take { slower, ..self }
    }
    /// Multiplies the motion of the built-in gesture.
    #[must_use]
    pub const fn way(self, way: f64) -> Take {
        Take { way, ..self }
    }
    /// Sets the length \[s\].
    #[must_use]
    pub const fn seconds(self, seconds: f64) -> Take {
        Take { seconds, ..self }
    }
    /// Returns the part from `from` to `to` \[s\].
    pub const fn at(self, from: f64, to: f64) -> Cut {
        Cut { take: self, from, to }
    }
    /// Returns the whole take.
    pub const fn whole(self) -> Cut {
        self.at(0.0, f64::INFINITY)
    }
}

/// A part of a take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Take.
    pub take: Take,
    /// Start \[s\].
    pub from: f64,
    /// End \[s\].
    pub to: f64,
}

/// Outputs of a take.
pub struct Render {
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Sound by channel.
    pub sound: Vec<Vec<f64>>,
    /// Probes: name and samples.
    pub probe: Vec<(String, Vec<f64>)>,
    /// Number of MAT and of LIA.
    pub modules: [usize; 2],
    /// Computing time \[s\].
    pub wall: f64,
}

impl Render {
    /// Returns the samples of `x` from `from` to `to` \[s\].
    pub fn part<'a>(&self, x: &'a [f64], from: f64, to: f64) -> &'a [f64] {
        let at = |t: f64| ((t * self.rate) as usize).min(x.len());
        &x[at(from)..at(to)]
    }
    /// Returns the loudest channel between two times \[s\].
    pub fn loudest_channel(&self, from: f64, to: f64) -> &[f64] {
        let parts = self.sound.iter().map(|c| self.part(c, from, to));
        parts.max_by(|a, b| acoustics::rms(a).total_cmp(&acoustics::rms(b))).expect("a channel")
    }
}

/// An instrument being measured.
pub struct Plays {
    /// Entry of the instrument.
    pub instrument: &'static Instrument,
    /// Model as written.
    pub model: Model,
    played: RefCell<Vec<(Take, Rc<Render>)>>,
}

impl Plays {
    /// Loads an instrument.
    pub fn new(instrument: &'static Instrument) -> Plays {
        Plays { instrument, model: instrument.load().model, played: RefCell::default() }
    }

    /// Plays a take, or returns it if it was played before; panics if it diverges.
    pub fn play(&self, take: Take) -> Rc<Render> {
        if let Some((_, r)) = self.played.borrow().iter().find(|p| p.0 == take) {
            return Rc::clone(r);
        }
        let r = Rc::new(self.render(take, self.instrument.probes));
        self.played.borrow_mut().push((take, Rc::clone(&r)));
        r
    }

    /// Plays a take, even if it was played before.
    pub fn render(&self, take: Take, probes: &[&str]) -> Render {
        let name = self.instrument.model;
        let mut loaded = self.instrument.load();
        for change in take.set {
            let (what, value) = change.split_once('=').expect("name=value");
            assert!(loaded.model.put(what, Value::typed(value)), "{name} has no `{what}`");
        }
        let options = Options { probes: probes.iter().map(|p| (*p).into()).collect(), ..Options::default() };
        let scene = loaded.compile(&options).unwrap_or_else(|e| panic!("{name}: {e:?}")).scene;
        let built = scene.about.gestures.iter().map(|(port, points)| {
            let begin = points.first().map_or(0.0, |p| p[1]);
            let at = |p: &[f64; 2]| (take.slower * p[0], begin + take.way * (p[1] - begin));
            Track::points(port.clone(), points.iter().map(at).collect())
        });
        let moved = take
            .moved
            .iter()
            .map(|(port, points)| Track::points((*port).to_owned(), points.iter().map(|p| (p[0], p[1])).collect()));
        let mut tracks: Vec<Track> = built.map(|t| t.expect("a built-in gesture")).collect();
        tracks.retain(|t| !take.moved.iter().any(|m| m.0 == t.name()));
        tracks.extend(moved.map(|t| t.expect("points of a take rise in time")));
        let gesture = (!tracks.is_empty()).then(|| Gesture::new(tracks).expect("tracks have different names"));
        let p = Performance::new(&scene, gesture.as_ref()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let seconds = perform::seconds(&p, (take.seconds > 0.0).then_some(take.seconds));
        let frames = perform::frames(&scene, seconds) as usize;
        let mut out = vec![Vec::with_capacity(frames); scene.counts.n_out];
        let Ok(played) = play(p, frames as u64, BLOCK, &mut |_, rows, _| {
            for row in rows.chunks_exact(scene.counts.n_out.max(1)) {
                out.iter_mut().zip(row).for_each(|(o, v)| o.push(*v));
            }
            Ok::<(), Infallible>(())
        });
        let wall = played.wall.as_secs_f64();
        assert!(played.diverged_at.is_none() && out.iter().flatten().all(|v| v.is_finite()), "{name} diverges");
        let probed = out.split_off(scene.counts.channels);
        let probe = scene.names.probe_names.iter().cloned().zip(probed).collect();
        Render { rate: scene.rate, sound: out, probe, modules: [scene.mats(), scene.lias()], wall }
    }

    /// Returns the loudest channel of a cut, and the sound rate \[Hz\].
    pub fn loudest_channel(&self, cut: Cut) -> (Vec<f64>, f64) {
        let r = self.play(cut.take);
        (r.loudest_channel(cut.from, cut.to).to_vec(), r.rate)
    }

    /// Returns a probe of a cut by name.
    pub fn probe(&self, name: &str, cut: Cut) -> Vec<f64> {
        let r = self.play(cut.take);
        let found = r.probe.iter().find(|p| p.0 == name);
        let (_, all) = found.unwrap_or_else(|| panic!("{}: no probe `{name}`", self.instrument.model));
        r.part(all, cut.from, cut.to).to_vec()
    }

    /// Returns the cents from `f` \[Hz\] to the strongest partial within 3 % of it, half a semitone.
    pub fn cents(&self, f: f64, cut: Cut) -> f64 {
        let (x, rate) = self.loudest_channel(cut);
        acoustics::cents(acoustics::partial(&x, rate, f, 0.03 * f).0, f)
    }

    /// Returns the level of the strongest partial within 3 % of `f` \[Hz\], in dBFS.
    pub fn partial(&self, f: f64, cut: Cut) -> f64 {
        let (x, rate) = self.loudest_channel(cut);
        acoustics::db(acoustics::partial(&x, rate, f, 0.03 * f).1)
    }

    /// Returns the centre of gravity of the spectrum \[Hz\].
    pub fn centroid(&self, cut: Cut) -> f64 {
        let (x, rate) = self.loudest_channel(cut);
        acoustics::centroid(&x, rate)
    }

    /// Returns the power spectrum of all channels, with equal weight on every moment of the cut, and the width of its
    /// bins \[Hz\].
    fn power(&self, cut: Cut) -> (Vec<f64>, f64) {
        let r = self.play(cut.take);
        // windows a quarter of half a window apart, because a Gaussian is narrow
        let parts = r.sound.iter().map(|c| r.part(c, cut.from, cut.to));
        let mut all = parts.flat_map(|x| (0..4).map(|k| acoustics::density(&x[256 * k..], r.rate, 2048)));
        let (mut sum, bin) = all.next().expect("a channel");
        all.for_each(|(power, _)| sum.iter_mut().zip(power).for_each(|(s, p)| *s += p));
        (sum, bin)
    }

    /// Returns the power between two frequencies \[Hz\], in decibels with an arbitrary reference.
    pub fn band(&self, lo: f64, hi: f64, cut: Cut) -> f64 {
        let (power, bin) = self.power(cut);
        let at = |f: f64| ((f / bin) as usize).min(power.len());
        0.5 * acoustics::db(power[at(lo)..at(hi)].iter().sum::<f64>() / (cut.to - cut.from))
    }

    /// Returns the share of the power above `f` \[Hz\].
    pub fn above(&self, f: f64, cut: Cut) -> f64 {
        let (power, bin) = self.power(cut);
        power[(f / bin) as usize..].iter().sum::<f64>() / power.iter().sum::<f64>()
    }

    /// Returns the centre of gravity of the power spectrum \[Hz\], with equal weight on every moment of the cut.
    pub fn colour(&self, cut: Cut) -> f64 {
        let (power, bin) = self.power(cut);
        power.iter().enumerate().map(|(i, p)| i as f64 * bin * p).sum::<f64>() / power.iter().sum::<f64>()
    }

    /// Returns the time in which the partial at `f` \[Hz\] falls by 60 dB \[s\].
    pub fn t60(&self, f: f64, cut: Cut) -> f64 {
        let (x, rate) = self.loudest_channel(cut);
        acoustics::t60(&x, rate, f)
    }

    /// Returns the largest sample, in dBFS.
    pub fn peak(&self, cut: Cut) -> f64 {
        acoustics::db(acoustics::peak(&self.loudest_channel(cut).0))
    }

    /// Returns the level about the mean, in dBFS.
    pub fn level(&self, cut: Cut) -> f64 {
        acoustics::db(acoustics::rms(&self.loudest_channel(cut).0))
    }

    /// Returns how often the force of a probe begins after at least 5 ms without force.
    pub fn contacts(&self, name: &str, cut: Cut) -> f64 {
        let (x, rate) = (self.probe(name, cut), self.play(cut.take).rate);
        let apart = (0.005 * rate) as usize;
        let (mut n, mut free) = (0.0, apart);
        for v in x {
            n += f64::from(u8::from(v != 0.0 && free >= apart));
            free = if v == 0.0 { free + 1 } else { 0 };
        }
        n
    }

    /// Returns a parameter as written, in SI units, as in `low.f`; the first number of a list.
    pub fn number(&self, name: &str) -> f64 {
        let (owner, key) = name.rsplit_once('.').expect("owner.key");
        numbers(&self.model, owner, key)[0]
    }
}

/// Returns the numbers of a parameter as written, in SI units; panics if it does not exist.
pub fn numbers(model: &Model, owner: &str, key: &str) -> Vec<f64> {
    let item = model.items.iter().find(|i| i.name == owner).unwrap_or_else(|| panic!("no `{owner}`"));
    let value = |v: &Value| number(model, v).unwrap_or_else(|| panic!("{owner}.{key}: {v:?}"));
    match &item.args.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("no `{owner}.{key}`")).value {
        Value::List(l) => l.iter().map(|e| value(&e.value)).collect(),
        v => vec![value(v)],
    }
}

/// Evaluates a number, a note, a quantity, or the name of a parameter.
fn number(model: &Model, v: &Value) -> Option<f64> {
    match v {
        Value::Num(v) => Some(*v),
        Value::Text(t) => match model.params.iter().find(|p| p.key == *t) {
            Some(p) => number(model, &p.value),
            None => quantity::note(t).or_else(|| quantity::parse(t).ok().map(|q| q.value)),
        },
        Value::Table(t) => number(model, &t.iter().find(|e| e.key == "value")?.value),
        _ => None,
    }
}
