//! Compiler and engine natively, as a page uses them. The tests of `ca-site` compare the WebAssembly modules with them.

use ca_io::format::Format;
use ca_io::level_and_fade::{Ending, RenderOut};
use ca_web::compiler::answer;
use ca_web::engine::{Facts, WebEngine};
use serde_json::{Value, json};

const STRING: &str = r#"
[param]
k = { value = "2 kN/m", unit = "N/m", live = true, min = 200, max = 4000 }
[STRING]
low = { n = 30, f = "110 Hz", t60 = "3 s", m = "1 g" }
[MAS]
bob = { m = "10 g" }
[SOL]
wall = {}
[REF]
spring = { between = ["wall", "bob"], k = "k", z = 0.2 }
[ENF]
push = { to = "low[4]" }
[SOX]
left = { from = "low[6]", gain = 200 }
right = { from = "bob", gain = 200 }
[gesture]
push = [[0, 0], [0.01, 0.5], [0.02, 0], [0.6, 0]]
"#;

fn ask(request: &Value) -> (Value, Vec<u8>) {
    answer(request.to_string().as_bytes(), &[])
}

/// Compiles a text that is right.
fn plan(text: &str, changes: &Value) -> (Vec<u8>, Facts) {
    let (object, bytes) = ask(&json!({"type": "compile", "file": "s.ca.toml", "text": text, "changes": changes}));
    assert_eq!(object["ok"], true, "{object}");
    (bytes, serde_json::from_value(object["facts"].clone()).unwrap())
}

struct Played {
    engine: WebEngine,
    messages: Vec<Value>,
}

impl Played {
    fn new(text: &str) -> Played {
        let (plan, facts) = plan(text, &json!([]));
        let mut played = Played { engine: WebEngine::open(&plan, &facts).unwrap(), messages: Vec::new() };
        played.fetch();
        played
    }

    fn fetch(&mut self) {
        while let Some(message) = self.engine.next_message() {
            if message[0] == b'{' {
                self.messages.push(serde_json::from_slice(&message).unwrap());
            }
        }
    }

    fn ask(&mut self, request: &Value) -> Value {
        let mut request = request.clone();
        request["id"] = json!(7);
        self.engine.request(request.to_string().as_bytes());
        self.fetch();
        self.last("reply")
    }

    fn last(&self, kind: &str) -> Value {
        self.messages.iter().rfind(|m| m["type"] == kind).cloned().unwrap_or_default()
    }

    fn play(&mut self, frames: u32) -> Vec<f32> {
        let sound = self.engine.play(frames).to_vec();
        self.fetch();
        sound
    }
}

fn peak(sound: &[f32]) -> f32 {
    sound.iter().fold(0.0, |m, x| m.max(x.abs()))
}

#[test]
fn an_instrument_is_played_edited_and_mended() {
    let mut p = Played::new(STRING);
    assert_eq!((&p.last("scene")["channels"], p.engine.shape().channels), (&json!(["left", "right"]), 2));
    assert!(p.last("scene")["stability"].as_str().unwrap().contains("margin"));
    assert_eq!(peak(&p.play(100)), 0.0);
    assert_eq!(p.ask(&json!({"type": "gesture", "play": true}))["ok"], true);
    let frame = p.engine.shape().frame as usize;
    let sound = p.play(300);
    assert_eq!(sound.len(), 300 * frame * 2);
    assert!(peak(&sound) > 0.001, "{}", peak(&sound));
    assert_eq!(p.ask(&json!({"type": "set", "values": {"k": "900 N/m"}}))["ok"], true);
    assert!(
        p.ask(&json!({"type": "set", "values": {"k": "900 kg"}}))["text"].as_str().unwrap().contains("must be in N/m")
    );
    // a change needs the compiler, which is elsewhere; the instrument plays on meanwhile
    p.ask(&json!({"type": "change", "name": "low.t60", "value": "1 s"}));
    p.play(2);
    assert_eq!(p.last("compile")["changes"], json!([["low.t60", "1 s"]]));
    assert!(peak(&p.play(50)) > 0.0);
    let (bytes, facts) = plan(STRING, &p.last("compile")["changes"]);
    p.engine.compiled(&bytes, &facts);
    p.play(50);
    assert_eq!((&p.last("report")["ok"], &p.last("scene")["generation"]), (&json!(true), &json!(2)));
    assert!(peak(&p.play(50)) > 0.0, "the new version goes on");
    // a wrong one is reported, and nothing changes
    p.ask(&json!({"type": "change", "name": "low.t60", "value": "-1 s"}));
    p.play(2);
    let (object, _) = ask(&json!({"type": "compile", "text": STRING, "changes": p.last("compile")["changes"]}));
    assert_eq!(object["ok"], false);
    p.engine.refused(object["text"].as_str().unwrap());
    p.play(2);
    assert!(p.last("report")["text"].as_str().unwrap().contains("`t60`"), "{}", p.last("report"));
    assert_eq!(p.last("scene")["generation"], 2);
}

#[test]
fn bytes_that_are_not_a_plan_and_requests_of_any_form_are_refused() {
    let (plan, facts) = plan(STRING, &json!([]));
    assert!(WebEngine::open(&[], &facts).is_err());
    for at in (0..plan.len()).step_by(97) {
        let mut damaged = plan.clone();
        damaged[at] ^= 0x40;
        assert!(WebEngine::open(&damaged, &facts).is_err(), "byte {at}");
        assert!(WebEngine::open(&plan[..at], &facts).is_err(), "cut at {at}");
    }
    let mut p = Played::new(STRING);
    for request in [
        "",
        "{",
        "[]",
        "null",
        "{\"type\": 3}",
        "{\"type\": \"grab\", \"mass\": 1e300}",
        "{\"id\": {}, \"type\": \"save\"}",
    ] {
        p.engine.request(request.as_bytes());
        p.play(1);
    }
    p.engine.compiled(&plan, &facts);
    p.play(2);
    assert_eq!(p.last("report"), Value::Null, "a plan that nothing asked for is dropped");
    for request in
        ["", "{}", "{\"type\": \"compile\"}", "{\"type\": \"render\", \"seconds\": 1e9}", "{\"type\": \"wav\"}"]
    {
        assert_eq!(answer(request.as_bytes(), &[]).0["ok"], false, "{request}");
    }
}

#[test]
fn a_model_from_a_link_is_limited() {
    let (object, bytes) = ask(&json!({"type": "compile", "text": STRING, "limit": 20}));
    assert!(object["text"].as_str().unwrap().contains("at most 20"), "{object}");
    assert!(bytes.is_empty());
    assert_eq!(ask(&json!({"type": "compile", "text": STRING, "limit": 200})).0["ok"], true);
}

#[test]
fn errors_are_those_of_the_command() {
    let (object, _) =
        ask(&json!({"type": "check", "file": "s.ca.toml", "text": STRING.replace("[STRING]", "[STRNG]")}));
    let text = object["text"].as_str().unwrap();
    assert!(text.contains("s.ca.toml:4:2") && text.contains("STRING"), "{text}");
    let (object, _) = ask(&json!({"type": "check", "text": "[STRING]\nlow = { file = 'x' }\n"}));
    assert_eq!(object["ok"], false);
    let (object, _) = ask(&json!({"type": "check", "text": STRING}));
    assert!(object["masses"].as_u64().unwrap() > 30 && object["stability"].as_str().unwrap().contains("margin"));
}

#[test]
fn modes_are_those_of_the_model() {
    let (object, _) = ask(&json!({"type": "modes", "text": STRING}));
    let heard: Vec<f64> = object["modes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|m| m["heard_hz"].as_f64().unwrap())
        .filter(|f| *f > 0.0)
        .collect();
    // the bob on its spring, √(2000 N/m ÷ 10 g)/2π = 71.18 Hz, then the string
    assert!((heard[0] - 71.18).abs() < 0.1 && (heard[1] - 110.0).abs() < 1e-3, "{:?}", &heard[..2]);
    assert_eq!(heard.len(), 31);
    assert_eq!(ask(&json!({"type": "modes", "text": "[SOL]\nwall = {}\n"})).0["ok"], false);
}

#[test]
fn a_part_is_tuned_in_the_text() {
    let text = format!("# kept\n{STRING}");
    let tune = |more: &Value| {
        let mut request = json!({"type": "tune", "file": "s.ca.toml", "text": text});
        request.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        ask(&request).0
    };
    let object = tune(&json!({"parts": ["low=A2+20"], "a4": 442}));
    let wanted = 110.5 * (20.0f64 / 1200.0).exp2();
    let tuned = &object["tuned"][0];
    let near = |what: &str, to: f64| (tuned[what].as_f64().unwrap() / to).log2().abs() < 1e-6 / 1200.0;
    assert!(near("heard_hz", wanted) && near("wanted_hz", wanted) && near("before_hz", 110.0), "{object}");
    // only the number differs
    let new = object["text"].as_str().unwrap();
    let number = tuned["number"].as_str().unwrap();
    assert_eq!(new, text.replace("110 Hz", number));
    let (modes, _) = ask(&json!({"type": "modes", "text": new}));
    assert_eq!(modes["parts"], json!(["low"]));
    let heard = |m: &Value| m["heard_hz"].as_f64().unwrap();
    assert!(modes["modes"].as_array().unwrap().iter().any(|m| (heard(m) / wanted - 1.0).abs() < 1e-9));
    let second = tune(&json!({"parts": ["low=250 Hz"], "mode": 2}));
    assert!((second["tuned"][0]["heard_hz"].as_f64().unwrap() - 250.0).abs() < 1e-3, "{second}");
    let bank = "[BANK]\nk = { f = [100, 210, 290], m = 1e-3 }\n[SOX]\nout = { from = \"k[*]\" }\n";
    let scale = json!({"type": "tune", "text": bank, "parts": ["k"], "scale": "harmonic", "root": "A3"});
    let (object, _) = ask(&scale);
    let heard: Vec<f64> = object["tuned"].as_array().unwrap().iter().map(heard).collect();
    assert!(heard.iter().zip([220.0, 440.0, 660.0]).all(|(f, to)| (f - to).abs() < 1e-4), "{object}");
    for (more, why) in [
        (json!({}), "name a part"),
        (json!({"parts": ["lo=A2"]}), "did you mean `low`?"),
        (json!({"parts": ["low=H2"]}), "`H2` is not a pitch"),
        (json!({"parts": ["low"]}), "expected PART=PITCH"),
        (json!({"parts": ["low=1e300 kHz"]}), "`low`"),
        (json!({"parts": ["low=1e999"]}), "is not a pitch"),
        (json!({"parts": ["low=-3"]}), "is not a pitch"),
        (json!({"parts": ["bob=A2"]}), "neither `f` nor `k`"),
        (json!({"parts": ["low"], "scale": "just"}), "root"),
        (json!({"parts": ["low"], "scale": "x", "root": "A2"}), "`equal`"),
        (json!({"parts": ["low=A2"], "mode": 40}), "`low` has only"),
        (json!({"parts": ["low=A2"], "mode": 0}), "`mode`"),
        (json!({"parts": ["low=A2"], "a4": 1e300}), "`a4`"),
        (json!({"parts": ["low=A2"], "a4": "high"}), "cannot be read"),
        (json!({"parts": ["low=A2"], "changes": [["low.n", "20"]]}), "`changes`"),
        (json!({"parts": ["low=A2"], "text": "[STRNG]\nlow = {}\n"}), "STRING"),
        (json!({"parts": ["wall=A2"], "text": "[SOL]\nwall = {}\n"}), "neither `f` nor `k`"),
        (json!({"parts": ["low=A2"], "limit": 3}), "at most 3"),
    ] {
        let object = tune(&more);
        assert_eq!(object["ok"], false, "{more}");
        assert!(object["text"].as_str().unwrap().contains(why), "{more}: {object}");
    }
}

/// A render in a page has the bytes of the file that `ca render` writes.
#[test]
fn a_render_is_the_file_of_the_command() {
    // loud, so that its end is faded
    let text = STRING.replace("gain = 200", "gain = 20000");
    let (object, bytes) = ask(&json!({"type": "render", "file": "s.ca.toml", "text": text, "seconds": 0.1}));
    assert_eq!((&object["file"], &object["frames"]), (&json!("s.wav"), &json!(4800)));
    let scene =
        cordis_anima::Loaded::read(&text, "s.ca.toml").compile(&cordis_anima::Options::default()).unwrap().scene;
    let sound = cordis_anima::render(&scene, Some(0.1)).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.wav");
    let ending = Ending { format: Format::F32, flac: false, ceiling: false, fade: true, normalize: None };
    let mut out = RenderOut::create(&path, sound.rate, sound.channels, ending).unwrap();
    out.write(&sound.sound).unwrap();
    assert!(out.finish(false).unwrap().faded);
    assert!(std::fs::read(path).unwrap() == bytes);
    // sound that a page recorded
    let samples: Vec<u8> = [0.5_f32, -0.25].iter().flat_map(|x| x.to_le_bytes()).collect();
    let (object, wav) =
        answer(json!({"type": "wav", "file": "r.wav", "rate": 48e3, "channels": 2}).to_string().as_bytes(), &samples);
    assert_eq!(object["ok"], true, "{object}");
    assert!(wav.ends_with(&samples) && wav.starts_with(b"RIFF"));
}
