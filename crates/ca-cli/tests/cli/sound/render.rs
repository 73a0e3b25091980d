//! Tests `ca render`.

use crate::sandbox::{BAR, KEY, STRUCK, Sandbox, peak};
use crate::sound::divergence_and_clipping::UNSTABLE;
use std::fs;

#[test]
fn a_model_sounds_by_its_own_gesture() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let r = sandbox.ca(&["render", "struck.ca.toml"]).is(0);
    let r = r.says(&["struck.wav", "4.000 s", "48 kHz", "real-time factor", "dBFS", "first 0.5 s", "margin"]);
    assert_eq!(r.err, "");
    assert_eq!(sandbox.files(), ["struck.ca.toml", "struck.wav"]);
    let (spec, samples) = sandbox.wav("struck.wav");
    assert_eq!((spec.sample_rate, spec.channels, samples.len()), (48_000, 2, 2 * 192_000));
    assert!((0.1..=1.0).contains(&peak(&samples)));
    assert!(peak(&samples[..2 * 2400]) == 0.0 && peak(&samples[..2 * 24_000]) > 0.1);
    assert!(peak(&samples[2 * 70_000..2 * 72_000]) < 0.9 * peak(&samples[2 * 72_000..2 * 80_000]));
}

#[test]
fn the_same_bits_in_two_runs_and_with_either_kernel() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    for (file, more) in [("a.wav", &[][..]), ("b.wav", &["--energy"]), ("c.wav", &["--kernel", "reference"])] {
        sandbox.ca(&[&["render", "struck.ca.toml", "-o", file, "--seconds", "500 ms", "-q"], more].concat()).is(0);
    }
    sandbox.ca(&["render", "struck.ca.toml", "-o", "d.wav", "--seconds", "500 ms", "-q"]).is(0);
    let a = fs::read(sandbox.path("a.wav")).unwrap();
    assert!(peak(&sandbox.wav("a.wav").1) > 0.01);
    assert!(a == fs::read(sandbox.path("d.wav")).unwrap(), "two runs differ");
    assert!(a == fs::read(sandbox.path("b.wav")).unwrap(), "the ledger changes the sound");
    assert!(a == fs::read(sandbox.path("c.wav")).unwrap(), "the kernels differ");
}

#[test]
fn a_preset_is_chosen_and_changed_further() {
    let sandbox = Sandbox::new();
    let own = "[param]\nhard = { value = \"9 kN/m\", live = true }\n\
        soft = { value = 0.5, unit = \"N s/m\", live = true }\n[preset.felt]\nhard = \"2 kN/m\"\nsoft = 1\n\
        [CEL]\nbar = { m = \"2 g\", k = \"hard\", z = \"soft\", dx0 = \"1 mm\" }\n[SOX]\nout = { from = \"bar\", gain = 100 }\n";
    sandbox.put("own.ca.toml", own);
    let render = |file: &str, more: &[&str]| {
        sandbox.ca(&[&["render", "own.ca.toml", "--seconds", "0.1", "-q", "-o", file], more].concat()).is(0);
        fs::read(sandbox.path(file)).unwrap()
    };
    let as_written = render("a.wav", &[]);
    let felt = render("b.wav", &["--preset", "felt"]);
    assert!(felt != as_written);
    assert!(felt == render("c.wav", &["--set", "preset=felt"]));
    assert!(felt == render("d.wav", &["--set", "hard=2 kN/m", "--set", "soft=1"]));
    // what is set beside a preset counts
    let changed = render("e.wav", &["--set", "hard=9 kN/m", "--preset", "felt"]);
    assert!(changed != felt && changed == render("f.wav", &["--set", "soft=1"]));
    sandbox
        .ca(&["render", "own.ca.toml", "--preset", "fel"])
        .is(2)
        .says(&["--preset: `fel` is not a preset", "did you mean `felt`?"]);
    sandbox.put("struck.ca.toml", STRUCK);
    sandbox
        .ca(&["render", "struck.ca.toml", "--preset", "felt"])
        .is(2)
        .says(&["`felt` is not a preset", "`[preset.NAME]`"]);
}

#[test]
fn a_module_of_a_line_is_not_set_by_itself() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let r = sandbox.ca(&["render", "struck.ca.toml", "--set", "low[3].m=2 g"]).is(2);
    r.says(&["`low[3].m`: the modules of `low` share one line", "`low.m` sets it for all"]);
    let r = sandbox.ca(&["render", "struck.ca.toml", "--set", "low[3].colour=2"]).is(2);
    assert!(!r.err.contains("sets it for all"), "{}", r.err);
}

#[test]
fn threads_are_accepted_and_ignored() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let render = ["render", "struck.ca.toml", "--seconds", "500 ms", "-o"];
    sandbox.ca(&[&render[..], &["one.wav", "-q"]].concat()).is(0);
    sandbox.ca(&[&render[..], &["two.wav", "--threads", "2"]].concat()).is(0).says(&["`--threads` has no effect"]);
    let read = |file: &str| fs::read(sandbox.path(file)).unwrap();
    assert!(read("one.wav") == read("two.wav"));
}

#[test]
fn formats_hold_the_same_sound() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    for (format, bits, step) in [("f32", 32, 1e-7), ("24", 24, 2e-7), ("16", 16, 4e-5)] {
        let r = sandbox.ca(&["render", "bar.ca.toml", "--format", format, "-o", "x.wav", "--quiet"]).is(0);
        assert_eq!((r.out.as_str(), r.err.as_str()), ("", ""));
        let (spec, samples) = sandbox.wav("x.wav");
        assert_eq!((spec.bits_per_sample, samples.len()), (bits, 4800));
        assert!((samples[0] - 0.5).abs() < step, "{format}: {}", samples[0]);
    }
}

#[test]
fn parameters_and_rates_are_set() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    sandbox.put("bar.ca.toml", BAR);
    let of = |more: &[&str]| {
        sandbox.ca(&[&["render", "bar.ca.toml", "--quiet"], more].concat()).is(0);
        sandbox.wav("bar.wav")
    };
    let rising = |s: &[f64]| s.windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count();
    assert_eq!(rising(&of(&[]).1), 22);
    assert_eq!(rising(&of(&["--set", "bar.f=440 Hz"]).1), 44);
    assert!((of(&["--set", "loud=250", "--set", "bar.dx0=2 mm"]).1[0] - 0.5).abs() < 1e-7);
    let (spec, samples) = of(&["--rate", "96 kHz"]);
    assert_eq!((spec.sample_rate, samples.len(), rising(&samples)), (96_000, 9600, 22));
    assert_eq!(of(&["--rate", "44100"]).0.sample_rate, 44_100);
    assert_eq!(of(&["--seconds", "0.25"]).1.len(), 12_000);
    sandbox.ca(&["render", "bar.ca.toml", "--set", "bar.m=1 s"]).is(1).says(&["E008", "`m` of `bar`"]);
    // the model sets 3 kHz; the message names the nearest rate
    let r = sandbox.ca(&["render", "struck.ca.toml", "--rate", "44.1 kHz"]).is(1);
    assert!(r.err.contains("E020") && r.err.contains("45000 Hz"), "{}", r.err);
    sandbox.ca(&["render", "struck.ca.toml", "--rate", "44.1 kHz", "--set", "rate.gesture=2940 Hz", "-q"]).is(0);
}

#[test]
fn probes_are_readable() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let args = ["render", "struck.ca.toml", "--seconds", "1", "--probe", "low[*]", "--probe", "strike=blow.csv"];
    sandbox.ca(&[&args[..], &["--probe", "low@0.3", "--probe", "left", "-q"]].concat()).is(0);
    let npy = |name: &str| {
        let bytes = fs::read(sandbox.path(name)).unwrap();
        let n = npyz::NpyFile::new(&bytes[..]).unwrap();
        (n.shape().to_vec(), n.into_vec::<f64>().unwrap())
    };
    let (shape, all) = npy("low[all].npy");
    assert_eq!(shape, [48_000, 40]);
    let (shape, point) = npy("low@0.3.npy");
    assert_eq!(shape, [48_000]);
    // 41 intervals from end to end: 0.3 of the length is 12.3, between masses 11 and 12
    for n in [4000, 20_000] {
        let want = 0.7 * all[40 * n + 11] + 0.3 * all[40 * n + 12];
        assert!(want != 0.0 && (point[n] - want).abs() < 1e-9 * want.abs(), "{n}: {want} {}", point[n]);
    }
    // an output is probed without its gain
    let (_, left) = npy("left.npy");
    assert_eq!(left[20_000], all[40 * 20_000 + 3]);
    let csv = fs::read_to_string(sandbox.path("blow.csv")).unwrap();
    assert_eq!((csv.lines().next().unwrap(), csv.lines().count()), ("time,strike", 48_001));
    let force = csv.lines().skip(1).map(|l| l.split_once(',').unwrap().1.parse::<f64>().unwrap());
    assert!(force.fold(0.0, |m: f64, f| m.max(f.abs())) > 0.1);
}

#[test]
fn a_gesture_file_plays() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    sandbox.put("key.csv", KEY).put("still.csv", "time,key\n0,-0.003\n");
    sandbox.ca(&["render", "struck.ca.toml", "--gesture", "key.csv", "-q"]).is(0);
    assert!(peak(&sandbox.wav("struck.wav").1) > 0.1);
    sandbox
        .ca(&["render", "struck.ca.toml", "--gesture", "still.csv"])
        .is(0)
        .says(&["the sound is silent, because the motion of its gesture does", "`key`"]);
    assert_eq!(peak(&sandbox.wav("struck.wav").1), 0.0);
    sandbox.put("z.csv", "time,z\n0,1\n3.5,5\n5,5\n");
    let args = ["render", "struck.ca.toml", "--gesture", "key.csv", "--gesture", "z.csv"];
    sandbox.ca(&args).is(0).says(&["the gesture lasts 5.000 s"]);
    sandbox.put("twin.csv", KEY);
    let args = ["render", "struck.ca.toml", "--gesture", "key.csv", "--gesture", "twin.csv"];
    sandbox.ca(&args).is(1).says(&["two tracks"]);
}

#[test]
fn a_gesture_out_of_range_is_said() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "stiff.ca.toml",
        "[param]\nstiff = { value = \"1 kN/m\", live = true, min = \"0.5 kN/m\", max = \"2 kN/m\" }\n\
         [CEL]\nb = { m = \"1 g\", k = \"stiff\", dx0 = \"1 mm\" }\n[SOX]\nout = { from = \"b\" }\n",
    );
    let of = |text: &str| {
        sandbox.put("s.csv", text);
        sandbox.ca(&["render", "stiff.ca.toml", "--gesture", "s.csv", "--seconds", "0.1", "-q"]).is(0)
    };
    assert_eq!(of("time,stiff\n0,500\n0.1,2000\n").err, "");
    let ran = of("time,stiff\n0,1\n0.1,0.5\n").says(&["the gesture sets `stiff` to 1 N/m", "its minimum is 500 N/m"]);
    assert_eq!(ran.err.matches("`stiff`").count(), 1, "{}", ran.err);
    of("time,stiff\n0,1000\n0.1,3000\n").says(&["its maximum is 2 kN/m"]);
}

#[test]
fn a_nameless_track_is_given_to_a_port() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 1000,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let save = |name: &str, channels: u16| {
        let mut w = hound::WavWriter::create(sandbox.path(name), hound::WavSpec { channels, ..spec }).unwrap();
        let key = |i: i32| if (50..56).contains(&i) { -0.0005f32 } else { -0.003 };
        (0..200).flat_map(|i| vec![key(i); channels.into()]).for_each(|v| w.write_sample(v).unwrap());
        w.finalize().unwrap();
    };
    save("hand.wav", 1);
    save("hands.wav", 2);
    sandbox.ca(&["render", "struck.ca.toml", "--gesture", "key=hand.wav", "-q"]).is(0);
    assert!(peak(&sandbox.wav("struck.wav").1) > 0.1);
    sandbox
        .ca(&["render", "struck.ca.toml", "--gesture", "hand.wav"])
        .is(2)
        .says(&["its only track, `ch0`", "`--gesture key=FILE`"]);
    sandbox.ca(&["render", "struck.ca.toml", "--gesture", "key=hands.wav"]).is(2).says(&["2 tracks", "`ch1`"]);
    sandbox.ca(&["render", "struck.ca.toml", "--gesture", "hand.wav", "-o", "hand.wav"]).is(2).says(&["overwritten"]);
    sandbox
        .ca(&["render", "struck.ca.toml", "--gesture", "key=hand.wav", "-o", "hand.wav"])
        .is(2)
        .says(&["overwritten"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_behind() {
    use std::process::{Command, Stdio};
    use std::time::Duration;
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let mut child = Command::new(env!("CARGO_BIN_EXE_ca"))
        .args(["render", "bar.ca.toml", "--seconds", "20000", "--probe", "bar"])
        .current_dir(&sandbox.0)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // both files exist, so the handler is already set
    let stand = || {
        let parts = fs::read_dir(&sandbox.0).unwrap().map(|f| f.unwrap());
        parts.filter(|f| f.file_name().to_string_lossy().ends_with(".part")).count() == 2
    };
    while !stand() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was interrupted");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(said.contains("interrupted after") && said.contains("of 20000 s: none of it is kept"), "{said}");
    assert!(said.contains("`bar.wav` was not written"), "{said}");
    assert_eq!(sandbox.files(), ["bar.ca.toml"]);
}

#[test]
fn a_midi_file_plays_through_the_mapping_of_the_port() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    // one note, an eighth at 120 beats per minute
    let note = |velocity: u8| {
        let mut b = b"MThd\0\0\0\x06\0\0\0\x01\0\x60MTrk\0\0\0\x0c".to_vec();
        b.extend([0, 0x90, 60, velocity, 48, 0x80, 60, 0, 0, 0xff, 0x2f, 0]);
        fs::write(sandbox.path("note.mid"), b).unwrap();
        sandbox.ca(&["render", "struck.ca.toml", "--gesture", "note.mid", "--seconds", "1", "-q"]).is(0);
        peak(&sandbox.wav("struck.wav").1)
    };
    let (loud, silent) = (note(127), note(1));
    assert!(loud > 0.1 && silent == 0.0, "{loud} {silent}");
    sandbox
        .ca(&["render", "struck.ca.toml", "--gesture", "note.mid", "--gesture-rate", "100"])
        .is(2)
        .says(&["leave out"]);
}

#[test]
fn length_follows_the_gesture_where_nobody_says() {
    let sandbox = Sandbox::new();
    let bar = BAR.replace("seconds = \"100 ms\"", "");
    for (end, frames) in [(0.5, 144_000), (2.0, 192_000)] {
        let push = format!("[ENF]\np = {{ to = \"bar\" }}\n[gesture]\np = [[0, 0], [{end}, 0]]\n");
        sandbox.put("m.ca.toml", &(bar.clone() + &push)).ca(&["render", "m.ca.toml", "-q"]).is(0);
        assert_eq!(sandbox.wav("m.wav").1.len(), frames);
    }
}

#[test]
fn the_energy_ledger_is_shown() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let r = sandbox.ca(&["render", "struck.ca.toml", "--energy"]).is(0);
    r.says(&["received", "lost", "error", "stored", "of it by `strike`"]);
    let j = sandbox.ca(&["render", "struck.ca.toml", "--json"]).is(0).json();
    assert_eq!((j["energy"]["seconds"].as_f64(), j["energy"]["whole"].as_bool()), (Some(0.5), Some(false)));
    assert!(j["energy"]["relative_residual"].as_f64().unwrap() < 1e-10);
    assert!(j["real_time_factor"].as_f64().unwrap() > 0.0 && j["degraded"] == false);
    assert_eq!(j["channels"][1]["name"], "right");
}

/// A body thrown at the floor, loaded from a file beside the model.
const BODY: &str = r#"
[room]
dim = 3
[room.CLOUD]
bell = { file = "parts/bell.obj", scale = 0.1, m = "1 g", k = "8 kN/m", z = "2 mN s/m", v = [0, 0, "-1 m/s"] }
[room.SOL]
floor = { x = [0, 0, "-1 cm"] }
[room.BUT]
fall = { between = ["room.floor", "room.bell[*]"], k = "20 kN/m", along = "z" }
[SOF]
out = { from = "room.bell.link[0]", gain = 0.01 }
"#;

#[test]
fn a_body_is_read_from_the_folder_of_its_model() {
    let sandbox = Sandbox::new();
    fs::create_dir_all(sandbox.path("models/parts")).unwrap();
    sandbox.put("models/body.ca.toml", BODY);
    let r = sandbox.ca(&["check", "models/body.ca.toml"]).is(1);
    r.says(&["error[E031]: `file` of `room.bell`: `models/parts/bell.obj`: it cannot be read", "^ cannot be read"]);
    sandbox.put("models/parts/bell.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 9\n");
    let r = sandbox.ca(&["render", "models/body.ca.toml"]).is(1);
    r.says(&["`models/parts/bell.obj`, line 6: `9` is not the number of a point", "help: points are counted from 1"]);
    sandbox.put("models/parts/bell.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
    sandbox.ca(&["check", "models/body.ca.toml"]).is(0).says(&["5 MAT", "5 REF"]);
    let render = ["render", "models/body.ca.toml", "--seconds", "200 ms", "--energy", "-o", "body.wav", "-q"];
    sandbox
        .ca(&[&render[..], &["--probe", "room.bell[1..3]=two.csv", "--probe", "room.bell[0]=one.npy"]].concat())
        .is(0);
    assert!(peak(&sandbox.wav("body.wav").1) > 1e-3);
    let columns = "time,room.bell[1].x,room.bell[1].y,room.bell[1].z,room.bell[2].x,room.bell[2].y,room.bell[2].z";
    let csv = fs::read_to_string(sandbox.path("two.csv")).unwrap();
    assert_eq!(csv.lines().next(), Some(columns));
    assert_eq!(csv.lines().count(), 1 + 9600);
    assert!(fs::read(sandbox.path("one.npy")).unwrap().starts_with(b"\x93NUMPY"));
    let npy = String::from_utf8_lossy(&fs::read(sandbox.path("one.npy")).unwrap()[..100]).into_owned();
    assert!(npy.contains("'shape': (9600, 3)"), "{npy}");
}

#[test]
fn probes_of_several_are_called_by_their_modules() {
    let sandbox = Sandbox::new();
    let more = "[STRING]\nlow = { n = 5, f = 100, m = 1e-3 }\n[RES]\nnone = { between = [\"low[0]\", \"low[2]\"], k = 0 }\n\
                [SOX]\nout = { from = \"low[0]\" }\n[MAS]\nbob = { m = 1, v = 0.01 }\n[REF]\ntie = { between = [\"bob\", \"low[1]\"], k = 100 }\n";
    sandbox.put("low.ca.toml", more);
    let render = ["render", "low.ca.toml", "--seconds", "10 ms", "-q"];
    sandbox.ca(&[&render[..], &["--probe", "low[1..4]=a.csv", "--probe", "low[-1]=b.csv"]].concat()).is(0);
    let first = |file: &str| fs::read_to_string(sandbox.path(file)).unwrap().lines().next().unwrap().to_string();
    assert_eq!((first("a.csv"), first("b.csv")), ("time,low[1],low[2],low[3]".into(), "time,low[-1]".into()));
    let r = sandbox.ca(&[&render[..], &["--probe", "none"]].concat()).is(2);
    r.says(&["--probe: `none` has no effect, so it was left out of the scene; probe the modules at its ends"]);
    sandbox.ca(&[&render[..], &["--probe", "*"]].concat()).is(1).says(&["`*` is not a selector"]);
}

/// `-q` keeps the warnings about the model and omits its notes.
#[test]
fn quiet_is_not_silent_about_the_model() {
    let sandbox = Sandbox::new();
    sandbox.put("wild.ca.toml", UNSTABLE).put("bar.ca.toml", BAR);
    let codes = |text: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|l| l.strip_prefix("warning[")?.split(']').next());
        lines.map(str::to_owned).collect()
    };
    let known = sandbox.ca(&["check", "wild.ca.toml"]);
    let known = codes(&(known.out + &known.err));
    assert!(!known.is_empty());
    let r = sandbox.ca(&["render", "wild.ca.toml", "-q"]).is(3);
    assert_eq!((r.out.as_str(), codes(&r.err)), ("", known.clone()), "{}", r.err);
    let r = sandbox.ca(&["report", "wild.ca.toml", "-q", "--accuracy", "0"]).is(3);
    assert_eq!((r.out.as_str(), codes(&r.err)), ("", known), "{}", r.err);
    let r = sandbox.ca(&["render", "bar.ca.toml", "-q"]).is(0);
    assert_eq!((r.out.as_str(), r.err.as_str()), ("", ""));
}

/// Advice never suggests a rate beyond the allowed range.
#[test]
fn advice_can_be_followed() {
    let sandbox = Sandbox::new();
    for (k, faster) in [("20 MN/m", true), ("1e300 N/m", false)] {
        sandbox.put("wild.ca.toml", &UNSTABLE.replace("20 MN/m", k));
        let r = sandbox.ca(&["check", "wild.ca.toml"]);
        let said = r.out + &r.err;
        assert!(said.contains("make `bob` heavier") && !said.contains(", or \n"), "{said}");
        assert_eq!(said.contains("raise the sound rate"), faster, "{said}");
    }
}
