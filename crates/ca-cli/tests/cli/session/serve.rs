//! Tests `ca serve` and requests to it while it runs.

use crate::sandbox::Sandbox;
use std::process::Child;
use std::time::{Duration, Instant};

const MODEL: &str = r#"
[param]
k = { value = 500, unit = "N/m", live = true, min = 0, max = 1000 }
z = { value = 0.001, unit = "N s/m", live = true, min = 0, max = 1 }
[preset.soft]
k = "300 N/m"
[TGR]
key = { device = "tgr12", dof = 0 }
[MAS]
bob = { m = "10 g", dx0 = "1 mm" }
[SOL]
wall = {}
[REF]
spring = { between = ["key", "bob"], k = "k", z = "z" }
string = { between = ["wall", "bob"], k = 20000, z = 0.1 }
[SOX]
out = { from = "bob", gain = 100 }
"#;

/// A process that is killed on drop.
struct Server(Option<Child>);

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Starts a server and waits until it answers.
fn serve(sandbox: &Sandbox, args: &[&str]) -> Server {
    sandbox.put("key.ca.toml", MODEL);
    let mut server = Server(Some(sandbox.start(&[&["serve", "key.ca.toml"], args].concat())));
    let begin = Instant::now();
    while sandbox.ca(&["status"]).code != 0 {
        assert!(server.0.as_mut().unwrap().try_wait().unwrap().is_none(), "it ended");
        assert!(begin.elapsed().as_secs() < 60, "it does not answer");
        std::thread::sleep(Duration::from_millis(20));
    }
    server
}

fn ended(mut server: Server) -> (i32, String, String) {
    let o = server.0.take().unwrap().wait_with_output().unwrap();
    let text = |b: Vec<u8>| String::from_utf8(b).unwrap();
    (o.status.code().unwrap(), text(o.stdout), text(o.stderr))
}

#[test]
fn the_examples_of_the_control_run_against_a_server() {
    let sandbox = Sandbox::new();
    let server = serve(&sandbox, &["--json", "-o", "played.wav", "--log", "take.mcap", "--energy"]);
    for command in ["set", "audio", "arm", "disarm", "status"] {
        let help = sandbox.ca(&[command, "--help"]).is(0).out;
        let (_, examples) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("{command} has no examples"));
        for line in examples.lines().filter(|l| !l.trim().is_empty() && !l.contains("ca stop")) {
            sandbox.sh(line).is(0);
        }
    }
    let all = ["k = 900 N/m (0 to 1000)", "z = 0.5 N s/m (0 to 1)", "presets: soft"];
    sandbox.ca(&["set"]).is(0).says(&all);
    sandbox.ca(&["set", "preset=sof"]).is(1).says(&["`sof` is not a preset", "did you mean `soft`?"]);
    sandbox.ca(&["set", "k=800", "zz=1"]).is(1).says(&["`zz`", "live = true"]);
    sandbox.ca(&["set", "k=800", "z=7"]).is(1).says(&["`z` must lie between 0 and 1"]);
    sandbox.ca(&["set", "k=3 kg"]).is(1).says(&["`k` must be in N/m, not in kg"]);
    sandbox.ca(&["arm", "tgr"]).is(1).says(&["no device `tgr`", "`tgr12`"]);
    sandbox.ca(&["set"]).is(0).says(&["k = 900 N/m"]);
    let status = sandbox.ca(&["status", "--json"]).is(0).json();
    assert!(status["fields"]["frames"].as_u64().unwrap() > 0);
    assert_eq!(status["fields"]["devices"][0]["device"], "tgr12");
    assert_eq!(status["fields"]["params"][0]["value"], 900.0);

    // a second server is refused, and the message names the first
    let args = ["serve", "key.ca.toml", "--seconds", "1", "-o", "second.wav", "--log", "second.mcap"];
    sandbox.ca(&args).is(1).says(&["a server is already running at"]);
    sandbox.put("older.mcap", "a take");
    sandbox.ca(&["serve", "key.ca.toml", "--seconds", "1", "--log", "older.mcap"]).is(1).says(&["never overwritten"]);
    assert_eq!(std::fs::read(sandbox.path("older.mcap")).unwrap(), b"a take");
    let half: Vec<_> = sandbox.files().into_iter().filter(|f| f.contains("second")).collect();
    assert!(half.is_empty(), "a server that never ran leaves {half:?}");

    sandbox.ca(&["stop"]).is(0);
    let (code, out, err) = ended(server);
    let reported: serde_json::Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}\n{out}\n{err}"));
    assert_eq!(code, if reported["faithful"] == true { 0 } else { 3 }, "{err}");
    assert_eq!((reported["lost_sound"].as_u64(), reported["clipped"].as_u64()), (Some(0), Some(0)));
    assert_eq!(reported["granted"][0][0], "engine");
    assert!(reported["granted"][0][1].as_str().unwrap().starts_with("policy "), "{out}");
    for times in ["frame_us", "late_us"] {
        let t = &reported[times];
        assert!(t["n"].as_u64().unwrap() > 0 && t["p50"].as_f64().unwrap() <= t["max"].as_f64().unwrap());
    }
    let (spec, samples) = sandbox.wav("played.wav");
    assert_eq!((spec.channels, spec.sample_rate), (1, 48000));
    let seconds = reported["seconds"].as_f64().unwrap();
    assert!((samples.len() as f64 / 48000.0 - seconds).abs() < 1e-3, "{} of {seconds}", samples.len());
    assert!(crate::sandbox::peak(&samples) > 0.01);
    sandbox.ca(&["status"]).is(1).says(&["no server is running", "ca serve"]);

    // the replay reproduces forces, sound and state, including changes during the run
    assert_eq!(reported["take"]["lost"], 0);
    let again = sandbox.ca(&["replay", "take.mcap", "--verify", "--json", "-o", "again.wav"]).is(0).json();
    assert_eq!(again["identical"], true, "{again}");
    assert_eq!(sandbox.wav("again.wav").1, samples);
    sandbox.ca(&["log", "info", "take.mcap"]).is(0).says(&["/param", "/device/tgr12/out"]);
}

#[test]
fn what_cannot_be_served_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", MODEL);
    for (args, word) in [
        (&["--profile", "tgr21"][..], "did you mean `tgr12`?"),
        (&["--profile", "tgr=falcon"], "the model does not use a device `tgr`"),
        (&["--priority", "100"], "99"),
        (&["-o", "x.flac", "--seconds", "1"], ".wav"),
    ] {
        sandbox.ca(&[&["serve", "key.ca.toml"], args].concat()).is(2).says(&[word]);
    }
    sandbox.put("bad.toml", "name = \"x\"\ntitle = \"x\"\nsource = \"x\"\ndof = 1\nrange = [1, 0]\nforce = 1\n");
    sandbox.ca(&["serve", "key.ca.toml", "--profile", "bad.toml"]).is(1).says(&["bad.toml", "`range`"]);
    sandbox.put("cal.toml", "[[axis]]\nscale = 0\n");
    sandbox.ca(&["serve", "key.ca.toml", "--calibration", "tgr12=cal.toml"]).is(1).says(&["cal.toml", "axis 0"]);
    assert_eq!(sandbox.files(), ["bad.toml", "cal.toml", "key.ca.toml"]);
}

/// With the clock of an absent device, the time still passes, and only few frames are made.
#[test]
fn a_device_that_never_comes_ends_with_the_seconds() {
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", MODEL);
    let r = sandbox.ca(&["serve", "key.ca.toml", "--clock", "device", "--seconds", "0.5", "--json"]).is(0).json();
    let [frames, missed] = ["frames", "missed"].map(|k| r[k].as_u64().unwrap());
    // 1500 periods: one frame per tenth of a second, and one that reports that forces are off
    assert!(frames + missed >= 1500, "{frames} frames, {missed} periods left out");
    assert!(frames <= 6, "{frames} frames");
}

/// A scene without devices and live parameters uses neither shared memory nor a thread besides the engine.
#[cfg(target_os = "linux")]
#[test]
fn a_scene_without_devices_opens_nothing() {
    let sandbox = Sandbox::new();
    sandbox.put("mute.ca.toml", "[CEL]\nbar = { m = 1, f = 100, dx0 = 0.001 }\n[SOX]\nout = { from = \"bar\" }\n");
    let server = Server(Some(sandbox.start(&["serve", "mute.ca.toml", "--no-lock", "--priority", "0"])));
    let pid = server.0.as_ref().unwrap().id();
    let tasks = |pid: u32| {
        let names = std::fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
        names.filter_map(|t| std::fs::read_to_string(t.path().join("comm")).ok()).collect::<Vec<String>>()
    };
    let begin = Instant::now();
    while !tasks(pid).iter().any(|t| t.trim() == "ca engine") {
        assert!(begin.elapsed().as_secs() < 60, "{:?}", tasks(pid));
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(100));
    let threads = tasks(pid);
    let maps = std::fs::read_to_string(format!("/proc/{pid}/maps")).unwrap();
    assert!(!threads.iter().any(|t| t.contains("gateway")), "{threads:?}");
    // the command itself, the engine, and the thread that waits for Ctrl-C
    assert!(threads.len() <= 3, "{threads:?}");
    assert!(!maps.contains("/dev/shm") && !maps.contains("iox2"), "{maps}");
    assert!(!sandbox.shm().exists());
}

#[test]
fn a_sound_device_needs_sound_and_is_the_only_clock() {
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", MODEL).put("mute.ca.toml", "[CEL]\nbar = { m = 1, f = 9, dx0 = 1 }\n");
    sandbox.ca(&["serve", "mute.ca.toml", "--audio", "jack"]).is(2).says(&["no output"]);
    sandbox.ca(&["serve", "key.ca.toml", "--audio", "jack", "--clock", "device"]).is(2).says(&["--clock"]);
    sandbox.ca(&["serve", "key.ca.toml", "--audio-buffer", "64"]).is(2).says(&["--audio"]);
    sandbox.ca(&["serve", "key.ca.toml", "--audio=jack", "--audio-buffer", "0"]).is(2).says(&["--audio-buffer"]);
}

#[cfg(not(feature = "audio"))]
#[test]
fn a_build_without_sound_devices_says_how_to_get_them() {
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", MODEL);
    for args in [&["--audio"][..], &["--audio", "organ", "--audio-buffer", "64"]] {
        let args = [&["serve", "key.ca.toml", "-o", "key.wav"], args].concat();
        sandbox.ca(&args).is(1).says(&["sound devices, build it with", "--features audio", "libasound2-dev"]);
    }
    assert_eq!(sandbox.files(), ["key.ca.toml"]);
}

/// Two outputs to one file would lose one of them, and an overwritten input is lost.
#[test]
fn outputs_have_files_of_their_own() {
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", MODEL).put("x.csv", "time,x\n0,0\n1,0.001\n").put("own.toml", "name = 1\n");
    std::os::unix::fs::symlink("xx.wav", sandbox.path("link.mcap")).unwrap();
    std::os::unix::fs::symlink("key.ca.toml", sandbox.path("key.wav")).unwrap();
    let before = sandbox.files();
    for command in ["serve", "play"] {
        for log in ["xx.wav", "./xx.wav", "link.mcap"] {
            let line = [command, "key.ca.toml", "--seconds", "0.1", "-o", "xx.wav", "--log", log];
            sandbox.ca(&line).is(2).says(&["would be written twice, by `-o` and `--log`"]);
        }
        sandbox.ca(&[command, "key.ca.toml", "--seconds", "0.1", "-o", "key.wav"]).is(2).says(&["is the model"]);
    }
    sandbox.ca(&["render", "key.ca.toml", "-o", "key.wav"]).is(2).says(&["is the model"]);
    let sim = ["device", "sim", "--seconds", "0.1", "--force-log"];
    sandbox
        .ca(&[&sim[..], &["x.csv", "--script", "file", "--gesture", "x.csv"]].concat())
        .is(2)
        .says(&["is the gesture"]);
    sandbox.ca(&[&sim[..], &["own.toml", "--profile", "./own.toml"]].concat()).is(2).says(&["is the profile"]);
    assert_eq!(sandbox.files(), before);
    assert!(std::fs::read_to_string(sandbox.path("x.csv")).unwrap().starts_with("time"));
    sandbox.ca(&["device", "sim", "--wait", "--script", "push"]).is(2).says(&["--wait", "pushes all the time"]);
}

/// A Standard MIDI File is not a raw stream. Times can also be given in minutes.
#[test]
fn what_is_not_raw_midi_says_what_plays_it() {
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", MODEL).put("tune.mid", "MThd....");
    let line = ["serve", "key.ca.toml", "--seconds", "0.1", "--midi", "tune.mid"];
    sandbox.ca(&line).is(2).says(&["Standard MIDI File", "--gesture tune.mid"]);
    sandbox.ca(&["render", "no.ca.toml", "--seconds", "1 min"]).is(2).says(&["no such file"]);
    sandbox.ca(&["render", "no.ca.toml", "--seconds", "1441 min"]).is(2).says(&["86400 s"]);
}
