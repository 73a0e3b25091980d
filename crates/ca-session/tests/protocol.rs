//! Tests of the messages on the wire, and of the pages generated from their types.

#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use ca_haptic::control::Given;
use ca_session::protocol::{
    Bound, Choices, DeviceState, Message, NumberedRequest, Param, Picked, PortInfo, PortRole, Preset, Request, jsdoc,
    page,
};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

#[test]
fn the_pages_are_as_the_types_say() {
    for (path, want) in [("docs/protocol.md", page()), ("crates/ca-play/page/protocol.js", jsdoc())] {
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(file(path), &want).unwrap();
        }
        let found = std::fs::read_to_string(file(path)).unwrap_or_default();
        assert!(found == want, "{path} is stale; `UPDATE=1 cargo test -p ca-session --test protocol` writes it");
    }
}

/// The program and the page use the same messages, according to the page's own text.
#[test]
fn the_page_sends_and_takes_each_message() {
    let folder = file("crates/ca-play/page");
    let scripts: String = ["", "picture"]
        .iter()
        .flat_map(|sub| std::fs::read_dir(folder.join(sub)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "js") && !path.ends_with("protocol.js"))
        .map(|path| std::fs::read_to_string(path).unwrap())
        .collect();
    // requests without a control in the page: `restart` is for programs
    for kind in Request::kinds().iter().filter(|k| k.name != "restart") {
        assert!(scripts.contains(&format!("type: \"{}\"", kind.name)), "the page never sends `{}`", kind.name);
    }
    for kind in Message::kinds() {
        assert!(scripts.contains(&format!("case \"{}\"", kind.name)), "the page does not take `{}`", kind.name);
    }
}

#[test]
fn the_types_of_the_page_hold() {
    let tsc = std::env::var("CA_TSC").unwrap_or_else(|_| "tsc".into());
    let found = Command::new(&tsc).arg("--version").output();
    if !found.is_ok_and(|o| o.status.success()) {
        skipped::skipped("tsc", "no TypeScript compiler (tsc), which checks the types of the page");
        return;
    }
    let checked = Command::new(&tsc)
        .args(["--noEmit", "--allowJs", "--checkJs", "--target", "es2022", "--module", "es2022"])
        .args(["--moduleResolution", "bundler", "--lib", "es2022,dom,dom.iterable"])
        .args(["protocol.js", "main.js"])
        .current_dir(file("crates/ca-play/page"))
        .output()
        .unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
}

/// The bytes are those sent before there were types.
#[test]
fn messages_are_the_same_bytes_as_ever() {
    let scene = Message::Scene {
        generation: 2,
        title: "A key".into(),
        model: "key.ca.toml".into(),
        rate: 48_000.0,
        frame: 16,
        channels: vec!["left".into()],
        drawing: json!({"masses": 1}),
        params: vec![Param {
            name: "k".into(),
            value: 8000.0,
            min: Some(0.0),
            max: None,
            unit: "N/m".into(),
            doc: "of the spring".into(),
        }],
        ports: vec![PortInfo { name: "key".into(), role: PortRole::Device, mass: Some(3), rest: -0.5 }],
        gesture: true,
        presets: vec![Preset { name: "soft".into(), values: [("k".to_string(), 800.0)].into() }],
        notes: None,
        seconds: Some(2.5),
        energy: vec!["low".into()],
        stability: "proven".into(),
    };
    let state = Message::State {
        tick: 480,
        seconds: 0.01,
        load: None,
        late: 1,
        lost: 2,
        clipped: 3,
        diverged: false,
        playing: true,
        pointer: -1,
        held: vec![],
        devices: vec![DeviceState { name: "key".into(), mode: "ON".into(), cause: "NONE".into() }],
        params: [("k".to_string(), 8000.0)].into(),
        clients: 1,
        learning: None,
        bound: vec![Bound { channel: 1, number: 74, name: "k".into() }],
        sound: "page".into(),
        outputs: Choices { choices: vec!["page".into()], wanted: "page".into(), busy: false },
        latency: Some(2.5),
        underruns: Some(0),
        arms: false,
        keeps: true,
        recording: None,
    };
    let reply = |picked| Message::Reply { id: json!(7), ok: true, text: "low".into(), picked };
    let picked = Picked { mass: 3, name: "low".into(), kind: "MAS".into() };
    for (message, text) in [
        (
            scene,
            r#"{"channels":["left"],"drawing":{"masses":1},"energy":["low"],"frame":16,"generation":2,"gesture":true,"model":"key.ca.toml","notes":null,"params":[{"doc":"of the spring","max":null,"min":0.0,"name":"k","unit":"N/m","value":8000.0}],"ports":[{"mass":3,"name":"key","rest":-0.5,"role":"device"}],"presets":[{"name":"soft","values":{"k":800.0}}],"rate":48000.0,"seconds":2.5,"stability":"proven","title":"A key","type":"scene"}"#,
        ),
        (
            state,
            r#"{"arms":false,"bound":[{"channel":1,"name":"k","number":74}],"clients":1,"clipped":3,"devices":[{"cause":"NONE","mode":"ON","name":"key"}],"diverged":false,"held":[],"keeps":true,"late":1,"latency":2.5,"learning":null,"load":null,"lost":2,"outputs":{"busy":false,"choices":["page"],"wanted":"page"},"params":{"k":8000.0},"playing":true,"pointer":-1,"recording":null,"seconds":0.01,"sound":"page","tick":480,"type":"state","underruns":0}"#,
        ),
        (
            Message::Energy { seconds: 0.5, motion: vec![1e-9, 0.0] },
            r#"{"motion":[1e-9,0.0],"seconds":0.5,"type":"energy"}"#,
        ),
        (Message::Said { bad: true, text: "gone".into() }, r#"{"bad":true,"text":"gone","type":"said"}"#),
        (Message::Report { ok: false, text: "E101".into() }, r#"{"ok":false,"text":"E101","type":"report"}"#),
        (reply(None), r#"{"id":7,"ok":true,"text":"low","type":"reply"}"#),
        (reply(Some(picked)), r#"{"id":7,"kind":"MAS","mass":3,"name":"low","ok":true,"text":"low","type":"reply"}"#),
    ] {
        assert_eq!(message.text(), text);
        assert_eq!(serde_json::from_str::<Message>(text).unwrap(), message);
    }
}

#[test]
fn requests_are_read_as_ever() {
    let values = [("k".to_string(), Given::Number(9.0)), ("z".to_string(), Given::Text("1 N s/m".into()))].into();
    for (text, want) in [
        (r#"{"type":"sound","on":true}"#, Request::Sound { on: true }),
        (r#"{"type":"sound","on":1}"#, Request::Sound { on: false }),
        (r#"{"type":"grab","mass":3,"more":[]}"#, Request::Grab { mass: Some(3), finger: None }),
        (r#"{"type":"grab","mass":-3,"finger":2}"#, Request::Grab { mass: None, finger: Some(2) }),
        (r#"{"type":"drag","by":[1,0.5,0]}"#, Request::Drag { finger: None, by: Some(vec![1.0, 0.5, 0.0]) }),
        (r#"{"type":"drag","by":[null],"finger":256}"#, Request::Drag { finger: None, by: None }),
        (r#"{"type":"release","id":1}"#, Request::Release { finger: None }),
        (r#"{"type":"gesture"}"#, Request::Gesture { play: false }),
        (r#"{"type":"port","name":"push","value":"x"}"#, Request::Port { name: Some("push".into()), value: None }),
        (r#"{"type":"change","name":7,"value":"5 s"}"#, Request::Change { name: String::new(), value: "5 s".into() }),
        (r#"{"type":"midi","bytes":[144,60,127]}"#, Request::Midi { bytes: Some(vec![144, 60, 127]) }),
        (r#"{"type":"midi","bytes":[256]}"#, Request::Midi { bytes: None }),
        (r#"{"type":"learn","name":null}"#, Request::Learn { name: None }),
        (r#"{"type":"learn","name":"k"}"#, Request::Learn { name: Some(Some("k".into())) }),
        (r#"{"type":"audio","device":"page"}"#, Request::Audio { device: "page".into() }),
        (r#"{"type":"set","values":{"k":9,"z":"1 N s/m"}}"#, Request::Set { values: Some(values) }),
        (r#"{"type":"set","values":{"k":null}}"#, Request::Set { values: None }),
        (r#"{"type":"stop"}"#, Request::Stop),
    ] {
        let asked = NumberedRequest::read(serde_json::from_str(text).unwrap());
        assert_eq!(asked.request, Ok(want), "{text}");
    }
    let fly = NumberedRequest::read(json!({"type": "fly", "id": null}));
    assert_eq!(fly.id, Some(Value::Null));
    let why = |asked: NumberedRequest| asked.request.unwrap_err().to_string();
    assert_eq!(why(fly), "`fly` is not a request that a page can send");
    assert_eq!(why(NumberedRequest::read(json!({"type": 7}))), "`` is not a request that a page can send");
}

proptest! {
    #[test]
    fn a_request_comes_back_as_it_was_sent(
        mass in any::<u64>(), by in prop::collection::vec(-1e3..1e3f64, 0..4), on: bool, text in ".{0,20}",
        bytes in prop::collection::vec(any::<u8>(), 0..8),
    ) {
        for request in [
            Request::Grab { mass: Some(mass), finger: None },
            Request::Drag { finger: None, by: Some(by) },
            Request::Record { on },
            Request::Change { name: text.clone(), value: text.clone() },
            Request::Learn { name: Some(Some(text)) },
            Request::Midi { bytes: Some(bytes) },
            Request::Save,
        ] {
            let sent = serde_json::to_value(&request).unwrap();
            prop_assert_eq!(NumberedRequest::read(sent), NumberedRequest { id: None, request: Ok(request) });
        }
    }
}
