//! Checks the effect of each command in the README, so that a command without effect fails.
//!
//! An effect depends on the command and its options, not on the line. So other names and numbers in the README need no
//! new test, and a command unknown here fails until its effect is defined.
#![cfg(unix)]

use crate::sandbox::{RunOutput, Sandbox, peak};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// A shell line that runs `ca`.
pub struct Line<'a> {
    pub text: &'a str,
    /// Words after `ca`, without quotes, comment, redirections and `&`.
    pub words: Vec<String>,
    /// True if the command runs in the background.
    pub beside: bool,
    /// File of the redirected output.
    into: Option<String>,
}

impl<'a> Line<'a> {
    pub fn new(text: &'a str) -> Option<Line<'a>> {
        let mut words: Vec<String> = Vec::new();
        let (mut word, mut quote) = (None::<String>, None);
        for c in text.chars().chain([' ']) {
            match (c, quote) {
                (c, Some(q)) if c == q => quote = None,
                ('\'' | '"', None) => {
                    quote = Some(c);
                    word.get_or_insert_default();
                }
                (' ', None) => words.extend(word.take()),
                ('#', None) if word.is_none() => break,
                (c, _) => word.get_or_insert_default().push(c),
            }
        }
        let beside = words.iter().any(|w| w == "&");
        let into = words.iter().position(|w| w == ">").and_then(|at| words.get(at + 1).cloned());
        words.truncate(words.iter().position(|w| [">", "&", "|"].contains(&w.as_str())).unwrap_or(words.len()));
        let ca = words.first().is_some_and(|w| w == "ca") && words.len() > 1;
        ca.then(|| Line { text, words: words.split_off(1), beside, into })
    }

    pub fn verb(&self) -> &str {
        &self.words[0]
    }

    /// All values of an option.
    fn all<'s>(&'s self, option: &'s str) -> impl Iterator<Item = &'s str> {
        self.words.windows(2).filter(move |w| w[0] == option).map(|w| w[1].as_str())
    }

    fn of(&self, option: &str) -> Option<&str> {
        self.words.windows(2).find(|w| w[0] == option).map(|w| w[1].as_str())
    }

    fn has(&self, option: &str) -> bool {
        self.words.iter().any(|w| w == option)
    }

    /// The model, or another subject of the command.
    fn about(&self) -> &str {
        self.words.get(1).map_or("", String::as_str)
    }
}

pub type Files = BTreeMap<String, Vec<u8>>;

pub fn files(sandbox: &Sandbox) -> Files {
    sandbox.files().into_iter().map(|f| (f.clone(), fs::read(sandbox.path(&f)).unwrap())).collect()
}

/// Checks the effects of a completed line.
pub fn check(sandbox: &Sandbox, line: &Line, before: &Files, ran: &RunOutput) {
    let says = |words: &[&str]| {
        for w in words {
            assert!(ran.out.contains(w), "`{}`: no `{w}` in\n{}", line.text, ran.out);
        }
    };
    match line.verb() {
        "check" if line.has("--device") => {
            says(&["stability", "passive", "result"]);
            let rows = ran.out.lines().skip_while(|l| !l.trim_end().ends_with("result")).skip(1);
            let keys = rows.filter(|l| l.contains("rendered") || l.contains('×')).count();
            assert!(keys > 0, "`{}` compares no key:\n{}", line.text, ran.out);
        }
        "check" => {
            says(&["stability", "modules"]);
            if line.has("--schedule") {
                says(&["One tick, measured on this machine:", "Left out:"]);
            }
        }
        "bench" => says(&["44.1 kHz", "ns/module", line.of("--only").unwrap()]),
        "modes" => says(&["heard [Hz]", &format!("{:.4}", lowest(sandbox, line.about()))]),
        "tune" => tuned(sandbox, line, before),
        "fit" => {
            let names = line.of("--vary").unwrap();
            names.split(',').for_each(|n| says(&[&format!("{n}: ")]));
            says(&["renders", "±", "before:", "after:"]);
        }
        "render" => rendered(sandbox, line, before, ran),
        "accuracy" => {
            says(&["against"]);
            let times = line.of("--times").unwrap().split(',').count();
            let rows = ran.out.matches("as written").count();
            assert!(rows >= times, "`{}`: {rows} rows for {times} rates\n{}", line.text, ran.out);
        }
        "report" => {
            let page = fs::read_to_string(sandbox.path(line.of("-o").unwrap())).unwrap();
            assert!(page.to_lowercase().starts_with("<!doctype html>"), "`{}`", line.text);
            for word in ["data:audio/wav;base64,", "<h2>Sound", "<h2>Energy"] {
                assert!(page.contains(word), "`{}`: no `{word}` on the page", line.text);
            }
        }
        "list" => match line.words.get(1) {
            None => {
                ca_lab::catalog().iter().for_each(|k| says(&[k.code, k.equation]));
                for m in ca_lab::load::BUNDLED {
                    says(&[m.0]);
                }
            }
            Some(kind) => {
                let catalog = ca_lab::catalog();
                let kind = catalog.get(kind).unwrap();
                kind.params.iter().for_each(|p| says(&[p.name, p.doc.split(' ').next().unwrap()]));
            }
        },
        "explain" => {
            let code = line.about();
            let title = ca_model::diag::CODES.iter().find(|c| c.0 == code).unwrap().1;
            says(&[&format!("{code} {title}"), &format!("[{code}]: "), "help: "]);
        }
        "new" => {
            assert!(!before.contains_key(line.about()) && sandbox.path(line.about()).is_file());
            assert_eq!(sandbox.ca(&["check", line.about()]).is(0).err, "");
        }
        "equiv" => scaled(sandbox, line, before, ran),
        "serve" => {
            let (_, sound) = sandbox.wav(line.of("-o").unwrap());
            assert!(peak(&sound) > 1e-3, "`{}`: a peak of {}", line.text, peak(&sound));
            let seconds: f64 = line.of("--seconds").unwrap().parse().unwrap();
            let take = sandbox.ca(&["log", "info", line.of("--log").unwrap(), "--json"]).is(0).json();
            let lasts = take["seconds"].as_f64().unwrap();
            assert!((lasts - seconds).abs() < 0.1, "`{}`: a take of {lasts} s", line.text);
            assert!(
                sandbox.ca(&["log", "info", line.of("--log").unwrap()]).out.contains("/device/"),
                "`{}`",
                line.text
            );
        }
        "log" => says(&["rates", "device", "/device/", "/sound"]),
        "replay" => {
            says(&["identical  to the bit\n"]);
            if line.has("--energy") {
                says(&["not explained"]);
            }
        }
        verb => panic!("`{}`: nobody has said what `ca {verb}` of the README must do", line.text),
    }
}

/// Waits for a background device to end, and returns the largest force it received \[N\].
pub fn felt(sandbox: &Sandbox, line: &Line) -> f64 {
    assert_eq!([line.verb(), line.about()], ["device", "sim"], "`{}`: nobody has said what it must do", line.text);
    let into = line.into.as_deref().expect("its words go to a file");
    let begin = Instant::now();
    loop {
        let said = fs::read_to_string(sandbox.path(into)).unwrap();
        let largest = said.split("largest ").nth(1).and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
        if let Some(n) = largest {
            return n;
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "`{}` said\n{said}", line.text);
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Lowest frequency at which a model sounds \[Hz\].
fn lowest(sandbox: &Sandbox, model: &str) -> f64 {
    let found = sandbox.ca(&["modes", model, "--json"]).is(0).json();
    let heard = found["modes"].as_array().unwrap().iter().map(|m| m["heard_hz"].as_f64().unwrap());
    heard.filter(|f| *f > 1.0).fold(f64::INFINITY, f64::min)
}

/// Parses a pitch independently of the program \[Hz\].
fn pitch(text: &str) -> f64 {
    if let Some(hertz) = text.strip_suffix("Hz") {
        return hertz.trim().parse().unwrap();
    }
    let (name, octave) = text.split_at(text.find(|c: char| c.is_ascii_digit()).unwrap());
    let names = ["C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"];
    let step = names.iter().position(|n| *n == name).unwrap() as f64;
    440.0 * ((12.0 * (octave.parse::<f64>().unwrap() - 4.0) + step - 9.0) / 12.0).exp2()
}

/// Checks that a part changed its pitch to the requested one, to a hundredth of a cent.
fn tuned(sandbox: &Sandbox, line: &Line, before: &Files) {
    let (_, wanted) = line.words.iter().find_map(|w| w.split_once('=')).unwrap();
    let written = line.of("--write").unwrap();
    let cents = |file: &str| 1200.0 * (lowest(sandbox, file) / pitch(wanted)).log2();
    let (was, is) = (cents(line.about()), cents(written));
    assert!(was.abs() > 10.0, "`{}` changes nothing: it was {was} cents off", line.text);
    assert!(is.abs() < 0.01, "`{}`: {is} cents off", line.text);
    assert!(!before.contains_key(written) && fs::read(sandbox.path(line.about())).unwrap() == before[line.about()]);
}

/// Checks that sound was written and that each option has an effect.
fn rendered(sandbox: &Sandbox, line: &Line, before: &Files, ran: &RunOutput) {
    let file =
        line.of("-o").map_or_else(|| format!("{}.wav", line.about().trim_end_matches(".ca.toml")), str::to_owned);
    let (rate, channels, sound) = if Path::new(&file).extension().is_some_and(|e| e == "flac") {
        let ([rate, channels, _], sound) = sandbox.flac(&file);
        (rate, channels as usize, sound)
    } else {
        let (spec, sound) = sandbox.wav(&file);
        (spec.sample_rate, usize::from(spec.channels), sound)
    };
    let frames = sound.len() / channels;
    assert!(peak(&sound) > 1e-3 && peak(&sound) <= 1.0, "`{}`: a peak of {}", line.text, peak(&sound));
    if let Some(asked) = line.of("--rate") {
        let khz: f64 = asked.split(' ').next().unwrap().parse().unwrap();
        assert_eq!(f64::from(rate), 1000.0 * khz);
    }
    for option in ["--set", "--gesture"] {
        if let Some(value) = line.of(option) {
            let mut args: Vec<&str> =
                line.words.iter().map(String::as_str).filter(|w| ![option, value].contains(w)).collect();
            let o = args.iter().position(|w| *w == "-o").unwrap();
            args[o + 1] = "without.wav";
            sandbox.ca(&args).is(0);
            let without = sandbox.wav("without.wav").1;
            let apart = sound.iter().zip(&without).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart > 0.1 * peak(&sound), "`{}`: {option} changes the sound by {apart}", line.text);
            fs::remove_file(sandbox.path("without.wav")).unwrap();
        }
    }
    for probe in line.all("--probe") {
        let file = probe.split_once('=').map_or_else(|| format!("{probe}.npy"), |(_, f)| f.to_owned());
        assert!(!before.contains_key(&file), "`{}`: {file} was there", line.text);
        let values: Vec<f64> = if Path::new(&file).extension().is_some_and(|e| e == "csv") {
            let text = fs::read_to_string(sandbox.path(&file)).unwrap();
            let rows = text.lines().skip(1);
            rows.map(|l| l.rsplit(',').next().unwrap().parse().unwrap()).collect()
        } else {
            let bytes = fs::read(sandbox.path(&file)).unwrap();
            npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap()
        };
        assert_eq!(values.len(), frames, "`{}`: {file}", line.text);
        assert!(peak(&values) > 0.0 && values.iter().all(|v| v.is_finite()), "`{}`: {file}", line.text);
    }
    if line.has("--energy") {
        for word in ["energy     accounted for", "lost", "error", "stored"] {
            assert!(ran.out.contains(word), "`{}`: no `{word}` in\n{}", line.text, ran.out);
        }
    }
}

/// Checks that the scale was shown, or written to the requested file, as requested.
fn scaled(sandbox: &Sandbox, line: &Line, before: &Files, ran: &RunOutput) {
    let table = |file: &str| sandbox.ca(&["equiv", file, "--json"]).is(0).json();
    let number = |text: &str| text.trim().split(' ').next().unwrap().parse::<f64>().unwrap();
    if line.has("--in-place") {
        let (was, is) = (&before[line.about()], fs::read_to_string(sandbox.path(line.about())).unwrap());
        let was = std::str::from_utf8(was).unwrap();
        assert_ne!(was, is, "`{}` changes nothing", line.text);
        assert!(was.lines().filter(|l| l.contains('#')).all(|l| is.contains(l)), "`{}`: a comment is gone", line.text);
        let key = line.of("--key").unwrap();
        let keys = |file: &str| table(file)["keys"].clone();
        sandbox.put("was.ca.toml", was);
        assert_ne!(keys("was.ca.toml"), keys(line.about()), "`{}`: `{key}` is as it was", line.text);
        fs::remove_file(sandbox.path("was.ca.toml")).unwrap();
    } else if let Some(file) = line.of("--write") {
        let (row, pair) = line.of("--set").unwrap().split_once('=').unwrap();
        let (real, simulated) = pair.split_once(':').unwrap();
        let of = |t: &serde_json::Value| {
            let rows = t["rows"].as_array().unwrap();
            rows.iter().find(|r| r["name"] == row).unwrap()["factor"].as_f64().unwrap()
        };
        let (was, is, want) = (of(&table(line.about())), of(&table(file)), number(real) / number(simulated));
        assert!((was / want - 1.0).abs() > 0.01, "`{}` changes nothing", line.text);
        assert!((is / want - 1.0).abs() < 1e-9 && !before.contains_key(file), "`{}`: {is}", line.text);
    } else {
        for row in table(line.about())["rows"].as_array().unwrap() {
            let name = row["name"].as_str().unwrap();
            assert!(ran.out.contains(name), "`{}`: no `{name}` in\n{}", line.text, ran.out);
        }
    }
}
