//! Numbers hidden in a sound are found again, and numbers that cannot be found are reported.

use super::{Doubt, FitOptions, Range, Stage, StopReason, Words, fit};
use ca_compile::Options;
use ca_io::perform::Performance;
use ca_io::recording::Recording;
use ca_lab::Failure;
use ca_lab::load::{self, Loaded};
use ca_model::Value;

const RATE: f64 = 48_000.0;

/// The string of docs/instrument.md.
const MINE: &str = r#"
[STRING]
low = { n = 40, f = "110 Hz", t60 = "4 s", m = "1 g" }
[MAS]
hammer = { m = "20 g", x = "-5 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[8]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
left = { from = "low[3]", gain = 800 }
right = { from = "low@0.7", gain = 800 }
"#;

const HIDDEN: [&str; 3] = ["low.f", "low.t60", "hammer.m"];

fn model(text: &str, values: &[(&str, f64)]) -> Loaded {
    let mut loaded = Loaded::read(text, "mine.ca.toml");
    for (name, v) in values {
        let unit = match name.rsplit_once('.').map(|n| n.1) {
            Some("f") => "Hz",
            Some("m") => "kg",
            _ => "s",
        };
        load::set(&mut loaded, name, Value::Text(format!("{v:e} {unit}"))).unwrap();
    }
    loaded
}

fn recorded(loaded: &Loaded, seconds: f64) -> Recording {
    let scene = loaded.compile(&Options { rate: Some(RATE), ..Options::default() }).unwrap().scene;
    let mut p = Performance::new(&scene, None).unwrap();
    let mut channels = vec![Vec::new(); scene.counts.channels];
    for _ in 0..(seconds * RATE) as usize {
        p.tick();
        // with the rounding of a file
        channels.iter_mut().zip(&p.state.output).for_each(|(c, x)| c.push(f64::from(*x as f32)));
    }
    Recording { rate: RATE, channels }
}

/// Numbers from 0 up to 1, the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn between(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.next())
    }
    fn either(&mut self) -> f64 {
        if self.next() < 0.5 { -1.0 } else { 1.0 }
    }
}

fn options<'a>(
    vary: &'a [String],
    ranges: &'a [Range],
    progress: &'a mut dyn FnMut(u32, u32) -> bool,
) -> FitOptions<'a> {
    let words = &Words::COMMAND;
    FitOptions { vary, ranges, seconds: None, gain: None, renders: 60, gesture: None, words, progress }
}

fn names(all: &[&str]) -> Vec<String> {
    all.iter().map(|n| (*n).to_owned()).collect()
}

fn failure(loaded: &Loaded, recording: &Recording, vary: &[&str]) -> String {
    let vary = names(vary);
    let go = &mut |_, _| true;
    match fit(loaded, recording, &mut options(&vary, &[], go)).err() {
        Some(Failure::Usage(what) | Failure::Failed(what)) => what,
        other => panic!("{other:?}"),
    }
}

/// One second, from a start a semitone and factors of two off, to 0.1 cent, 1 % and 2 % in fewer than 60 renders.
#[test]
fn a_hidden_string_is_found() {
    let vary = names(&HIDDEN);
    for seed in 0..6_u64 {
        let mut drawn = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        for _ in 0..8 {
            drawn.next();
        }
        let truth = [drawn.between(80.0, 220.0), drawn.between(1.0, 7.0), drawn.between(0.004, 0.04)];
        let mut recording = recorded(&model(MINE, &[0, 1, 2].map(|k| (HIDDEN[k], truth[k]))), 1.0);
        if seed == 5 {
            // noise at -60 dB relative to the sound
            let power: f64 = recording.channels.iter().flatten().map(|x| x * x).sum();
            let size = (power / (2.0 * RATE)).sqrt() * 1e-3 * 12_f64.sqrt();
            recording.channels.iter_mut().flatten().for_each(|x| *x += size * (drawn.next() - 0.5));
        }
        // a factor of two, or up to it
        let mut far = || if seed % 2 == 0 { drawn.either() } else { drawn.either() * drawn.next() };
        let off = [far(), far()].map(f64::exp2);
        let off = [(drawn.either() / 12.0).exp2(), off[0], off[1]];
        let start = model(MINE, &[0, 1, 2].map(|k| (HIDDEN[k], truth[k] * off[k])));
        let mut seen = 0;
        let go = &mut |n, _| {
            seen = n;
            true
        };
        let found = fit(&start, &recording, &mut options(&vary, &[], go)).unwrap_or_else(|e| panic!("{e:?}"));
        let value = |k: usize| found.fitted[k].value;
        let cents = 1200.0 * (value(0) / truth[0]).log2();
        let (t60, m) = (value(1) / truth[1] - 1.0, value(2) / truth[2] - 1.0);
        println!(
            "seed {seed}: {cents:.5} cents, t60 {:.4} %, m {:.4} %, {} renders",
            1e2 * t60,
            1e2 * m,
            found.renders
        );
        assert!(cents.abs() < 0.1 && t60.abs() < 0.01 && m.abs() < 0.02, "seed {seed}: {cents} {t60} {m}");
        assert!(found.renders < 60 && found.renders == seen, "{} {seen}", found.renders);
        assert_eq!(found.stage, Stage::Samples);
        assert!(found.after.levels < 0.1 * found.before.levels);
        for (f, truth) in found.fitted.iter().zip(truth) {
            // the error is within the stated uncertainty, or is the rounding of the file
            let d = f.deviation.unwrap();
            assert!((f.value - truth).abs() < (4.0 * d).max(1e-6 * truth), "{}: {} ± {d}", f.varied.name, f.value);
        }
    }
}

#[test]
fn the_same_fit_gives_the_same_bits() {
    let vary = names(&["low.f"]);
    let recording = recorded(&model(MINE, &[("low.f", 113.0)]), 0.3);
    let once = || fit(&model(MINE, &[]), &recording, &mut options(&vary, &[], &mut |_, _| true)).unwrap();
    let (a, b) = (once(), once());
    assert_eq!(a.fitted[0].value.to_bits(), b.fitted[0].value.to_bits());
    assert_eq!(a.fitted[0].deviation.map(f64::to_bits), b.fitted[0].deviation.map(f64::to_bits));
    assert!((1200.0 * (a.fitted[0].value / 113.0).log2()).abs() < 0.1);
    assert_eq!(a.loaded.model.items.len(), 5);
}

#[test]
fn ranges_hold() {
    let vary = names(&["low.f"]);
    let recording = recorded(&model(MINE, &[("low.f", 116.0)]), 0.3);
    let ranges = [Range { name: "low.f".into(), ends: [Value::Num(100.0), Value::Text("112 Hz".into())] }];
    let found = fit(&model(MINE, &[]), &recording, &mut options(&vary, &ranges, &mut |_, _| true)).unwrap();
    let f = &found.fitted[0];
    assert!((100.0..=112.0).contains(&f.value), "{}", f.value);
    let [a, b] = [120.0, 130.0].map(Value::Num);
    let ranges = [Range { name: "low.f".into(), ends: [a, b] }];
    let e = fit(&model(MINE, &[]), &recording, &mut options(&vary, &ranges, &mut |_, _| true)).err();
    assert!(matches!(&e, Some(Failure::Usage(w)) if w.contains("starts at 110 Hz")), "{e:?}");
}

/// With a free gain, a common factor of masses and stiffnesses is inaudible, and so is a hammer that never arrives.
#[test]
fn what_the_sound_does_not_determine_is_said() {
    let late = MINE.replace("x = \"-5 mm\", v = \"1 m/s\"", "x = \"-9 m\", v = \"0 m/s\"");
    let late = format!(
        "{late}[ENF]\npull = {{ to = \"low[8]\" }}\n[gesture]\npull = [[0, 0], [0.01, \"1 N\"], [0.0101, 0]]\n"
    );
    let recording = recorded(&model(&late, &[("low.f", 112.0)]), 0.3);
    let vary = names(&["low.f", "hammer.m"]);
    let found = fit(&model(&late, &[]), &recording, &mut options(&vary, &[], &mut |_, _| true)).unwrap();
    assert!(found.fitted[0].deviation.is_some() && found.fitted[1].deviation.is_none(), "{:?}", found.fitted);
    assert!((1200.0 * (found.fitted[0].value / 112.0).log2()).abs() < 0.1);
    assert!(found.fitted[1].uncertainty().contains("not determined"));
}

/// An output of speed shows the same modes as one of displacement, so its partials are found too.
#[test]
fn a_string_whose_speed_is_heard_is_found() {
    let text = r#"
[STRING]
low = { n = 40, f = "110 Hz", t60 = "2 s", z = "0.2 mN s/m", m = "1 g" }
[SOX]
out = { from = "low[5]", hear = "HEAR", gain = 1 }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "1 m/s" }
[BUT]
hit = { between = ["hammer", "low[8]"], k = "20 kN/m" }
"#;
    let truth = [104.919, 3.072, 0.006_538];
    let vary = names(&HIDDEN);
    for hear in ["speed", "acceleration"] {
        let text = text.replace("HEAR", hear);
        let recording = recorded(&model(&text, &[0, 1, 2].map(|k| (HIDDEN[k], truth[k]))), 1.0);
        let found = fit(&model(&text, &[]), &recording, &mut options(&vary, &[], &mut |_, _| true)).unwrap();
        let off: Vec<f64> = found.fitted.iter().zip(truth).map(|(f, t)| f.value / t - 1.0).collect();
        println!("{hear}: {off:?}, {} renders", found.renders);
        assert!((1200.0 * (1.0 + off[0]).log2()).abs() < 0.1 && off[1].abs() < 0.01 && off[2].abs() < 0.02, "{off:?}");
        assert_eq!((found.stage, found.halt), (Stage::Samples, StopReason::Settled), "{hear}");
        assert!(found.fitted.iter().all(|f| f.deviation.is_some()), "{:?}", found.fitted);
    }
}

/// A search that runs out of renders gives no deviations, and says what to do.
#[test]
fn a_search_that_has_not_settled_says_so() {
    let vary = names(&HIDDEN);
    let truth = [("low.f", 104.0), ("low.t60", 3.0), ("hammer.m", 0.012)];
    let recording = recorded(&model(MINE, &truth), 0.4);
    let with = |renders: u32| {
        let go = &mut |_, _| true;
        let mut ask = FitOptions { renders, ..options(&vary, &[], go) };
        fit(&model(MINE, &[]), &recording, &mut ask).unwrap()
    };
    let found = with(10);
    assert_eq!(found.halt, StopReason::Renders);
    assert!(found.renders <= 10 && found.fitted.iter().all(|f| f.deviation.is_none()), "{:?}", found.fitted);
    assert!(found.fitted.iter().all(|f| f.doubt != Some(Doubt::Undetermined)), "{:?}", found.fitted);
    let said = found.warnings().join("\n");
    assert!(said.contains("did not converge within") && said.contains("`--renders`"), "{said}");
    let page = super::report(&found, "mine", "target.wav").html();
    assert!(page.contains("did not converge within") && !page.contains("±"));
    let found = with(60);
    assert_eq!((found.halt, found.warnings().len()), (StopReason::Settled, 0), "{:?}", found.warnings());
    assert!(found.fitted.iter().all(|f| f.uncertainty().starts_with('±')), "{:?}", found.fitted);
}

#[test]
fn one_is_not_several() {
    let recording = recorded(&model(MINE, &[]), 0.1);
    let few = |vary: &[&str]| {
        let (vary, go) = (names(vary), &mut |_, _| true);
        let mut ask = FitOptions { renders: 1, ..options(&vary, &[], go) };
        format!("{:?}", fit(&model(MINE, &[]), &recording, &mut ask).err().expect("too few samples"))
    };
    assert!(few(&["low.f"]).contains("too few for 1 number: "), "{}", few(&["low.f"]));
    assert!(few(&["low.f", "hammer.m"]).contains("too few for 2 numbers: "));
    let none = super::Distance { levels: 0.0, samples: 0.0 };
    let named = |count| super::Prediction { seconds: 1.0, model: none, sinusoids: none, count }.named();
    assert_eq!([1, 2].map(named), ["1 damped sinusoid", "2 damped sinusoids"]);
}

/// For sounds that a string cannot make, no number gets a deviation.
#[test]
fn what_the_model_does_not_explain_gets_no_deviations() {
    let vary = names(&["low.f", "hammer.m"]);
    let n = (0.5 * RATE) as usize;
    let mut drawn = Random(1);
    let sine = |i: usize| 0.5 * (std::f64::consts::TAU * 440.0 * i as f64 / RATE).sin();
    for (name, sound) in [
        ("noise", (0..n).map(|_| drawn.next() - 0.5).collect::<Vec<f64>>()),
        ("constant", vec![0.5; n]),
        ("click", (0..n).map(|i| if i == 2000 { 0.9 } else { 0.0 }).collect()),
        ("sine", (0..n).map(sine).collect()),
    ] {
        let recording = Recording { rate: RATE, channels: vec![sound] };
        let found = fit(&model(MINE, &[]), &recording, &mut options(&vary, &[], &mut |_, _| true)).unwrap();
        println!("{name}: {:?} {:?} {:?}", found.before, found.after, found.halt);
        assert!(found.fitted.iter().all(|f| f.deviation.is_none()), "{name}: {:?}", found.fitted);
        assert!(!found.explained, "{name}: {:?}", found.after);
        let said = found.warnings().join("\n");
        assert!(said.contains("does not explain this sound"), "{name}: {said}");
    }
}

/// An end of a range has a unit like a set value; a bare end has the unit of the value of its `[param]`.
#[test]
fn ends_of_ranges_have_units() {
    let mine = MINE.replace("\"20 g\"", "\"weight\"");
    let mine = model(&format!("[param]\nweight = {{ value = 20, unit = \"g\" }}\n{mine}"), &[]);
    let of = |name: &str, from: &str, to: &str| {
        let ends = [from, to].map(Value::typed);
        super::Varied::of(&mine, name, &[Range { name: name.into(), ends }], &Words::COMMAND)
    };
    for (name, from, to, is) in [
        ("low.f", "90 kg", "130 kg", "in Hz, not in kg"),
        ("low.f", "90 Hz", "130 s", "in Hz, not in s"),
        ("weight", "9 Hz", "0.1 kg", "Hz"),
    ] {
        let Err(Failure::Found(found)) = of(name, from, to) else { panic!("{name} {from} {to}") };
        let said = format!("{:?}", found.diags.list);
        assert!(said.contains("E008") && said.contains(is), "{said}");
    }
    assert_eq!(of("low.f", "90", "0.13 kHz").unwrap().bounds, [90.0, 130.0]);
    let bounds = of("weight", "10", "40 g").unwrap().bounds;
    assert!((bounds[0] - 0.01).abs() < 1e-12 && (bounds[1] - 0.04).abs() < 1e-12, "{bounds:?}");
}

/// The model that made a sound predicts the time after the fitted part to the rounding of the file; sinusoids do not.
#[test]
fn what_is_not_fitted_is_predicted() {
    let vary = names(&["low.f"]);
    let recording = recorded(&model(MINE, &[("low.f", 113.0)]), 0.8);
    let go = &mut |_, _| true;
    let mut ask = FitOptions { seconds: Some(0.3), ..options(&vary, &[], go) };
    let found = fit(&model(MINE, &[]), &recording, &mut ask).unwrap();
    let b = found.beyond.unwrap();
    assert!((b.seconds - 0.5).abs() < 0.05 && b.count == 1, "{b:?}");
    assert!(b.model.samples < -60.0 && b.model.levels < 0.1, "{b:?}");
    assert!(b.sinusoids.samples > b.model.samples && b.sinusoids.levels > 3.0, "{b:?}");
    let page = super::report(&found, "mine", "target.wav").html();
    assert!(page.contains("Residual over time") && page.contains("low.f"), "{page}");
    assert!(page.contains("1 damped sinusoid") && !page.contains("1 damped sinusoids"), "{page}");
}

/// Speed and position of a blow: numbers that may be negative, of a mass on a line.
#[test]
fn a_speed_and_a_place_are_found() {
    let hit = model(&MINE.replace("v = \"1 m/s\"", "v = \"1.3 m/s\""), &[]);
    let (vary, go) = (names(&["hammer.v"]), &mut |_: u32, _: u32| true);
    let ask = &mut FitOptions { gain: Some(1.0), ..options(&vary, &[], go) };
    let found = fit(&model(MINE, &[]), &recorded(&hit, 0.3), ask).unwrap();
    assert!((found.fitted[0].value - 1.3).abs() < 1e-4, "{}", found.fitted[0].value);
    let bent = "[CEL]\nbar = { m = \"1 g\", f = \"220 Hz\", t60 = \"1 s\", dx0 = \"-2 mm\" }\n[SOX]\nout = { from = \"bar\" }\n";
    let start = model(&bent.replace("-2 mm", "-1 mm"), &[]);
    let (vary, go) = (names(&["bar.dx0"]), &mut |_: u32, _: u32| true);
    let ask = &mut FitOptions { gain: Some(1.0), ..options(&vary, &[], go) };
    let found = fit(&start, &recorded(&model(bent, &[]), 0.3), ask).unwrap();
    assert!((found.fitted[0].value + 2e-3).abs() < 1e-6, "{}", found.fitted[0].value);
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let mine = model(MINE, &[]);
    let recording = recorded(&mine, 0.1);
    for (vary, word) in [
        (&[][..], "no number to vary"),
        (&["low.g"][..], "`low` has no parameter `g`"),
        (&["lwo.f"][..], "did you mean `low.f`?"),
        (&["low.f", "low.f"][..], "named twice"),
        (&["low.n"][..], "not a single number"),
        (&["strike.between"][..], "not a single number"),
        (&["low.k"][..], "give it a start"),
    ] {
        let said = failure(&mine, &recording, vary);
        assert!(said.contains(word), "{vary:?}: {said}");
    }
    for gain in [0.0, f64::NAN, f64::INFINITY] {
        let (vary, go) = (names(&["low.f"]), &mut |_: u32, _: u32| true);
        let said = fit(&mine, &recording, &mut FitOptions { gain: Some(gain), ..options(&vary, &[], go) }).err();
        assert!(matches!(&said, Some(Failure::Usage(what)) if what.contains("other than 0")), "{gain}: {said:?}");
    }
    let follows = model(
        &MINE.replace("\"110 Hz\"", "\"pitch\"").replace("[STRING]", "[param]\npitch = \"110 Hz\"\n[STRING]"),
        &[],
    );
    assert!(failure(&follows, &recording, &["low.f"]).contains("vary `pitch`"));
    let silent = Recording { rate: RATE, channels: vec![vec![0.0; 48_000]; 2] };
    assert!(failure(&mine, &silent, &["low.f"]).contains("silent"));
    let short = Recording { rate: RATE, channels: vec![vec![0.5; 400]; 2] };
    assert!(failure(&mine, &short, &["low.f"]).contains("0.05 s"));
    let still = model(&MINE.replace("v = \"1 m/s\"", "v = \"0 m/s\""), &[]);
    assert!(failure(&still, &recording, &["low.f"]).contains("no sound"));
    let vary = names(&["low.f"]);
    let go = &mut |_, _| true;
    let few = fit(&mine, &recording, &mut FitOptions { renders: 3, ..options(&vary, &[], go) }).err();
    assert!(matches!(&few, Some(Failure::Usage(w)) if w.contains("too few")), "{few:?}");
    let stopped = fit(&mine, &recording, &mut options(&vary, &[], &mut |n, _| n < 3)).err();
    assert_eq!(stopped, Some(Failure::Stopped));
}
