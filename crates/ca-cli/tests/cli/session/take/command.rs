//! Tests `ca replay`, `ca log` and `ca render --gesture take.mcap`.

use super::performer::{DUO, Performer, duo};
use crate::sandbox::{Sandbox, peak};
use ca_haptic::engine::EngineCommand;
use ca_haptic::guard::Order;
use std::fs;

#[test]
fn a_replay_tells_and_sounds() {
    let sandbox = Sandbox::new();
    let p = duo(&sandbox.path("take.mcap"), 1600);
    sandbox.ca(&["replay", "take.mcap"]).is(0).says(&["identical  to the bit", "3200 force frames", "`Duo`"]);
    let j = sandbox.ca(&["replay", "take.mcap", "--verify", "--json", "-o", "again.wav"]).is(0).json();
    assert_eq!(
        (&j["identical"], &j["force_frames"], &j["samples"]),
        (&true.into(), &3200.into(), &p.sound.len().into())
    );
    let (spec, heard) = sandbox.wav("again.wav");
    assert_eq!((spec.sample_rate, spec.channels), (48_000, 2));
    assert!(heard.iter().zip(&p.sound).all(|(a, b)| *a == f64::from(*b as f32)) && heard.len() == p.sound.len());
    // a truncated take is identical up to its end
    let bytes = fs::read(sandbox.path("take.mcap")).unwrap();
    fs::write(sandbox.path("cut.mcap"), &bytes[..bytes.len() - 2000]).unwrap();
    sandbox.ca(&["replay", "cut.mcap", "--verify"]).is(0).says(&["identical", "cut off"]);
    sandbox.ca(&["replay", "no.mcap"]).is(1).says(&["`no.mcap`"]);
    sandbox.put("x.mcap", "hello").ca(&["replay", "x.mcap"]).is(1).says(&["not an MCAP file"]);
    sandbox.ca(&["replay", "take.mcap", "-o", "x.flac"]).is(2).says(&["`.wav`"]);
}

/// A ledger computed only in the replay changes no bit of the sound, and it balances with and without force feedback.
#[test]
fn a_replay_keeps_the_ledger_that_the_performance_did_not() {
    let mut takes = Vec::new();
    for more in [&[][..], &[("rate.border", "hold")], &[("rate.gesture", "48 kHz")], &[("rate.latency", "3")]] {
        for mute in [&[][..], &[("rate.feedback", "false")]] {
            takes.push((format!("duo{}", takes.len()), DUO.into(), [more, mute].concat()));
        }
    }
    for name in ["rattle", "hammer_piano", "hammered_string"] {
        let text = ca_lab::load::bundled(name).expect("bundled").to_owned();
        takes.push((name.into(), text, vec![("rate.feedback", "false")]));
    }
    let sandbox = Sandbox::new();
    for (name, text, changes) in takes {
        let file = format!("{name}.mcap");
        let mut p = Performer::of(&text, &changes, false, &sandbox.path(&file));
        p.frames(10);
        p.command(EngineCommand::Order(None, Order::Arm));
        p.frames(1500);
        p.finish();
        let r = sandbox.ca(&["replay", &file, "--verify", "--energy", "--json"]).is(0).json();
        assert_eq!((&r["identical"], &r["hashes"]), (&true.into(), &5.into()), "{name} {changes:?}: {r}");
        let [residual, peak] = ["residual", "peak"].map(|k| r["energy"][k].as_f64().unwrap());
        assert!(peak > 1e-9 && residual.abs() < 1e-9 * peak, "{name} {changes:?}: {residual} J of {peak} J");
    }
}

#[test]
fn a_replay_writes_over_nothing_it_should_not() {
    let sandbox = Sandbox::new();
    duo(&sandbox.path("take.mcap"), 100);
    fs::copy(sandbox.path("take.mcap"), sandbox.path("take.wav")).unwrap();
    let take = fs::read(sandbox.path("take.mcap")).unwrap();
    sandbox.put("duo.ca.toml", DUO);
    std::os::unix::fs::symlink("take.mcap", sandbox.path("link.wav")).unwrap();
    for to in ["take.mcap", "duo.ca.toml", "-"] {
        sandbox.ca(&["replay", "take.mcap", "-o", to]).is(2).says(&["`.wav`"]);
    }
    sandbox.ca(&["replay", "take.mcap", "-o", "link.wav"]).is(2).says(&["is the take and would be overwritten"]);
    sandbox.ca(&["replay", "take.wav", "-o", "./take.wav"]).is(2).says(&["is the take and would be overwritten"]);
    assert!(["take.mcap", "take.wav"].iter().all(|name| fs::read(sandbox.path(name)).unwrap() == take));
    assert_eq!(fs::read_to_string(sandbox.path("duo.ca.toml")).unwrap(), DUO);
}

#[test]
fn info_counts_what_is_there() {
    let sandbox = Sandbox::new();
    duo(&sandbox.path("take.mcap"), 1600);
    let words =
        ["/device/left/in", "ca_v1/msg/DeviceFrame", "foxglove.PointCloud", "SOFTWARE at 0.2", "bar.f = 231 Hz"];
    let r = sandbox.ca(&["log", "info", "take.mcap"]).is(0).says(&words);
    assert!(r.out.contains("attached   model/duo.ca.toml") && r.out.contains("layout/ca-foxglove.json"), "{}", r.out);
    let j = sandbox.ca(&["log", "info", "take.mcap", "--json"]).is(0).json();
    let topics = &j["topics"];
    assert_eq!(topics["/device/left/out"]["messages"], 1600);
    // the device skipped two frames
    assert_eq!(topics["/device/right/in"]["messages"], 1598);
    let rate = topics["/device/right/out"]["rate"].as_f64().unwrap();
    assert!((rate - 3000.0).abs() < 5.0, "{rate}");
    assert!((j["seconds"].as_f64().unwrap() - 1600.0 / 3000.0).abs() < 0.01);
    assert_eq!((&j["faults"][0]["cause"], &j["faults"][0]["device"]), (&"SOFTWARE".into(), &"left".into()));
    assert!(j["cut"].is_null() && j["lost"]["records"] == 0 && j["devices"].as_array().unwrap().len() == 2);
}

#[test]
fn what_was_cut_off_is_saved() {
    let sandbox = Sandbox::new();
    duo(&sandbox.path("take.mcap"), 1600);
    let bytes = fs::read(sandbox.path("take.mcap")).unwrap();
    fs::write(sandbox.path("cut.mcap"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    sandbox.ca(&["log", "info", "cut.mcap"]).is(0).says(&["cut off", "ca log recover cut.mcap"]);
    sandbox.ca(&["log", "recover", "cut.mcap"]).is(3).says(&["messages", "cut off", "quarter of a second"]);
    let r = sandbox.ca(&["log", "info", "cut.recovered.mcap"]).is(0);
    assert_eq!(r.err, "");
    sandbox.ca(&["replay", "cut.recovered.mcap", "--verify"]).is(0).says(&["identical"]);
    sandbox.ca(&["log", "recover", "cut.mcap"]).is(1).says(&["--force"]);
    sandbox.ca(&["log", "recover", "cut.mcap", "--force"]).is(3);
    sandbox.ca(&["log", "recover", "cut.mcap", "-o", "cut.mcap", "--force"]).is(2).says(&["overwritten"]);
    sandbox.ca(&["log", "recover", "take.mcap", "-o", "copy.mcap"]).is(0).says(&["was complete"]);
    assert_eq!(fs::read(sandbox.path("take.mcap")).unwrap(), bytes, "the take itself is left alone");
}

#[test]
fn parts_come_out_as_files() {
    let sandbox = Sandbox::new();
    let p = duo(&sandbox.path("take.mcap"), 1600);
    sandbox.ca(&["log", "export", "take.mcap", "sound", "-o", "s.wav"]).is(0);
    let (_, heard) = sandbox.wav("s.wav");
    assert!(heard.iter().zip(&p.sound).all(|(a, b)| *a == f64::from(*b as f32)) && heard.len() == p.sound.len());
    sandbox.ca(&["log", "export", "take.mcap", "model", "-o", "m.ca.toml"]).is(0).says(&["--set bar.f='231 Hz'"]);
    assert_eq!(fs::read_to_string(sandbox.path("m.ca.toml")).unwrap(), super::performer::DUO);
    sandbox.ca(&["log", "export", "take.mcap", "profile/left.toml", "-o", "p.toml"]).is(0);
    assert!(fs::read_to_string(sandbox.path("p.toml")).unwrap().contains("tgr12"));

    // CSV has a column per number, for existing degrees of freedom only; the rows of NPY are the frames themselves
    sandbox.ca(&["log", "export", "take.mcap", "/device/right/out", "-o", "f.csv"]).is(0).says(&["1600 messages"]);
    let csv = fs::read_to_string(sandbox.path("f.csv")).unwrap();
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    assert!(head.contains(&"force[2]") && !head.contains(&"force[3]") && head[0] == "time", "{head:?}");
    let column =
        |line: &str, name: &str| line.split(',').nth(head.iter().position(|h| *h == name).unwrap()).unwrap().to_owned();
    let last = csv.lines().last().unwrap();
    assert_eq!(
        (column(last, "seq"), column(last, "tick"), column(last, "device")),
        ("1600".into(), (1599 * 16).to_string(), "right".into())
    );
    sandbox.ca(&["log", "export", "take.mcap", "/device/right/out", "-o", "f.npy"]).is(0);
    let npy = fs::read(sandbox.path("f.npy")).unwrap();
    let frame = size_of::<ca_haptic::frame::ForceFrame>();
    assert_eq!(npy.len(), 1024 + 1600 * frame);
    let seq = npyz::NpyFile::new(&npy[..]).unwrap();
    assert_eq!(seq.shape(), [1600]);
    let at = npy.len() - frame;
    let force = f32::from_le_bytes(npy[at + 116..at + 120].try_into().unwrap());
    assert_eq!(force.to_string(), column(last, "force[1]"), "the same number in both");
    sandbox.ca(&["log", "export", "take.mcap", "/param", "-o", "p.csv"]).is(0).says(&["2 messages"]);
    assert!(fs::read_to_string(sandbox.path("p.csv")).unwrap().contains(",731,stiff\n"));
    sandbox.ca(&["log", "export", "take.mcap", "/param", "-o", "p.npy"]).is(2).says(&["`.csv`"]);
    sandbox.ca(&["log", "export", "take.mcap", "/scene", "-o", "s.csv"]).is(2).says(&["for viewers"]);
    sandbox.ca(&["log", "export", "take.mcap", "/no", "-o", "s.csv"]).is(2).says(&["no messages on topic `/no`"]);
    sandbox.ca(&["log", "export", "take.mcap", "/hash", "-o", "s.xls"]).is(2).says(&["`.csv` or `.npy`"]);
    sandbox.ca(&["log", "export", "take.mcap", "nothing", "-o", "n"]).is(2).says(&["no attachment `nothing`"]);
    sandbox.ca(&["log", "export", "take.mcap", "sound", "-o", "s.wav"]).is(1).says(&["--force"]);
    sandbox.ca(&["log", "export", "take.mcap", "sound", "-o", "take.mcap", "--force"]).is(2).says(&["overwritten"]);
}

#[test]
fn a_take_plays_another_model() {
    let sandbox = Sandbox::new();
    duo(&sandbox.path("take.mcap"), 3000);
    let other = "[TGR]\nkey = { x = \"-5 mm\" }\npad = {}\n[param]\nstiff = { value = 1, unit = \"N/m\", live = true, min = 0, max = 2000 }\n\
                 [CEL]\nbell = { m = \"2 g\", f = \"700 Hz\", t60 = \"1 s\" }\n\
                 [RES]\nr = { between = [\"key\", \"bell\"], k = \"stiff\" }\n[SOX]\nout = { from = \"bell\", gain = 500 }\n";
    sandbox.put("bell.ca.toml", &other.replace("pad = {}\n", "pad = { device = \"x\", dof = 1 }\n"));
    let r = sandbox.ca(&["render", "bell.ca.toml", "--gesture", "take.mcap", "--seconds", "1"]);
    assert_eq!(r.code, 0, "{}{}", r.out, r.err);
    assert!(peak(&sandbox.wav("bell.wav").1) > 0.01);
    sandbox
        .put("deaf.ca.toml", "[CEL]\nbar = { m = 1, f = 9, dx0 = 1 }\n[SOX]\nout = { from = \"bar\", gain = 0.1 }\n");
    sandbox
        .ca(&["render", "deaf.ca.toml", "--gesture", "take.mcap"])
        .is(2)
        .says(&["`key` is not a port or live parameter"]);
}

/// A limit on the file size simulates a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_is_reported_once_and_playing_goes_on() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "bar.ca.toml",
        "[CEL]\nbar = { m = 1, f = 443.1, dx0 = 1 }\n[SOX]\nout = { from = \"bar\", gain = 0.1 }\n",
    );
    // 200 kB hold about half a second of sound
    let r = sandbox.sh("ulimit -f 400; trap '' XFSZ; ca serve bar.ca.toml --seconds 3 --log take.mcap --json");
    assert_eq!(r.code, 3, "{}{}", r.out, r.err);
    let reported = r.err.lines().filter(|l| l.starts_with("warning: ") && l.contains("take.mcap")).count();
    assert_eq!(reported, 1, "{}", r.err);
    let j = r.json();
    assert_eq!((j["broken"].as_array().map(Vec::len), &j["faithful"]), (Some(1), &false.into()), "{}", r.out);
    assert!(j["seconds"].as_f64().is_some_and(|s| s > 2.9) && j["take"].is_null(), "{}", r.out);
    sandbox.ca(&["replay", "take.mcap", "--verify"]).is(0).says(&["identical", "cut off"]);
}
