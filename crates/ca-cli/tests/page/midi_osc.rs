//! Tests MIDI by a pipe, OSC by UDP, and MIDI from a page: effects are seen, errors are answered, and a take records
//! all of it.

use crate::host::{Client, Host, peak, until};
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, decoder, encoder};
use serde_json::json;
use std::io::Write as _;
use std::net::UdpSocket;
use std::process::Command;
use std::time::Duration;

const KEYS: &str = r#"
[param]
k = { value = "2 kN/m", unit = "N/m", live = true, min = 1000, max = 3000 }
z = { value = "0.2 N s/m", unit = "N s/m", live = true, min = 0.1, max = 0.3 }
loose = { value = "0.5 N s/m", unit = "N s/m", live = true }
[STRING]
low = { n = 30, f = "110 Hz", t60 = "3 s", m = "1 g" }
[MAS]
bob = { m = "10 g" }
hammer = { m = "5 g", x = "-8 mm" }
[SOL]
wall = {}
[REF]
spring = { between = ["wall", "bob"], k = "k", z = "z" }
shank = { between = ["key", "hammer"], k = 500, z = "loose" }
[ENF]
push = { to = "low[4]", midi = { note = ["C4", "E4"], to = "0.5 N", attack = "1 ms", release = "1 ms" } }
bend = { to = "bob", midi = { bend = true, from = "-1 N", to = "1 N" } }
[TGR]
key = { device = "keys", dof = 0, x = "-8 mm", midi = { note = "F4", from = "-8 mm", to = "-1 mm" } }
[SOX]
left = { from = "low[6]", gain = 200 }
right = { from = "bob", gain = 200 }
third = { from = "hammer", gain = 100 }
"#;

/// Token required to play a model with devices.
const TOKEN: &str = "0123456789abcdef";

fn osc(addr: &str, args: Vec<OscType>) -> OscPacket {
    OscPacket::Message(OscMessage { addr: format!("/{TOKEN}{addr}"), args })
}

fn text(s: &str) -> OscType {
    OscType::String(s.into())
}

struct Line(UdpSocket);

impl Line {
    fn say(&self, packet: &OscPacket) {
        self.0.send(&encoder::encode(packet).unwrap()).unwrap();
    }

    fn reply(&self) -> (String, Vec<OscType>) {
        let mut bytes = [0; 4096];
        let n = self.0.recv(&mut bytes).unwrap();
        let OscPacket::Message(m) = decoder::decode_udp(&bytes[..n]).unwrap().1 else { panic!("a bundle") };
        (m.addr, m.args)
    }

    /// Sends a packet that is refused and returns the reason.
    fn refused(&self, packet: &OscPacket) -> String {
        self.say(packet);
        let (addr, args) = self.reply();
        assert_eq!(addr, "/error", "{args:?}");
        format!("{args:?}")
    }
}

#[track_caller]
fn param(page: &mut Client, name: &str, value: f64) {
    until(name, || page.next("state")["params"][name].as_f64().is_some_and(|v| (v - value).abs() < 1e-9 * value));
}

pub fn plays() {
    let dir = tempfile::tempdir().unwrap();
    let pipe = dir.path().join("midi");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let line = Line(UdpSocket::bind("127.0.0.1:0").unwrap());
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let token = dir.path().join("token");
    std::fs::write(&token, TOKEN).unwrap();
    std::fs::set_permissions(&token, std::os::unix::fs::PermissionsExt::from_mode(0o600)).unwrap();
    let [pipe_at, token, at] = [pipe.display().to_string(), token.display().to_string(), port.to_string()];
    let args = ["--log", "take.mcap", "--midi", &pipe_at, "--osc", &at, "--osc-token", &token];
    let mut host = Host::play(KEYS, &args);
    line.0.connect(("127.0.0.1", port)).unwrap();
    line.0.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut page = host.page();
    let scene = page.next("scene");
    assert_eq!(scene["notes"], json!([60, 61, 62, 63, 64, 65]));
    // mass whose position the slider shows when another input moves the port
    let seen = |name: &str| {
        let ports = scene["ports"].as_array().unwrap();
        ports.iter().find(|p| p["name"] == name).unwrap()["mass"].is_u64()
    };
    assert!(seen("key") && !seen("push"), "{}", scene["ports"]);
    page.done(&json!({"type": "sound", "on": true}));
    let mut cable = std::fs::OpenOptions::new().write(true).open(&pipe).unwrap();

    // a note by the pipe, with a clock message in it; unused events are reported
    cable.write_all(&[0x90, 60, 0xf8, 127]).unwrap();
    until("the string sounds", || peak(&page.hear(0.05)) > 0.01);
    cable.write_all(&[0x80, 60, 0, 0x90, 90, 64]).unwrap();
    until("a note that nothing listens to is told", || page.next("said")["text"].as_str().unwrap().contains("note 90"));
    // pitch bend moves the bob from the middle of its range
    cable.write_all(&[0xe0, 0x7f, 0x7f]).unwrap();
    // a learned controller sets its parameter
    let refused = page.ask(&json!({"type": "learn", "name": "kk"}));
    assert!(refused["text"].as_str().unwrap().contains("not a live parameter"), "{refused}");
    page.done(&json!({"type": "learn", "name": "k"}));
    until("it waits", || page.next("state")["learning"] == "k");
    cable.write_all(&[0xb0, 74, 127]).unwrap();
    param(&mut page, "k", 3000.0);
    assert_eq!(page.next("state")["bound"], json!([{"channel": 1, "number": 74, "name": "k"}]));
    drop(cable);
    let mut cable = std::fs::OpenOptions::new().write(true).open(&pipe).unwrap();
    cable.write_all(&[0xb0, 74, 0]).unwrap();
    param(&mut page, "k", 1000.0);

    // before its device connects, a device key follows notes from the page
    page.done(&json!({"type": "midi", "bytes": [0x90, 65, 127]}));
    let third = |s: &[f32]| s.chunks_exact(3).map(|c| c[2]).fold(f32::MIN, f32::max);
    until("the hammer has come", || third(&page.hear(0.05)) > -0.3);
    for bad in [json!("x"), json!([256]), json!(vec![0; 97])] {
        assert_eq!(page.ask(&json!({"type": "midi", "bytes": bad}))["ok"], false);
    }

    // OSC: numbers, texts with units, and a bundle in one tick
    line.say(&osc("/param", vec![text("k"), text("2.5 kN/m")]));
    param(&mut page, "k", 2500.0);
    line.say(&OscPacket::Bundle(OscBundle {
        timetag: OscTime { seconds: 0, fractional: 1 },
        content: vec![osc("/param/k", vec![OscType::Int(1500)]), osc("/param/z", vec![OscType::Double(0.25)])],
    }));
    param(&mut page, "k", 1500.0);
    param(&mut page, "z", 0.25);
    line.say(&osc("/note", vec![OscType::Int(62), OscType::Int(100)]));
    line.say(&osc("/note", vec![OscType::Int(62), OscType::Int(0), OscType::Int(1)]));
    line.say(&osc("/control", vec![OscType::Int(74), OscType::Int(127)]));
    param(&mut page, "k", 3000.0);
    line.say(&osc("/port", vec![text("push"), OscType::Float(0.1), OscType::Float(0.01)]));
    line.say(&osc("/state", vec![]));
    let (addr, args) = line.reply();
    assert_eq!((addr.as_str(), &args[..2]), ("/param", &[text("k"), OscType::Double(3000.0)][..]));
    for _ in 0..2 {
        line.reply();
    }
    assert_eq!(line.reply().0, "/tick");
    for (packet, why) in [
        (osc("/param", vec![text("kk"), OscType::Float(1.0)]), "not a live parameter"),
        (osc("/param", vec![text("k"), OscType::Float(f32::NAN)]), "k"),
        (osc("/param", vec![text("k"), text("5 m")]), "must be in N/m"),
        (osc("/param/k", vec![]), "one value"),
        (osc("/port", vec![text("pull"), OscType::Int(1)]), "`push`"),
        (osc("/note", vec![OscType::Int(200), OscType::Int(1)]), "0 to 127"),
        (osc("/note", vec![OscType::Int(60), OscType::Int(1), OscType::Int(0)]), "1 to 16"),
        (osc("/gesture", vec![OscType::Int(1)]), "gesture"),
        (osc("/fly", vec![]), "/param"),
    ] {
        let said = line.refused(&packet);
        assert!(said.contains(why), "{packet:?}: {said}");
    }
    line.0.send(b"nonsense").unwrap();
    assert_eq!(line.reply().0, "/error");
    // nested bundles at the limit of a packet, and a larger packet
    let deep = (0..500).fold(osc("/state", vec![]), |inner, _| {
        OscPacket::Bundle(OscBundle { timetag: OscTime { seconds: 0, fractional: 1 }, content: vec![inner] })
    });
    assert!(line.refused(&deep).contains("4096"));
    page.done(&json!({"type": "stop"}));
    host.ended();
    let replayed = host.ca(&["replay", "take.mcap", "--verify", "--json"]);
    let verdict: serde_json::Value = serde_json::from_str(&replayed).unwrap_or_else(|e| panic!("{e}: {replayed}"));
    assert_eq!(verdict["identical"], true, "{replayed}");
}
