//! Tests `ca fit`: its output, the written files, and third-party recordings.

use crate::sandbox::{Sandbox, blocks, from_root};
use crate::skipped::skipped;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// A model with comments and units to be kept.
const MINE: &str = r#"# mine
[param]
weight = { value = 12, unit = "g", min = 1, max = 90 }   # of the hammer
[STRING]
low = { n = 24, f = "110 Hz", t60 = "2 s", m = "1 g" }   # by frequency
[MAS]
hammer = { m = "weight", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[5]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[3]", gain = 400 }
"#;

#[test]
fn a_model_is_fitted_and_written_with_its_comments() {
    let sandbox = Sandbox::new();
    sandbox.put("mine.ca.toml", MINE);
    let render = ["--seconds", "0.5", "--no-fade", "-q", "--set", "low.f=112.3 Hz", "--set", "weight=20"];
    sandbox.ca(&[&["render", "mine.ca.toml", "-o", "t.wav"][..], &render].concat()).is(0);
    let fit = ["fit", "mine.ca.toml", "--to", "t.wav", "--vary", "low.f,weight"];
    let more = ["--seconds", "0.3", "--write", "found.ca.toml", "--report", "fit.html", "--json"];
    let ran = sandbox.ca(&[&fit[..], &more].concat()).is(0);
    let printed = ran.json();
    let value = |k: usize| printed["parameters"][k]["value"].as_f64().unwrap();
    assert!((value(0) / 112.3 - 1.0).abs() < 5e-5, "{printed:#}");
    assert!((value(1) / 0.02 - 1.0).abs() < 0.02, "{printed:#}");
    assert!(printed["renders"].as_u64().unwrap() < 60 && printed["beyond"]["count"] == 1, "{printed:#}");
    assert!(printed["after"]["levels_db"].as_f64() < printed["before"]["levels_db"].as_f64());
    assert!(["settled", "explained", "nearer"].iter().all(|key| printed[key] == true), "{printed:#}");
    assert!(printed["parameters"][0]["deviation"].as_f64().unwrap() < 0.01, "{printed:#}");
    let text = fs::read_to_string(sandbox.path("found.ca.toml")).unwrap();
    for kept in ["# mine", "unit = \"g\", min = 1, max = 90 }   # of the hammer", "# by frequency", "m = \"weight\""] {
        assert!(text.contains(kept), "{kept}\n{text}");
    }
    assert!(text.contains("f = \"112.3") && text.contains(" Hz\"") && text.contains("value = "), "{text}");
    let page = fs::read_to_string(sandbox.path("fit.html")).unwrap();
    assert!(page.contains("Before and after") && page.contains("low.f"));
    // the written model sounds like the target
    sandbox.ca(&["render", "found.ca.toml", "-o", "f.wav", "--seconds", "0.5", "--no-fade", "-q"]).is(0);
    let (a, b) = (sandbox.wav("t.wav").1, sandbox.wav("f.wav").1);
    let left: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum();
    assert!(left < 1e-4 * a.iter().map(|a| a * a).sum::<f64>(), "{left}");
    sandbox.ca(&fit).is(0).says(&["low.f: 110 Hz → 112.3", "±", "renders", "before:", "after:"]);
}

#[test]
fn what_cannot_be_fitted_gets_an_answer() {
    let sandbox = Sandbox::new();
    sandbox.put("mine.ca.toml", MINE);
    sandbox.put("mute.ca.toml", "[CEL]\nbar = { m = 1, f = 9, dx0 = 1 }\n").put("not.wav", "mine");
    sandbox.ca(&["render", "mine.ca.toml", "-o", "t.wav", "--seconds", "0.1", "-q"]).is(0);
    for (args, code, word) in [
        (&["mine.ca.toml", "--to", "t.wav"][..], 2, "--vary"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "lwo.f"], 2, "did you mean `low.f`?"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.n"], 2, "not a single number"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "hammer.m"], 2, "vary `weight`"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--range", "low.f=9"], 2, "one end"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--range", "low.f=9..90"], 2, "starts at 110 Hz"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--range", "low.m=9..90"], 2, "is not varied"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--renders", "2"], 2, "too few"),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--report", "x.pdf"], 2, "`.html`"),
        (
            &["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--range", "low.f=90 kg..130 kg"],
            1,
            "in Hz, not in kg",
        ),
        (&["mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--range", "low.f=90..130 s"], 1, "E008"),
        // refused before the fit, since the recording does not exist
        (&["mine.ca.toml", "--to", "no.wav", "--vary", "low.f", "--write", "x.toml"], 2, "ends in `.ca.toml`"),
        (&["mine.ca.toml", "--to", "no.wav", "--vary", "low.f", "--write", "mute.ca.toml"], 1, "use `--force`"),
        (&["mine.ca.toml", "--to", "no.wav", "--vary", "low.f", "--write", "no/x.ca.toml"], 1, "no such directory"),
        (&["mine.ca.toml", "--to", "t.mp3", "--vary", "low.f"], 2, "WAV"),
        (&["mine.ca.toml", "--to", "no.wav", "--vary", "low.f"], 1, "`no.wav`"),
        (&["mine.ca.toml", "--to", "not.wav", "--vary", "low.f"], 1, "not a WAV file"),
        (&["hammered_string", "--to", "t.wav", "--vary", "low.f", "--in-place"], 2, "cannot be changed in place"),
        (&["mute.ca.toml", "--to", "t.wav", "--vary", "bar.f"], 1, "no output"),
    ] {
        sandbox.ca(&[&["fit"], args].concat()).is(code).says(&[word]);
    }
    assert_eq!(sandbox.files(), ["mine.ca.toml", "mute.ca.toml", "not.wav", "t.wav"]);
}

/// A varied number may start from `--set` and is written, even into the model file itself.
#[test]
fn what_is_set_and_varied_is_written() {
    let sandbox = Sandbox::new();
    sandbox.put("mine.ca.toml", MINE);
    let render = ["--seconds", "0.3", "--no-fade", "-q", "--set", "low.f=112.3 Hz"];
    sandbox.ca(&[&["render", "mine.ca.toml", "-o", "t.wav"][..], &render].concat()).is(0);
    let fit = ["fit", "mine.ca.toml", "--to", "t.wav", "--vary", "low.f", "--set", "low.f=114 Hz", "--in-place"];
    let other = [&fit[..], &["--set", "weight=20"]].concat();
    sandbox
        .ca(&other)
        .is(2)
        .says(&["`--set weight` changes a number that is not varied", "add the number to `--vary`"]);
    sandbox.ca(&fit).is(0).says(&["low.f: 114 Hz → 112.3"]);
    let text = fs::read_to_string(sandbox.path("mine.ca.toml")).unwrap();
    assert!(text.contains("f = \"112.3") && text.contains("value = 12,"), "{text}");
}

/// A search that ends too early prints no deviation and gives advice.
#[test]
fn a_search_that_is_cut_short_has_no_deviations() {
    let sandbox = Sandbox::new();
    sandbox.put("mine.ca.toml", MINE);
    let render = ["--seconds", "0.3", "--no-fade", "-q", "--set", "low.f=115 Hz", "--set", "weight=20"];
    sandbox.ca(&[&["render", "mine.ca.toml", "-o", "t.wav"][..], &render].concat()).is(0);
    let fit = ["fit", "mine.ca.toml", "--to", "t.wav", "--vary", "low.f,weight", "--renders", "8"];
    let ran = sandbox.ca(&fit).is(0).says(&["did not converge within", "`--renders`", "uncertainty unknown"]);
    assert!(!ran.out.contains('±'), "{}", ran.out);
    let printed = sandbox.ca(&[&fit[..], &["--json"]].concat()).is(0).json();
    assert_eq!(
        (&printed["settled"], &printed["parameters"][0]["deviation"]),
        (&false.into(), &serde_json::Value::Null)
    );
}

/// A sound that no string produces: no deviations are printed, and nothing is written without improvement.
#[test]
fn a_sound_that_is_no_such_instrument_is_not_explained() {
    let sandbox = Sandbox::new();
    sandbox.put("mine.ca.toml", MINE);
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 48_000,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let mut wav = hound::WavWriter::create(sandbox.path("constant.wav"), spec).unwrap();
    (0..14_400).for_each(|_| wav.write_sample(0.5_f32).unwrap());
    wav.finalize().unwrap();
    let fit = ["fit", "mine.ca.toml", "--to", "constant.wav", "--vary", "low.f,weight", "--in-place"];
    let ran = sandbox.ca(&fit).is(3).says(&["does not explain this sound", "closer to the", "nothing is written"]);
    assert!(!ran.out.contains('±'), "{}", ran.out);
    assert_eq!(fs::read_to_string(sandbox.path("mine.ca.toml")).unwrap(), MINE);
}

#[cfg(unix)]
#[test]
fn the_commands_of_the_page_run() {
    let page = fs::read_to_string(from_root("docs/fit.md")).unwrap();
    let sandbox = Sandbox::new();
    let lines: Vec<&str> = blocks(&page, "sh").into_iter().flat_map(|(_, b)| b.lines()).collect();
    assert!(lines.len() >= 2);
    for line in lines {
        sandbox.sh(line).is(0);
    }
    assert_eq!(sandbox.files(), ["fit.html", "target.wav"]);
}

/// A plucked guitar: a string with six numbers including gain and delay, compared with two damped sinusoids of four
/// each.
fn guitar(hertz: f64) -> String {
    format!(
        r#"
[STIFFSTRING]
low = {{ n = 60, f = "{hertz} Hz", b = 1e-4, t60 = "12 s", z = "0.1 mN s/m", m = "0.1 g" }}
[ENF]
pull = {{ to = "low[12]" }}
[SOX]
out = {{ from = "low[0]", gain = 100 }}
[gesture]
pull = [[0, 0], [0.05, "1 N"], [0.0501, 0]]
"#
    )
}

/// Recordings of two guitars from a third-party package with an MIT licence. The project does not store them.
fn recordings() -> Option<PathBuf> {
    let made = Command::new("bash").arg(from_root("tests/python/recordings")).stderr(Stdio::piped()).output().ok()?;
    if !made.status.success() {
        skipped("recording", &format!("no recording: {}", String::from_utf8_lossy(&made.stderr)));
        return None;
    }
    Some(PathBuf::from(String::from_utf8(made.stdout).ok()?.trim()))
}

/// The model predicts two seconds outside the fit better than sinusoids with as many numbers. This holds for the
/// levels, as for eleven of the twelve recorded strings, and for one string also for the samples. It fails for the
/// samples of the others: the guitar body sets the phases of their strongest partials, and this string does not model
/// it (docs/fit.md has all twelve).
#[test]
fn a_recorded_guitar_is_explained_by_a_string() {
    let Some(folder) = recordings() else { return };
    for (name, hertz, heard, phases) in [
        ("Carbon_Guitar/Carbon_E1.wav", 329.6, 328.8, true),
        ("Wood_Guitar/Wood_A5.wav", 110.0, 109.7, false),
        ("Carbon_Guitar/Carbon_E6.wav", 82.4, 82.5, false),
    ] {
        let sandbox = Sandbox::new();
        sandbox.put("guitar.ca.toml", &guitar(hertz));
        let wav = folder.join(name);
        let fit = ["fit", "guitar.ca.toml", "--to", wav.to_str().unwrap(), "--vary", "low.f,low.b,low.t60,low.z"];
        let printed = sandbox.ca(&[&fit[..], &["--seconds", "1", "--json"]].concat()).is(0).json();
        println!("{name}: {printed:#}");
        let b = &printed["beyond"];
        let of = |who: &str, what: &str| b[who][what].as_f64().unwrap();
        assert!(b["seconds"].as_f64().unwrap() > 1.9 && b["count"] == 2 && printed["renders"].as_u64().unwrap() <= 60);
        assert!(of("model", "levels_db") < 0.7 * of("sinusoids", "levels_db"), "{name}: {b:#}");
        if phases {
            assert!(of("model", "samples_db") < of("sinusoids", "samples_db") - 2.0, "{name}: {b:#}");
            assert!(of("model", "samples_db") < -1.0, "{name}: {b:#}");
        }
        // stretched partials make the pitch higher than `f`
        let f = printed["pitch"]["found_hz"].as_f64().unwrap();
        assert!((1200.0 * (f / heard).log2()).abs() < 5.0, "{name}: {f} Hz");
    }
}
