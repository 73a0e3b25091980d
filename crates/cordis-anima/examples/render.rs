//! Renders a model file, or a small string, into a WAV file:
//! `cargo run -p cordis-anima --example render -- [MODEL.ca.toml [OUT.wav]]`

use cordis_anima::ca_io::format::Format;
use cordis_anima::ca_io::sound::WavOut;
use cordis_anima::{Error, Loaded, Options, render};

const STRING: &str = r#"
[STRING]
low = { n = 40, f = "110 Hz", t60 = "3 s", m = "1 g" }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[7]"], k = "20 kN/m", z = "0.5 N s/m" }
[SOX]
out = { from = "low[2]", gain = 300 }
"#;

fn play(model: Option<&str>, out: &str) -> Result<f64, Error> {
    let loaded = model.map_or_else(|| Ok(Loaded::read(STRING, "string.ca.toml")), Loaded::open)?;
    let scene = loaded.compile(&Options::default())?.scene;
    let sound = render(&scene, None)?;
    let mut wav = WavOut::create(out, sound.rate, sound.channels, Format::I24)?;
    wav.write(&sound.sound)?;
    Ok(wav.finish()?.level.peak.into_iter().fold(0.0, f64::max))
}

fn main() -> std::process::ExitCode {
    let mut args = std::env::args().skip(1);
    let (model, out) = (args.next(), args.next().unwrap_or_else(|| "out.wav".into()));
    match play(model.as_deref(), &out) {
        Ok(peak) => println!("{out}: peak {peak:.3}"),
        Err(e) => {
            eprintln!("{e}");
            return std::process::ExitCode::FAILURE;
        }
    }
    std::process::ExitCode::SUCCESS
}

#[test]
fn it_writes_a_sound() {
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("out.wav").to_string_lossy().into_owned();
    let peak = play(None, &out).expect("it plays");
    assert!((0.01..1.0).contains(&peak), "{peak}");
    let bytes = std::fs::metadata(&out).expect("a file").len();
    assert!(bytes > 3 * 48_000 * 3, "{bytes} bytes for three seconds of 24 bits");
    let scene = Loaded::read(STRING, "string.ca.toml").compile(&Options::default()).expect("it compiles").scene;
    for (seconds, why) in [(f64::NAN, "duration"), (-1.0, "duration"), (1e300, "memory")] {
        assert!(render(&scene, Some(seconds)).unwrap_err().to_string().contains(why), "{seconds}");
    }
    assert!(play(Some("no_such.ca.toml"), &out).unwrap_err().to_string().contains("no_such.ca.toml"));
}
