//! An instrument played as a claim asks, and what may be measured of it.
//!
//! Decides that each take is played once however many measures ask for it, with all probes of the instrument, and that of
//! several channels the loudest is measured: a sum of them may cancel.

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
    /// changes, as `--set` has them
    set: &'static [&'static str],
    /// what ports do instead of the built-in gesture: time \[s\] and value in SI units
    moved: &'static [(&'static str, &'static [[f64; 2]])],
    /// how much longer the built-in gesture lasts
    slower: f64,
    /// the way of each track of the built-in gesture from where it begins, as a part of its own
    way: f64,
    /// how long it sounds \[s\]; as its author says where 0
    seconds: f64,
}

/// The built-in gesture.
pub const BUILT: Take = Take { set: &[], moved: &[], slower: 1.0, way: 1.0, seconds: 0.0 };

impl Take {
    /// With these changes, each as `name=value`.
    #[must_use]
    pub const fn set(self, set: &'static [&'static str]) -> Take {
        Take { set, ..self }
    }
    /// With ports moved otherwise: name, and points of time \[s\] and value in SI units.
    #[must_use]
    pub const fn moved(self, moved: &'static [(&'static str, &'static [[f64; 2]])]) -> Take {
        Take { moved, ..self }
    }
    /// With a built-in gesture that lasts so many times as long.
    #[must_use]
    pub const fn slower(self, slower: f64) -> Take {
        Take { slower, ..self }
    }
    /// With a built-in gesture that goes this part of its way.
    #[must_use]
    pub const fn way(self, way: f64) -> Take {
        Take { way, ..self }
    }
    /// For so many seconds.
    #[must_use]
    pub const fn seconds(self, seconds: f64) -> Take {
        Take { seconds, ..self }
    }
    /// From `from` to `to` \[s\].
    pub const fn at(self, from: f64, to: f64) -> Cut {
        Cut { take: self, from, to }
    }
    /// All of it.
    pub const fn whole(self) -> Cut {
        self.at(0.0, f64::INFINITY)
    }
}

/// A part of a take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// what is played
    pub take: Take,
    /// \[s\]
    pub from: f64,
    /// \[s\]
    pub to: f64,
}

/// What was heard and probed.
pub struct Render {
    /// sound rate \[Hz\]
    pub rate: f64,
    /// by channel
    pub sound: Vec<Vec<f64>>,
    /// probes: name and samples
    pub probe: Vec<(String, Vec<f64>)>,
    /// MAT and LIA
    pub modules: [usize; 2],
    /// time it took \[s\]
    pub wall: f64,
}

impl Render {
    /// Samples of `x` from `from` to `to` \[s\].
    pub fn part<'a>(&self, x: &'a [f64], from: f64, to: f64) -> &'a [f64] {
        let at = |t: f64| ((t * self.rate) as usize).min(x.len());
        &x[at(from)..at(to)]
    }
    /// The loudest channel between two moments \[s\].
    pub fn heard(&self, from: f64, to: f64) -> &[f64] {
        let parts = self.sound.iter().map(|c| self.part(c, from, to));
        parts.max_by(|a, b| acoustics::rms(a).total_cmp(&acoustics::rms(b))).expect("a channel")
    }
}

/// An instrument under measure.
pub struct Plays {
    /// what it is
    pub instrument: &'static Instrument,
    /// its model as it is written
    pub model: Model,
    played: RefCell<Vec<(Take, Rc<Render>)>>,
}

impl Plays {
    /// Of this instrument.
    pub fn new(instrument: &'static Instrument) -> Plays {
        Plays { instrument, model: instrument.load().model, played: RefCell::default() }
    }

    /// A take; fails where it diverges.
    pub fn play(&self, take: Take) -> Rc<Render> {
        if let Some((_, r)) = self.played.borrow().iter().find(|p| p.0 == take) {
            return Rc::clone(r);
        }
        let r = Rc::new(self.render(take, self.instrument.probes));
        self.played.borrow_mut().push((take, Rc::clone(&r)));
        r
    }

    /// A take as it is played now, without regard to what was played.
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

    /// The loudest channel of a cut, and the sound rate \[Hz\].
    pub fn heard(&self, cut: Cut) -> (Vec<f64>, f64) {
        let r = self.play(cut.take);
        (r.heard(cut.from, cut.to).to_vec(), r.rate)
    }

    /// A probe of a cut, by its name.
    pub fn probe(&self, name: &str, cut: Cut) -> Vec<f64> {
        let r = self.play(cut.take);
        let found = r.probe.iter().find(|p| p.0 == name);
        let (_, all) = found.unwrap_or_else(|| panic!("{}: no probe `{name}`", self.instrument.model));
        r.part(all, cut.from, cut.to).to_vec()
    }

    /// Cents from `f` \[Hz\] to the strongest partial within 3 %, half a semitone, of it.
    pub fn cents(&self, f: f64, cut: Cut) -> f64 {
        let (x, rate) = self.heard(cut);
        acoustics::cents(acoustics::partial(&x, rate, f, 0.03 * f).0, f)
    }

    /// Level of the strongest partial within 3 % of `f` \[Hz\], in dBFS.
    pub fn partial(&self, f: f64, cut: Cut) -> f64 {
        let (x, rate) = self.heard(cut);
        acoustics::db(acoustics::partial(&x, rate, f, 0.03 * f).1)
    }

    /// Centre of gravity of the spectrum \[Hz\].
    pub fn centroid(&self, cut: Cut) -> f64 {
        let (x, rate) = self.heard(cut);
        acoustics::centroid(&x, rate)
    }

    /// Power spectrum of all channels, every moment of the cut alike, and the width of its bins \[Hz\].
    fn power(&self, cut: Cut) -> (Vec<f64>, f64) {
        let r = self.play(cut.take);
        // windows a quarter of a half apart: a Gaussian is narrow
        let parts = r.sound.iter().map(|c| r.part(c, cut.from, cut.to));
        let mut all = parts.flat_map(|x| (0..4).map(|k| acoustics::density(&x[256 * k..], r.rate, 2048)));
        let (mut sum, bin) = all.next().expect("a channel");
        all.for_each(|(power, _)| sum.iter_mut().zip(power).for_each(|(s, p)| *s += p));
        (sum, bin)
    }

    /// Power between two frequencies \[Hz\], in decibels of no particular reference.
    pub fn band(&self, lo: f64, hi: f64, cut: Cut) -> f64 {
        let (power, bin) = self.power(cut);
        let at = |f: f64| ((f / bin) as usize).min(power.len());
        0.5 * acoustics::db(power[at(lo)..at(hi)].iter().sum::<f64>() / (cut.to - cut.from))
    }

    /// Part of the power that is above `f` \[Hz\].
    pub fn above(&self, f: f64, cut: Cut) -> f64 {
        let (power, bin) = self.power(cut);
        power[(f / bin) as usize..].iter().sum::<f64>() / power.iter().sum::<f64>()
    }

    /// Centre of gravity of the power spectrum \[Hz\], every moment of the cut alike.
    pub fn colour(&self, cut: Cut) -> f64 {
        let (power, bin) = self.power(cut);
        power.iter().enumerate().map(|(i, p)| i as f64 * bin * p).sum::<f64>() / power.iter().sum::<f64>()
    }

    /// Time in which the partial at `f` \[Hz\] falls by 60 dB \[s\].
    pub fn t60(&self, f: f64, cut: Cut) -> f64 {
        let (x, rate) = self.heard(cut);
        acoustics::t60(&x, rate, f)
    }

    /// Largest sample, in dBFS.
    pub fn peak(&self, cut: Cut) -> f64 {
        acoustics::db(acoustics::peak(&self.heard(cut).0))
    }

    /// Level about the mean, in dBFS.
    pub fn level(&self, cut: Cut) -> f64 {
        acoustics::db(acoustics::rms(&self.heard(cut).0))
    }

    /// How often the force of a probe begins after at least 5 ms without any.
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

    /// A parameter as it is written, in SI, as in `low.f`; the first of a list.
    pub fn number(&self, name: &str) -> f64 {
        let (owner, key) = name.rsplit_once('.').expect("owner.key");
        numbers(&self.model, owner, key)[0]
    }
}

/// The numbers of a parameter as they are written, in SI; fails where there is none.
pub fn numbers(model: &Model, owner: &str, key: &str) -> Vec<f64> {
    let item = model.items.iter().find(|i| i.name == owner).unwrap_or_else(|| panic!("no `{owner}`"));
    let value = |v: &Value| number(model, v).unwrap_or_else(|| panic!("{owner}.{key}: {v:?}"));
    match &item.args.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("no `{owner}.{key}`")).value {
        Value::List(l) => l.iter().map(|e| value(&e.value)).collect(),
        v => vec![value(v)],
    }
}

/// A number, a note, a quantity, or the parameter that is named.
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
