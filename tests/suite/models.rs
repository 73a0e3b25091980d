//! The instruments in `models/`: each reads, compiles without more warnings than its header explains, plays its own
//! gesture at a good level, and sounds as its header says, by spectrum and envelope.

use crate::acoustics::{
    centroid, cents, damping, db, density, eigenvalues, envelope, flatness, mode, partial, peak, period, rms, sin2,
    slope, stiffness, t60, velocity,
};
use ca_core::model::read::read;
use ca_core::model::{Model, Value, quantity, render};
use ca_core::{Catalog, Options, Scene, compile};
use ca_haptic::gesture::{Gesture, Track};
use ca_haptic::perform::Performance;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// One test per model of this name, and the list of them.
macro_rules! models {
    ($($name:ident),* $(,)?) => {
        const CHECKED: &[&str] = &[$(stringify!($name)),*];
        mod each {
            $(#[test] fn $name() { super::$name(); })*
        }
    };
}

models!(
    bowed_string,
    glass,
    gong,
    hammered_string,
    harmonic_chain,
    iron_bar,
    marimba,
    membrane,
    natural_harmonic,
    physical_lfo,
    piano_key,
    piano_wire,
    pinched_string,
    plate,
    plucked_string,
    rain_stick,
    slide_guitar,
    wind,
);

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../models")
}

fn file_names() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter_map(|n| n.strip_suffix(".ca.toml").map(String::from))
        .collect();
    names.sort();
    names
}

fn load(name: &str) -> Model {
    let text = std::fs::read_to_string(folder().join(format!("{name}.ca.toml"))).unwrap();
    let (model, found) = read(&text, &format!("{name}.ca.toml"), &Catalog::core());
    assert!(found.list.is_empty(), "{}", render::text(&found, &model, false));
    model
}

/// Warnings a header explains.
fn explained(name: &str) -> &'static [&'static str] {
    match name {
        "harmonic_chain" => &["W107"],
        _ => &[],
    }
}

/// A performance, as heard and as probed.
struct Heard {
    model: Model,
    rate: f64,
    /// sound, by channel
    sound: Vec<Vec<f64>>,
    /// probes, in the order asked
    probe: Vec<Vec<f64>>,
}

/// Plays a model by its own gesture, and holds it to what every model must keep.
fn play(name: &str, probes: &[&str]) -> Heard {
    let model = load(name);
    for word in ["Play:", "Try:", "Source:"] {
        assert!(model.header.contains(word), "{name}: the header has no `{word}`");
    }
    assert!(model.title().len() > 10 && !model.title().contains('\n'));
    let scene = scene(&model, probes);
    let told: Vec<&str> = scene.diags.list.iter().map(|d| d.code).filter(|c| c.starts_with('W')).collect();
    assert_eq!(told, explained(name), "{}", render::text(&scene.diags, &model, false));
    for code in &told {
        assert!(model.header.contains(code), "{name}: {code} is not explained in the header");
    }
    let heard = perform(model, &scene, None, scene.seconds.expect("a model says how long it sounds"));
    let level = heard.sound.iter().map(|c| db(peak(c))).fold(f64::MIN, f64::max);
    assert!((-12.0..=-0.5).contains(&level), "{name} peaks at {level:.2} dBFS");
    heard
}

fn scene(model: &Model, probes: &[&str]) -> Scene {
    let options = Options { probes: probes.iter().map(|p| (*p).into()).collect(), energy: true, ..Options::default() };
    compile(model, &Catalog::core(), &options).unwrap_or_else(|d| panic!("{}", render::text(&d, model, false)))
}

fn perform(model: Model, scene: &Scene, gesture: Option<&Gesture>, seconds: f64) -> Heard {
    let mut p = Performance::new(scene, gesture).unwrap();
    assert!(gesture.is_some() || p.duration() <= seconds, "the gesture is longer than the sound");
    let n = (seconds * scene.rate) as usize;
    let mut out = vec![Vec::with_capacity(n); scene.n_out];
    for _ in 0..n {
        p.tick();
        out.iter_mut().zip(&p.state.output).for_each(|(o, v)| o.push(*v));
    }
    assert!(!p.wild && out.iter().flatten().all(|v| v.is_finite()), "{}: wild", scene.title);
    // the books close, and contacts and hard springs are soft enough for the scheme to make next to no energy
    let book = p.state.ledger.as_ref().unwrap().balance();
    let (open, made) = (book.residual.abs() / book.peak, book.source.abs() / book.peak);
    assert!(book.peak == 0.0 || (open < 1e-9 && made < 0.02), "{}: open {open:e}, made {made:e}", scene.title);
    let probe = out.split_off(scene.channels);
    Heard { model, rate: scene.rate, sound: out, probe }
}

impl Heard {
    /// Samples from `t0` to `t1` [s].
    fn cut<'a>(&self, x: &'a [f64], t0: f64, t1: f64) -> &'a [f64] {
        &x[(t0 * self.rate) as usize..((t1 * self.rate) as usize).min(x.len())]
    }
    /// Sound of channel `c` from `t0` to `t1` [s].
    fn at(&self, c: usize, t0: f64, t1: f64) -> &[f64] {
        self.cut(&self.sound[c], t0, t1)
    }
    /// Probe number `i` from `t0` to `t1` [s].
    fn probed(&self, i: usize, t0: f64, t1: f64) -> &[f64] {
        self.cut(&self.probe[i], t0, t1)
    }
    /// The numbers of a parameter as written, in SI.
    fn numbers(&self, owner: &str, key: &str) -> Vec<f64> {
        let item = self.model.items.iter().find(|i| i.name == owner).unwrap();
        let value = |v: &Value| match v {
            Value::Num(v) => *v,
            Value::Text(t) => quantity::parse(t).unwrap().value,
            other => panic!("{owner}.{key}: {other:?}"),
        };
        match &item.args.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("{owner}.{key}")).value {
            Value::List(l) => l.iter().map(|e| value(&e.value)).collect(),
            v => vec![value(v)],
        }
    }
    fn number(&self, owner: &str, key: &str) -> f64 {
        self.numbers(owner, key)[0]
    }

    /// Partial `j` of the STRING or hinged STIFFSTRING `name`: frequency [Hz] and T60 [s], link viscosity included.
    fn string(&self, name: &str, j: usize) -> (f64, f64) {
        let n1 = self.number(name, "n") as usize + 1;
        let zo = damping(self.number(name, "t60"), self.rate);
        let shape = |j: usize| {
            let s = sin2(j, n1);
            let item = self.model.items.iter().find(|i| i.name == name).unwrap();
            let b = item.args.iter().find(|e| e.key == "b").map_or(0.0, |_| self.number(name, "b"));
            4.0 * s * (1.0 + 4.0 * s * b * (n1 * n1) as f64 / std::f64::consts::PI.powi(2))
        };
        let a = stiffness(self.number(name, "f"), zo, self.rate) * shape(j) / shape(1);
        // dampers are along the links, without bending
        let z = self.number(name, "z") / (self.number(name, "m") * self.rate) * 4.0 * sin2(j, n1);
        mode(a, zo + z, self.rate)
    }

    /// Asserts that partials of the sound stand where they should, within `within` cents.
    fn stands(&self, c: usize, t: [f64; 2], partials: impl IntoIterator<Item = f64>, reach: f64, within: f64) {
        for f in partials {
            let found = partial(self.at(c, t[0], t[1]), self.rate, f, reach).0;
            let off = cents(found, f);
            assert!(off.abs() < within, "{}: {found:.3} Hz is {off:+.2} cents from {f:.3} Hz", self.model.title());
        }
    }
}

#[test]
fn every_model_is_checked_and_every_kind_is_played() {
    assert_eq!(file_names(), CHECKED, "a model without a check, or a check without a model");
    let used: BTreeSet<String> = file_names().iter().flat_map(|n| load(n).items.into_iter().map(|i| i.kind)).collect();
    let known: BTreeSet<String> = Catalog::core().iter().map(|k| k.code.to_string()).collect();
    assert_eq!(used, known, "kinds no model plays");
    let titles: BTreeSet<String> = file_names().iter().map(|n| load(n).title().to_string()).collect();
    assert_eq!(titles.len(), file_names().len(), "two models share a title");
}

fn hammered_string() {
    let h = play("hammered_string", &["strike"]);
    h.stands(0, [3.5, 5.5], (1..=8).map(|j| h.string("low", j).0), 20.0, 1.0);
    let (f, t) = h.string("low", 1);
    let measured = t60(h.at(0, 3.5, 5.9), h.rate, f);
    assert!((measured / t - 1.0).abs() < 0.01, "T60 {measured:.3} s, analytic {t:.3} s");
    // five strokes, each louder in its blow than the one before
    let blows: Vec<f64> = (0..5).map(|i| peak(h.probed(0, 0.1 + 0.8 * i as f64, 0.3 + 0.8 * i as f64))).collect();
    assert!(blows.windows(2).all(|w| w[1] > 1.1 * w[0]), "{blows:?}");
    // the hammer leaves the string between strokes
    assert_eq!(peak(h.probed(0, 3.6, 6.0)), 0.0);
}

fn plucked_string() {
    let h = play("plucked_string", &["pluck"]);
    h.stands(1, [3.2, 4.8], (1..=8).map(|j| h.string("low", j).0), 20.0, 1.0);
    let (f, t) = h.string("low", 1);
    let measured = t60(h.at(1, 3.1, 4.9), h.rate, f);
    assert!((measured / t - 1.0).abs() < 0.01, "T60 {measured:.3} s, analytic {t:.3} s");
    // it lets go at k d, and then not a trace of force until the plectrum comes back
    let most = peak(h.probed(0, 0.0, 1.0)) / (h.number("pluck", "k") * h.number("pluck", "d"));
    assert!((0.9..1.2).contains(&most), "{most}");
    assert_eq!(peak(h.probed(0, 0.2, 1.3)), 0.0);
    assert_eq!(peak(h.probed(0, 1.5, 2.4)), 0.0);
    assert_eq!(peak(h.probed(0, 3.1, 5.0)), 0.0);
    for t in [0.1, 1.4, 2.5] {
        assert!(peak(h.probed(0, t, t + 0.5)) > 1.0, "no pluck at {t} s");
    }
}

fn natural_harmonic() {
    let h = play("natural_harmonic", &[]);
    let level = |j: usize, t0: f64, t1: f64| db(partial(h.at(0, t0, t1), h.rate, h.string("low", j).0, 15.0).1);
    for (n, before, after) in [(3, [0.4, 0.9], [1.6, 2.1]), (2, [2.8, 3.3], [4.2, 4.7])] {
        for j in 1..=8 {
            let fell = level(j, before[0], before[1]) - level(j, after[0], after[1]);
            if j % n == 0 {
                assert!(fell < 15.0, "partial {j} has a node under the finger and fell by {fell:.1} dB");
            } else {
                assert!(fell > 20.0, "partial {j} moves under the finger and fell by only {fell:.1} dB");
            }
        }
        let loudest = (1..=10).max_by(|a, b| level(*a, after[0], after[1]).total_cmp(&level(*b, after[0], after[1])));
        assert_eq!(loudest, Some(n));
    }
    h.stands(0, [1.5, 2.3], [3, 6].map(|j| h.string("low", j).0), 15.0, 1.0);
    // a fifth above the octave
    let sung = partial(h.at(0, 1.5, 2.3), h.rate, 330.0, 30.0).0;
    assert!(cents(sung, 3.0 * h.number("low", "f")).abs() < 2.0);
}

fn pinched_string() {
    let h = play("pinched_string", &["from_below", "from_above"]);
    let pitch = |t0: f64, t1: f64, near: f64| partial(h.at(1, t0, t1), h.rate, near, 20.0).0;
    let (open, held, again) = (pitch(0.3, 1.4, 110.0), pitch(2.0, 3.3, 165.0), pitch(3.6, 4.8, 110.0));
    assert!(cents(open, h.string("low", 1).0).abs() < 1.0, "{open}");
    assert!(cents(again, h.string("low", 1).0).abs() < 1.0, "{again}");
    // a third of the string is cut off: a fifth, a little less because fingers give way
    let fifth = cents(held / open, 1.5);
    assert!((-15.0..0.5).contains(&fifth), "{held} Hz: {fifth:.1} cents from a fifth");
    let low = partial(h.at(1, 2.0, 3.3), h.rate, 110.0, 20.0).1;
    assert!(low < 0.05 * partial(h.at(1, 2.0, 3.3), h.rate, 165.0, 20.0).1);
    // both sides press while it is held, and neither when open
    assert!(h.probed(0, 2.0, 3.3).iter().chain(h.probed(1, 2.0, 3.3)).all(|f| *f != 0.0));
    assert_eq!(peak(h.probed(0, 3.6, 5.0)) + peak(h.probed(1, 3.6, 5.0)), 0.0);
}

fn bowed_string() {
    let h = play("bowed_string", &["low[5]"]);
    let f = h.string("low", 1).0;
    let (hair, place) = (0.49 / 1.9, 6.0 / 41.0);
    for (t0, t1, bow) in [(0.8, 1.8, hair), (2.9, 3.7, -0.5 / 1.9)] {
        let (p, like) = period(&h.at(0, t0, t1)[..9600], h.rate, 0.8 / f, 1.2 / f);
        assert!((p * f - 1.0).abs() < 0.02 && like > 0.98, "period {p} s of {} s, likeness {like}", 1.0 / f);
        // Helmholtz: the string sticks to the hair all the period but for the share β of the bow's place
        let v = velocity(h.probed(0, t0, t1), h.rate);
        let sticks: Vec<bool> = v.iter().map(|v| (v - bow).abs() < h.number("hair", "v0")).collect();
        let stick = sticks.iter().filter(|s| **s).count() as f64 / sticks.len() as f64;
        assert!((stick - (1.0 - place)).abs() < 0.1, "sticks {stick:.3} of the time, β is {place:.3}");
        let slips = v.windows(2).filter(|w| w[0] * bow >= 0.0 && w[1] * bow < 0.0).count() as f64;
        let each = slips / ((t1 - t0) * f);
        assert!((each - 1.0).abs() < 0.1, "{each:.2} slips per period");
        let swell = envelope(h.at(0, t0, t1), 4800);
        let spread = db(swell.iter().fold(0.0, |a: f64, b| a.max(*b)) / swell.iter().fold(1.0, |a: f64, b| a.min(*b)));
        assert!(spread < 1.0, "the level wavers by {spread:.2} dB");
    }
    assert!(rms(h.at(0, 4.8, 5.0)) < 0.2 * rms(h.at(0, 3.5, 3.7)), "it goes on without the bow");
}

/// λ of mode (p, q) of a closed (+1 on both sides) or open mesh, over a.
fn mesh(p: usize, q: usize, nx: usize, ny: usize) -> f64 {
    4.0 * (sin2(p, nx) + sin2(q, ny))
}

fn membrane() {
    let h = play("membrane", &[]);
    let (nx, ny) = (h.number("skin", "nx") as usize - 1, h.number("skin", "ny") as usize - 1);
    let zo = damping(h.number("skin", "t60"), h.rate);
    let z = h.number("skin", "z") / (h.number("skin", "m") * h.rate);
    let a = stiffness(h.number("skin", "f"), zo, h.rate) / mesh(1, 1, nx, ny);
    let tone = |p, q| mode(a * mesh(p, q, nx, ny), zo + z * mesh(p, q, nx, ny), h.rate);
    let modes = [(1, 1), (2, 1), (1, 2), (2, 2), (3, 1)].map(|(p, q)| tone(p, q).0);
    h.stands(0, [2.3, 3.3], modes, 6.0, 3.0);
    // strings have 2, 3, 4; a skin has not
    assert!((modes[1] / modes[0] - 2.0).abs() > 0.3);
    let measured = t60(h.at(0, 2.4, 3.6), h.rate, modes[0]);
    assert!((measured / tone(1, 1).1 - 1.0).abs() < 0.03, "T60 {measured:.3} s, analytic {:.3} s", tone(1, 1).1);
    let colour = |t: f64| centroid(&velocity(h.at(0, t, t + 0.2), h.rate), h.rate);
    assert!(colour(1.88) > 1.3 * colour(0.15), "rim {:.0} Hz, centre {:.0} Hz", colour(1.88), colour(0.15));
}

fn plate() {
    let h = play("plate", &["sheet[0,0]"]);
    let (nx, ny) = (h.number("sheet", "nx") as usize, h.number("sheet", "ny") as usize);
    let zo = damping(h.number("sheet", "t60"), h.rate);
    let z = h.number("sheet", "z") / (h.number("sheet", "m") * h.rate);
    let a = stiffness(h.number("sheet", "f"), zo, h.rate) / mesh(1, 0, nx, ny);
    let tone = |p, q| mode(a * mesh(p, q, nx, ny), zo + z * mesh(p, q, nx, ny), h.rate).0;
    let modes = [(1, 0), (0, 1), (1, 1), (2, 0), (2, 1), (3, 0), (1, 2)].map(|(p, q)| tone(p, q));
    for f in modes {
        let found = partial(h.probed(0, 2.5, 4.1), h.rate, f, 6.0).0;
        assert!(cents(found, f).abs() < 3.0, "{found:.2} Hz is {:+.2} cents from {f:.2} Hz", cents(found, f));
    }
    // no border holds it: the lowest mode has the long side as half a wave, λ ∝ nx alone
    assert!(cents(tone(1, 0), h.number("sheet", "f")).abs() < 0.5);
    let (before, after) = (rms(h.at(0, 4.0, 4.2)), rms(h.at(0, 4.6, 4.8)));
    assert!(db(before / after) > 15.0, "the palm takes only {:.1} dB", db(before / after));
    let strokes = [0.1, 1.2, 2.3].map(|t| peak(h.at(0, t, t + 0.3)));
    assert!(strokes[0] < strokes[1] && strokes[1] < strokes[2], "{strokes:?}");
}

fn gong() {
    let h = play("gong", &[]);
    let both: Vec<f64> = h.sound[0].iter().zip(&h.sound[1]).map(|(a, b)| a + b).collect();
    let colour = |t: f64| centroid(h.cut(&both, t, t + 0.15), h.rate);
    let (blow, bloom, late) =
        (colour(1.52), (0..4).map(|i| colour(1.7 + 0.1 * f64::from(i))).fold(0.0, f64::max), colour(4.5));
    assert!(bloom > 1.2 * blow, "blow {blow:.0} Hz, bloom {bloom:.0} Hz");
    assert!(late < 0.8 * bloom, "bloom {bloom:.0} Hz, late {late:.0} Hz");
    // energy has climbed: the share of cells the mallet cannot reach grows after it has gone
    let high = |t: f64| {
        let (d, bin) = density(h.cut(&both, t, t + 0.15), h.rate, 4800);
        d[(900.0 / bin) as usize..(3000.0 / bin) as usize].iter().sum::<f64>() / d.iter().sum::<f64>()
    };
    assert!(high(1.85) > 1.5 * high(1.52), "{} {}", high(1.52), high(1.85));
    // a soft stroke wakes little
    assert!(colour(0.2) < 0.7 * bloom, "soft {:.0} Hz", colour(0.2));
}

fn wind() {
    let h = play("wind", &["air[13]", "air[4]", "whistle1", "whistle2", "whistle3", "whistle4"]);
    // the row of colliding masses is near white: its velocity is far flatter than any tone
    for i in 0..2 {
        let v = velocity(h.probed(i, 1.0, 5.0), h.rate);
        let flat = flatness(&v, h.rate, 100.0, 2000.0);
        assert!(flat > 0.7, "flatness {flat:.3}");
        let beat = period(&v[..24_000], h.rate, 0.002, 0.02).1;
        assert!(beat < 0.5, "it repeats itself: {beat:.2}");
    }
    // four oscillators sing in it, a little sharp as they harden
    for (i, name) in ["whistle1", "whistle2", "whistle3", "whistle4"].iter().enumerate() {
        let f = h.number(name, "f");
        let (d, bin) = density(h.probed(2 + i, 1.0, 5.0), h.rate, 9600);
        let band = |lo: f64, hi: f64| d[(lo / bin) as usize..(hi / bin) as usize].iter().sum::<f64>() / (hi - lo);
        let top = (50..(3000.0 / bin) as usize).max_by(|a, b| d[*a].total_cmp(&d[*b])).unwrap() as f64 * bin;
        assert!((0.97..1.12).contains(&(top / f)), "{name} sings at {top:.0} Hz, not {f:.0} Hz");
        let over = 10.0 * (band(0.95 * f, 1.1 * f) / band(1.5 * f, 2.0 * f)).log10();
        assert!(over > 10.0, "{name} stands out by {over:.1} dB");
        // noise has no steady amplitude
        let swell = envelope(h.probed(2 + i, 1.0, 5.0), 2400);
        let mean = swell.iter().sum::<f64>() / swell.len() as f64;
        assert!(rms(&swell) > 0.1 * mean, "{name} is a tone");
    }
    assert!(rms(h.at(0, 6.8, 7.0)) < 0.1 * rms(h.at(0, 2.0, 5.0)), "no bow, no wind");
}

fn physical_lfo() {
    let h = play("physical_lfo", &["pendulum", "low[36]"]);
    let f = h.number("pendulum", "f");
    // two swells per swing, at the rate the pendulum really has
    let audible = velocity(h.probed(1, 0.0, 6.0), h.rate);
    let level = envelope(&audible, 960);
    let (swell, like) = period(&level[..250], h.rate / 960.0, 0.3 / f, 0.7 / f);
    assert!((swell * 2.0 * f - 1.0).abs() < 0.05 && like > 0.6, "a swell every {swell:.3} s ({like:.2})");
    let (swing, like) =
        period(&h.probed(0, 0.0, 6.0).iter().step_by(480).copied().collect::<Vec<_>>(), 100.0, 1.0, 3.0);
    assert!((swing * f - 1.0).abs() < 0.02 && like > 0.9, "swings every {swing:.3} s ({like:.2})");
    // sounding costs it its swing, far more than its own decay would
    let size = |t: f64| peak(h.probed(0, t, t + 2.0));
    assert!(size(4.0) < 0.8 * size(0.0), "{} {}", size(0.0), size(4.0));
    // and it plays the notes of the strings
    let x = h.at(0, 0.2, 0.8);
    for name in ["low", "fifth"] {
        let (note, _) = partial(x, h.rate, h.number(name, "f"), 8.0);
        assert!(cents(note, h.number(name, "f")).abs() < 35.0, "{name} sounds {note:.1} Hz");
    }
}

fn piano_key() {
    let h = play("piano_key", &["stop[0]", "strike_c[0]", "strike_e[0]", "strike_g[0]"]);
    // the key meets its bed and is held there; each hammer strikes and is free again
    assert!(h.probed(0, 0.2, 0.55).iter().all(|f| *f != 0.0) && peak(h.probed(0, 0.75, 1.9)) == 0.0);
    for (i, t) in [0.1, 0.5, 0.9].into_iter().enumerate() {
        assert!(peak(h.probed(1 + i, t, t + 0.1)) > 1.0, "hammer {i} does not strike");
        assert_eq!(peak(h.probed(1 + i, t + 0.2, t + 0.6)), 0.0, "hammer {i} stays");
    }
    // the chord on the bridge
    for (f, t) in [(261.63, 0.15), (329.63, 0.55), (392.0, 0.95)] {
        h.stands(0, [t, t + 0.8], [f], 12.0, 8.0);
        h.stands(0, [3.1, 3.9], [f], 12.0, 8.0);
    }
    assert!(peak(h.at(0, 3.0, 3.3)) > 2.0 * peak(h.at(0, 2.0, 2.3)), "a faster key is louder");
    // a key pressed slowly is silent: the hammer never arrives
    let scene = scene(&h.model, &[]);
    let slow = Track::points("c", vec![(0.0, -10e-3), (0.1, -10e-3), (0.6, -0.5e-3), (1.0, -0.5e-3)]).unwrap();
    let still = |name: &str| Track::points(name, vec![(0.0, -10e-3)]).unwrap();
    let gesture = Gesture::new(vec![slow, still("e"), still("g")]).unwrap();
    let quiet = perform(load("piano_key"), &scene, Some(&gesture), 1.0);
    assert_eq!(peak(&quiet.sound[0]), 0.0);
}

fn iron_bar() {
    let h = play("iron_bar", &[]);
    let n = h.number("bar", "n") as usize;
    let (m, bend) = (h.number("bar", "m"), h.number("bar", "kb"));
    // ½ B Σ (x_{i−1} − 2x_i + x_{i+1})² over inner nodes, and the felts
    let mut k = vec![vec![0.0; n]; n];
    for i in 1..n - 1 {
        for (a, wa) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
            for (b, wb) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                k[a][b] += bend * wa * wb / (m * h.rate * h.rate);
            }
        }
    }
    let free: Vec<f64> = eigenvalues(k.clone()).into_iter().map(|l| mode(l.max(0.0), 0.0, h.rate).0).collect();
    for (i, ratio) in [(3, 2.757), (4, 5.404)] {
        assert!((free[i] / free[2] / ratio - 1.0).abs() < 0.04, "{}", free[i] / free[2]);
    }
    for i in [5, 19] {
        k[i][i] += h.number("felts", "k") / (m * h.rate * h.rate);
    }
    let zo = damping(h.number("bar", "t60"), h.rate);
    let tones: Vec<f64> = eigenvalues(k).into_iter().map(|l| mode(l, zo, h.rate).0).collect();
    // without the losses of felts and bar the modes are exactly those of the matrix
    let mut bare = load("iron_bar");
    assert!(bare.set("felts.z", "0") && bare.set("bar.z", "0"));
    let scene = scene(&bare, &[]);
    perform(bare, &scene, None, 4.0).stands(0, [2.4, 4.0], tones[2..8].iter().copied(), 8.0, 1.0);
    // with them the first mode stays put
    assert!(cents(partial(h.at(1, 2.5, 3.3), h.rate, tones[2], 12.0).0, tones[2]).abs() < 15.0);
    let strokes = [0.1, 1.2, 2.3].map(|t| peak(h.at(0, t, t + 0.3)));
    assert!(strokes[0] < strokes[1] && strokes[1] < strokes[2], "{strokes:?}");
}

fn piano_wire() {
    let h = play("piano_wire", &[]);
    h.stands(0, [2.2, 3.9], (1..=10).map(|j| h.string("wire", j).0), 8.0, 1.0);
    // partial 10 is sharp by what stiffness says, and not otherwise
    let b = h.number("wire", "b");
    let stretch = |j: f64| (1.0 + b * j * j).sqrt();
    let found = [1, 10].map(|j| partial(h.at(0, 2.2, 3.9), h.rate, h.string("wire", j).0, 8.0).0);
    let sharp = cents(found[1] / found[0], 10.0);
    // less what 47 masses lack to a continuum
    let n1 = h.number("wire", "n") as usize + 1;
    let theory = cents(stretch(10.0), stretch(1.0)) + cents((sin2(10, n1) / sin2(1, n1)).sqrt(), 10.0);
    assert!((sharp - theory).abs() < 5.0 && sharp > 20.0, "{sharp:.1} cents, theory {theory:.1}");
    let (f, t) = h.string("wire", 1);
    let measured = t60(h.at(0, 2.2, 4.0), h.rate, f);
    assert!((measured / t - 1.0).abs() < 0.02, "T60 {measured:.3} s, analytic {t:.3} s");
    assert!(db(rms(h.at(0, 3.9, 4.0)) / rms(h.at(0, 4.7, 5.0))) > 30.0, "the felt does not stop it");
    assert!(centroid(h.at(0, 2.02, 2.3), h.rate) > centroid(h.at(0, 0.13, 0.4), h.rate), "harder is brighter");
}

fn glass() {
    let h = play("glass", &["rim[0]", "rim[1]", "rim[2]"]);
    for (i, (f, t)) in h.numbers("rim", "f").into_iter().zip([0.1, 1.2, 2.4]).enumerate() {
        // silent before its finger moves, steady while it circles, dying when it stops
        assert!(peak(h.probed(i, 0.0, t)) < 1e-9, "rim {i} sounds before its time");
        let held = h.probed(i, 3.9, 4.4);
        let (note, size) = partial(held, h.rate, f, 15.0);
        assert!(cents(note, f).abs() < 12.0, "rim {i} sings {note:.2} Hz, not {f:.2} Hz");
        assert!(size > 5.0 * partial(held, h.rate, 2.0 * f, 15.0).1, "rim {i} is not pure");
        let steady = envelope(held, 4800);
        assert!(steady.iter().all(|v| (v / steady[0] - 1.0).abs() < 0.05), "rim {i}: {steady:?}");
        assert!(db(rms(held) / rms(h.probed(i, 6.6, 7.0))) > 20.0, "rim {i} goes on without its finger");
    }
}

fn marimba() {
    let h = play("marimba", &["low_bar[0]", "low_tube"]);
    let near = |x: &[f64], f: f64| cents(partial(x, h.rate, f, 20.0).0, f);
    assert!(near(h.at(0, 0.15, 0.65), 196.0).abs() < 15.0 && near(h.at(1, 0.75, 1.25), 293.66).abs() < 15.0);
    assert!(near(h.at(0, 0.13, 0.4), 784.0).abs() < 5.0, "the second partial is two octaves up");
    // the air swings wider than the wood that drives it
    assert!(rms(h.probed(1, 0.3, 0.6)) > 2.0 * rms(h.probed(0, 0.3, 0.6)));
    // and takes its energy: the bar dies sooner than by itself
    let alone = h.numbers("low_bar", "t60")[0];
    let with = t60(h.probed(0, 0.3, 1.2), h.rate, 196.0);
    assert!(with < 0.8 * alone, "T60 {with:.2} s, alone {alone:.2} s");
    assert!(centroid(h.at(0, 0.12, 0.22), h.rate) > centroid(h.at(0, 0.5, 0.8), h.rate));
}

fn slide_guitar() {
    let h = play("slide_guitar", &[]);
    let f0 = h.string("neck", 1).0;
    let pitch = |t0: f64, t1: f64, near: f64| partial(h.at(0, t0, t1), h.rate, near, 12.0).0;
    // f / (1 − slide), a little less as the bar gives way
    for (slide, t0, t1) in [(0.1, 0.2, 0.5), (0.4, 1.9, 2.4), (0.4, 2.75, 3.15), (0.1, 4.4, 5.8)] {
        let ideal = f0 / (1.0 - slide);
        let off = cents(pitch(t0, t1, ideal), ideal);
        assert!((-25.0..5.0).contains(&off), "{t0} s: {off:+.1} cents from {ideal:.2} Hz");
    }
    // on the way it passes every pitch between
    let way: Vec<f64> = (0..5)
        .map(|i| 0.55 + 0.11 * f64::from(i))
        .map(|t| {
            let (p, _) = period(h.at(0, t, t + 0.08), h.rate, 1.0 / 145.0, 1.0 / 85.0);
            1.0 / p
        })
        .collect();
    assert!(way.windows(2).all(|w| w[1] > w[0]), "{way:?}");
}

fn rain_stick() {
    let h = play("rain_stick", &["hop[4]", "hop[9]"]);
    // the first bead falls for √(2h/g), then hops, each hop shorter than the last by the same factor
    let x0 = h.number("beads.e", "x");
    let mut strikes: Vec<f64> = Vec::new();
    for (i, w) in h.probe[0].windows(2).enumerate() {
        let t = (i + 1) as f64 / h.rate;
        if w[0] == 0.0 && w[1] != 0.0 && strikes.last().is_none_or(|last| t - last > 0.01) {
            strikes.push(t);
        }
    }
    let fall = (2.0 * x0 / 9.81).sqrt();
    assert!((strikes[0] / fall - 1.0).abs() < 0.002, "strikes at {} s, falls in {fall:.4} s", strikes[0]);
    let hops: Vec<f64> = strikes.windows(2).map(|w| w[1] - w[0]).take(8).collect();
    assert!(hops.len() == 8 && hops[7] < 0.8 * hops[0], "{hops:?}");
    let line: Vec<[f64; 2]> = hops.iter().enumerate().map(|(i, h)| [i as f64, h.ln()]).collect();
    assert!(slope(&line) < -0.01, "{hops:?}");
    // chimes are where they are tuned
    for (i, f) in h.numbers("chime", "f").into_iter().enumerate() {
        let found = partial(h.at(i % 2, 0.1, 3.0), h.rate, f, 20.0).0;
        assert!(cents(found, f).abs() < 5.0, "chime {i}: {found:.2} Hz, not {f:.2} Hz");
    }
}

fn harmonic_chain() {
    let names = ["string4", "string5", "string6"];
    let h = play("harmonic_chain", &["string4[12]", "string5[12]", "string6[12]"]);
    for (i, name) in names.iter().enumerate() {
        let samples = 2 * (h.number(name, "n") as usize + 1);
        // free between the last push and the damper: every sample repeats after 2(N + 1)
        let x = h.probed(i, 1.2, 4.4);
        let size = peak(x);
        let worst = x.iter().zip(&x[samples..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(size > 0.0 && worst < 1e-12 * size, "{name}: {worst:e} of {size:e} in {samples} samples");
        let f = h.rate / samples as f64;
        for j in 1..=20 {
            let (found, level) = partial(&x[..96_000], h.rate, f64::from(j) * f, 20.0);
            if db(level / size) > -50.0 {
                assert!((found / (f64::from(j) * f) - 1.0).abs() < 1e-6, "{name}, partial {j}: {found}");
            }
        }
    }
    let pitch = |name: &str| h.rate / (2.0 * (h.number(name, "n") + 1.0));
    assert!((pitch("string5") / pitch("string4") - 1.25).abs() < 1e-12, "a pure third");
    assert!((pitch("string6") / pitch("string4") - 1.5).abs() < 1e-12, "a pure fifth");
    assert!(db(rms(h.at(0, 4.0, 4.4)) / rms(h.at(0, 5.8, 6.0))) > 30.0, "the damper does not stop it");
}
