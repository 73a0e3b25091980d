//! Tests of the answers and messages of a session without a page, a thread and a file.

use ca_core::{LiveParam, Scene};
use ca_haptic::engine::Setup;
use ca_haptic::version::Version;
use ca_session::protocol::{Message, NumberedRequest};
use ca_session::{
    CompileState, CompiledVersion, Instrument, Language, NoFiles, Pages, Parts, Refused, VersionCompiler,
};
use ca_view::Drawing;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

/// A mass on a live spring, with a port.
const MODEL: &str = r#"
[param]
k = { value = "500 N/m", unit = "N/m", live = true, min = 100, max = 5000 }
[preset.soft]
k = 200
[preset.hard]
k = "4 kN/m"
[MAS]
bob = { m = "5 g" }
[SOL]
wall = {}
[REF]
spring = { between = ["wall", "bob"], k = "k", z = 0.01 }
[ENF]
push = { to = "bob" }
[SOX]
out = { from = "bob", gain = 200 }
"#;

fn scene(changes: &[(String, String)]) -> Result<Arc<Scene>, Refused> {
    let text = changes.iter().fold(MODEL.to_string(), |text, (name, value)| match name.as_str() {
        "bob.m" => text.replace("5 g", value),
        _ => text + "[?]",
    });
    let (_, scene) = ca_compile::load(&text, "bob.ca.toml", &ca_model::catalog(), &ca_compile::Options::default());
    scene.map(|c| Arc::new(c.scene)).map_err(|found| format!("{found:?}").into())
}

/// Everything sent to the pages.
#[derive(Clone, Default)]
struct FakePages(Rc<RefCell<Sent>>);

#[derive(Default)]
struct Sent {
    texts: Vec<Value>,
    pictures: usize,
    sound: Vec<u8>,
}

impl FakePages {
    fn put(&self, message: &Message) {
        self.0.borrow_mut().texts.push(serde_json::from_str(&message.text()).unwrap());
    }
    fn last(&self, kind: &str) -> Value {
        self.0.borrow().texts.iter().rfind(|m| m["type"] == kind).cloned().unwrap_or_default()
    }
}

impl Pages for FakePages {
    fn greet(&self, scene: &Message) {
        self.put(scene);
    }
    fn send(&self, _: u64, message: &Message) {
        self.put(message);
    }
    fn send_all(&self, message: &Message) {
        self.put(message);
    }
    fn count(&self) -> usize {
        1
    }
    fn is_heard(&self) -> bool {
        true
    }
    fn view(&self, _: &[u8]) {
        self.0.borrow_mut().pictures += 1;
    }
    fn sound(&self, block: &[u8]) {
        self.0.borrow_mut().sound.extend_from_slice(&block[16..]);
    }
}

struct Numbers;

impl Language for Numbers {
    fn value(&self, param: &LiveParam, text: &str) -> Result<f64, Refused> {
        let number = text.strip_suffix(param.unit.symbol).ok_or("another unit")?;
        number.trim().parse().map_err(|_| "not a number".into())
    }
    fn nearest(&self, _: &str, names: &[&str]) -> Option<String> {
        names.first().map(|n| (*n).into())
    }
    fn stability(&self, _: &Scene) -> String {
        "not judged".into()
    }
}

/// Compiles immediately.
#[derive(Default)]
struct Compiler(Option<Result<Box<CompiledVersion>, Refused>>, Snapshots);

/// Changes and moved parameters of each snapshot, as JSON.
type Snapshots = Rc<RefCell<Vec<Value>>>;

impl VersionCompiler for Compiler {
    fn check(&mut self, _: &str, _: &str) -> Result<(), Refused> {
        Ok(())
    }
    fn start(&mut self, changes: &[(String, String)], anew: bool, _: &[Setup]) -> Result<(), Refused> {
        self.0 = Some(scene(changes).map(|scene| {
            Box::new(CompiledVersion {
                drawing: Arc::new(Drawing::new(&scene)),
                version: Version::new(scene, anew),
                warnings: String::new(),
                softened: false,
                setups: Vec::new(),
            })
        }));
        Ok(())
    }
    fn poll(&mut self) -> CompileState {
        self.0.take().map_or(CompileState::Idle, CompileState::Done)
    }
    fn snapshot(&mut self, changes: &[(String, String)], live: &[LiveParam]) -> Result<(), Refused> {
        let live: Vec<_> = live.iter().map(|p| (&p.name, p.value)).collect();
        self.1.borrow_mut().push(json!([changes, live]));
        Ok(())
    }
    fn is_new(&mut self) -> bool {
        false
    }
    fn gone(&mut self) -> Option<String> {
        None
    }
}

fn instrument() -> (Instrument, FakePages) {
    let (instrument, pages, _) = instrument_with_snapshots();
    (instrument, pages)
}

fn instrument_with_snapshots() -> (Instrument, FakePages, Snapshots) {
    let (pages, snapshots) = (FakePages::default(), Snapshots::default());
    let parts = Parts {
        pages: Box::new(pages.clone()),
        language: Box::new(Numbers),
        maker: Box::new(Compiler(None, snapshots.clone())),
        files: Box::new(NoFiles("no files here")),
        name: "bob".into(),
        allow_arm: false,
    };
    (Instrument::new(&scene(&[]).unwrap(), parts, Box::new(pages.clone()), Vec::new()), pages, snapshots)
}

fn ask(instrument: &mut Instrument, pages: &FakePages, request: Value) -> (bool, String) {
    let mut request = request;
    request["id"] = json!(9);
    assert!(!instrument.request(1, NumberedRequest::read(request)));
    let reply = pages.last("reply");
    assert_eq!(reply["id"], 9);
    (reply["ok"] == true, reply["text"].as_str().unwrap().into())
}

#[test]
fn a_session_plays_and_answers_without_threads() {
    let (mut i, pages) = instrument();
    let greeting = pages.last("scene");
    assert_eq!((&greeting["generation"], &greeting["params"][0]["name"]), (&json!(1), &json!("k")));
    let drawn = (0..3).find(|m| ask(&mut i, &pages, json!({"type": "pick", "mass": m})).1 == "bob").unwrap();
    assert_eq!(pages.last("reply")["kind"], "MAS");

    // a hand pulls the mass and releases it
    assert_eq!(ask(&mut i, &pages, json!({"type": "grab", "mass": drawn})), (true, "held".into()));
    assert_eq!(ask(&mut i, &pages, json!({"type": "drag", "by": [1e-3]})).1, "pulled");
    i.play(1000);
    assert_eq!(pages.last("state")["held"], json!([drawn]));
    let other = ask(&mut i, &pages, json!({"type": "grab", "mass": drawn, "finger": 1}));
    assert!(!other.0 && other.1.contains("holds this mass"), "{}", other.1);
    i.left(2);
    i.left(1);
    i.play(1000);
    let state = pages.last("state");
    assert_eq!((&state["held"], &state["diverged"]), (&json!([]), &json!(false)));
    assert!(pages.last("energy")["motion"][0].as_f64().unwrap() > 0.0);
    let sent = pages.0.borrow();
    assert!(sent.pictures > 10 && sent.sound.chunks(4).any(|s| s != [0; 4]));
    drop(sent);

    // values with units, and refused requests
    assert_eq!(ask(&mut i, &pages, json!({"type": "set", "values": {"k": "700 N/m"}})), (true, "k = 700".into()));
    for (request, why) in [
        (json!({"type": "set", "values": {"kk": 1}}), "did you mean `k`?"),
        (json!({"type": "set", "values": {"k": 1e9}}), "between"),
        (json!({"type": "drag", "by": [1]}), "does not hold a mass"),
        (json!({"type": "midi", "bytes": [256]}), "`bytes` must be at most 96 numbers from 0 to 255"),
        (json!({"type": "arm", "on": true}), "--allow-arm"),
        (json!({"type": "save"}), "no files here"),
        (json!({"type": "fly"}), "`fly` is not a request that a page can send"),
    ] {
        let (ok, text) = ask(&mut i, &pages, request);
        assert!(!ok && text.contains(why), "{text}");
    }
    // a controller that no port follows is bound to a parameter
    assert!(ask(&mut i, &pages, json!({"type": "learn", "name": "k"})).0);
    assert!(ask(&mut i, &pages, json!({"type": "midi", "bytes": [0xb0, 74, 127]})).0);
    i.play(1000);
    assert_eq!(pages.last("state")["params"]["k"], 5000.0);
    assert!(i.request(1, NumberedRequest::read(json!({"type": "stop"}))));
}

#[test]
fn a_preset_is_chosen_by_a_page_by_osc_and_by_a_program_change() {
    let (mut i, pages) = instrument();
    let presets = json!([{"name": "soft", "values": {"k": 200.0}}, {"name": "hard", "values": {"k": 4000.0}}]);
    assert_eq!(pages.last("scene")["presets"], presets);
    let choose = |preset: Value, more: Value| {
        let mut values = more;
        values["preset"] = preset;
        json!({"type": "set", "values": values})
    };
    assert_eq!(ask(&mut i, &pages, choose(json!("hard"), json!({}))), (true, "k = 4000".into()));
    i.play(1000);
    assert_eq!(pages.last("state")["params"]["k"], 4000.0);
    // a parameter that is set by itself counts
    assert!(ask(&mut i, &pages, choose(json!("hard"), json!({"k": 700}))).0);
    i.play(1000);
    assert_eq!(pages.last("state")["params"]["k"], 700.0);
    for (preset, why) in [(json!("heavy"), "did you mean `soft`?"), (json!(1), "`preset` is not a live parameter")] {
        let (ok, text) = ask(&mut i, &pages, choose(preset, json!({})));
        assert!(!ok && text.contains(why), "{text}");
    }
    // program 0 is the first preset; one that the model lacks changes nothing
    assert!(ask(&mut i, &pages, json!({"type": "midi", "bytes": [0xc0, 0]})).0);
    i.play(1000);
    assert_eq!(pages.last("state")["params"]["k"], 200.0);
    assert!(ask(&mut i, &pages, json!({"type": "midi", "bytes": [0xc0, 2]})).0);
    i.play(1000);
    assert_eq!(pages.last("state")["params"]["k"], 200.0);
}

#[test]
fn an_edit_plays_on_and_a_wrong_one_takes_no_good_one_along() {
    let (mut i, pages, snapshots) = instrument_with_snapshots();
    let change = |name: &str, value: &str| json!({"type": "change", "name": name, "value": value});
    assert!(ask(&mut i, &pages, change("bob.m", "6 g")).0);
    assert!(ask(&mut i, &pages, change("bob.x", "1")).0);
    i.play(2000);
    let texts = pages.0.borrow().texts.clone();
    let reports: Vec<&Value> = texts.iter().filter(|m| m["type"] == "report").map(|m| &m["ok"]).collect();
    assert_eq!(reports, [true, false]);
    assert_eq!(pages.last("scene")["generation"], 2);
    // a snapshot has the good change alone, and the live parameters that were moved
    assert_eq!(ask(&mut i, &pages, json!({"type": "snapshot"})), (true, "stored".into()));
    assert!(ask(&mut i, &pages, json!({"type": "set", "values": {"k": 700}})).0);
    assert!(ask(&mut i, &pages, json!({"type": "snapshot"})).0);
    let change = json!([["bob.m", "6 g"]]);
    assert_eq!(*snapshots.borrow(), [json!([change, []]), json!([change, [["k", 700.0]]])]);
}
