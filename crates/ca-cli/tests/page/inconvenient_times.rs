//! Tests requests at inconvenient times, and restarts of a model.

use crate::host::{Host, command, until};
use serde_json::json;

/// A mass that moves away at 1 m/s.
const BIRD: &str = r#"
[param]
z = { value = "1 g/s", unit = "N s/m", live = true, min = 0, max = 1 }
[MAS]
bird = { m = "1 g", v = "1 m/s" }
bob = { m = "10 g" }
[SOL]
wall = {}
[REF]
spring = { between = ["wall", "bob"], k = "2 kN/m", z = "z" }
[ENF]
push = { to = "bob" }
[SOX]
left = { from = "bird", gain = 0.01 }
right = { from = "bob", gain = 1 }
"#;

/// A restart puts a distant mass back to its beginning and is recorded in the take. The energy account restarts too.
pub fn it_begins_anew() {
    let mut host = Host::play(BIRD, &["--log", "take.mcap", "--energy"]);
    let mut page = host.page();
    page.next("scene");
    page.done(&json!({"type": "set", "values": {"z": 0.5}}));
    until("it is far away", || page.look()[0] > 2.0);
    page.done(&json!({"type": "restart"}));
    assert_eq!(page.next("scene")["generation"], 2);
    let again = page.look_at(2)[0];
    assert!(again < 2.0, "it began anew: {again} m");
    until("the parameter is where it was", || page.next("state")["params"]["z"] == 0.5);
    page.done(&json!({"type": "stop"}));
    host.ended();
    let replayed = host.ca(&["replay", "take.mcap", "--verify", "--energy", "--json"]);
    let verdict: serde_json::Value = serde_json::from_str(&replayed).unwrap();
    assert_eq!((&verdict["identical"], &verdict["versions"]), (&json!(true), &json!(2)), "{replayed}");
}

/// An invalid change does not cancel a valid one, whether they arrive together or during a compilation. A missing model
/// file is reported, and so is a directory in its place.
pub fn a_wrong_change_takes_no_good_one_along() {
    let mut host = Host::play(BIRD, &[]);
    let mut page = host.page();
    page.next("scene");
    let change = |name: &str, value: &str| json!({"type": "change", "name": name, "value": value});
    let unknown = page.ask(&change("bob.mm", "1"));
    assert_eq!(
        (&unknown["ok"], unknown["text"].as_str().unwrap().contains("`mm`")),
        (&json!(false), true),
        "{unknown}"
    );
    for name in ["m", "x", "dx0", "v"] {
        page.done(&change(&format!("bob.{name}"), "1 Hz"));
    }
    page.done(&change("bird.m", "2 g"));
    page.done(&change("bob.m", "-1 g"));
    page.look_at(2);
    let long = page.ask(&change(&"x".repeat(1000), "1"));
    assert_eq!((&long["ok"], long["text"].as_str().unwrap().contains("at most")), (&json!(false), true), "{long}");
    let far = page.ask(&json!({"type": "port", "name": "push", "value": 1e308}));
    assert_eq!((&far["ok"], far["text"].as_str().unwrap().contains("must be at most")), (&json!(false), true), "{far}");
    let crooked = page.ask(&json!({"type": "drag", "by": ["x", 1]}));
    assert_eq!(crooked["ok"], false, "{crooked}");

    std::fs::remove_file(host.path("model.ca.toml")).unwrap();
    let gone = |page: &mut crate::host::Client| {
        until("it is reported", || page.next("report")["text"].as_str().unwrap().contains("no longer exists"));
    };
    gone(&mut page);
    host.write(BIRD);
    until("it is there again", || page.next("report")["ok"] == true);
    std::fs::remove_file(host.path("model.ca.toml")).unwrap();
    std::fs::create_dir(host.path("model.ca.toml")).unwrap();
    gone(&mut page);
    page.done(&json!({"type": "stop"}));
    host.ended();
}

/// A take is complete up to the moment of saving, also within the first second.
pub fn a_take_lasts_until_it_is_saved() {
    let mut host = Host::play(BIRD, &[]);
    let mut page = host.page();
    let mut played = 0.0;
    until("it plays", || {
        played = page.next("state")["seconds"].as_f64().unwrap();
        played > 0.0
    });
    page.done(&json!({"type": "set", "values": {"z": 0.25}}));
    page.done(&json!({"type": "save"}));
    until("it is saved", || page.next("said")["text"].as_str().unwrap().contains("saved"));
    // the end of the program completes a save requested last
    page.done(&json!({"type": "save"}));
    page.done(&json!({"type": "stop"}));
    host.ended();
    for take in ["model-1.mcap", "model-2.mcap"] {
        let replayed = host.ca(&["replay", take, "--verify", "--json"]);
        let verdict: serde_json::Value = serde_json::from_str(&replayed).unwrap();
        assert_eq!(verdict["identical"], true, "{take}: {replayed}");
        assert!(verdict["seconds"].as_f64().unwrap() >= played, "{take} lasts {played} s at least: {replayed}");
    }
}

pub fn a_killed_session_leaves_no_take() {
    let mut host = Host::play(BIRD, &[]);
    let mut page = host.page();
    until("it plays", || page.next("state")["seconds"].as_f64().unwrap() > 0.0);
    host.kill();
    let left = std::fs::read_dir(host.path("tmp")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let takes: Vec<String> = left.filter(|name| name.contains(".mcap")).collect();
    assert_eq!(takes, Vec::<String>::new());
}

/// Two performances run side by side, although only one has the control. Takes saved at the same time have different
/// names, or one is refused.
pub fn two_play_side_by_side() {
    let mut host = Host::play(BIRD, &[]);
    let mut page = host.page();
    page.next("scene");
    let args = ["play", "model.ca.toml", "--no-open", "--priority", "0", "--no-lock", "--seconds", "0.5"];
    let second = command(&host.path("")).args(args).output().unwrap();
    let said = String::from_utf8(second.stderr).unwrap();
    assert!(matches!(second.status.code(), Some(0 | 3)), "{said}");
    assert!(
        said.contains("`ca set` and `ca stop` cannot control this performance") && said.contains("play it at http://"),
        "{said}"
    );
    assert!(host.ca(&["set", "z=0.25"]).contains("z = 0.25"));

    let [first, second] = [(); 2].map(|()| page.ask(&json!({"type": "save"})));
    assert_eq!(first["ok"], true, "{first}");
    if second["ok"] == true {
        assert_ne!(first["text"], second["text"]);
    } else {
        assert!(second["text"].as_str().unwrap().contains("being saved"), "{second}");
    }
    page.done(&json!({"type": "stop"}));
    host.ended();
    // the take lacks sound, so the report uses the sound of the replay
    host.ca(&["report", "model-1.mcap", "-q", "-o", "r.html"]);
    let report = std::fs::read_to_string(host.path("r.html")).unwrap();
    assert!(!report.contains("all outputs are silent") && report.contains("audio"), "its sound is there");
}
