//! The measurement of accuracy as a page asks for it, with a clock of the test.

use ca_accuracy::timing::Clock;
use ca_accuracy::{AccuracyOptions, Reported, measured};
use ca_lab::Loaded;
use ca_web::accuracy::{CLOCK_STEP, answer};
use serde_json::{Value, json};
use std::cell::Cell;
use std::time::Duration;

const CHAIN: &str = r#"
[MAS]
a = { m = "1 g", v = "1 m/s" }
[SOL]
wall = {}
[BUT]
stop = { between = ["wall", "a"], k = "8 kN/m" }
[REF]
spring = { between = ["wall", "a"], k = "2 kN/m", z = 0.01 }
[SOX]
out = { from = "a" }
"#;

thread_local! {
    static CALLS: Cell<u32> = const { Cell::new(0) };
}

/// Time from a call of the clock to the next. The coarse clock cuts it at changing places.
const EACH: Duration = Duration::from_micros(317);

fn time() -> Duration {
    CALLS.set(CALLS.get() + 1);
    EACH * CALLS.get()
}

/// The same time in whole milliseconds, as a browser gives it.
fn coarse() -> Duration {
    Duration::from_millis(time().as_millis() as u64)
}

fn ask(request: &Value, now: fn() -> Duration) -> (Value, Vec<u8>) {
    CALLS.set(0);
    answer(request.to_string().as_bytes(), Clock { now, step: CLOCK_STEP }, &mut |_, _| true)
}

fn request(more: &Value) -> Value {
    let mut request = json!({"type": "accuracy", "file": "chain.ca.toml", "text": CHAIN, "seconds": 0.02, "times": [1, 2], "reference": 8});
    request.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    request
}

#[test]
fn a_model_is_measured_as_by_the_command() {
    let (mut object, page) = ask(&request(&json!({"error": 0.1})), time);
    assert_eq!(object.as_object_mut().unwrap().remove("ok"), Some(json!(true)), "{object}");
    CALLS.set(0);
    let loaded = Loaded::read(CHAIN, "chain.ca.toml");
    let mut ask = AccuracyOptions {
        rate: None,
        probes: &["out".into()],
        seconds: Some(0.02),
        times: Some(&[1, 2]),
        reference: Some(8),
        remedy: "",
        clock: Clock { now: time, step: CLOCK_STEP },
        progress: &mut |_, _| true,
    };
    let found = measured(&loaded, &mut ask).unwrap();
    let reported = Reported::new(&loaded.name, &found, Some(0.1), "");
    assert_eq!(object, reported.json());
    assert!(object["rows"].as_array().unwrap().len() > 4 && object["recommended"]["method"].is_string(), "{object}");
    assert!(page == reported.page(&loaded.model).html().into_bytes() && page.starts_with(b"<!"));
}

/// A play that is shorter than the step of the clock gets its time all the same.
#[test]
fn a_coarse_clock_gives_the_times_of_a_fine_one() {
    let (object, _) = ask(&request(&json!({"times": [1]})), coarse);
    let frames = (0.02 * object["rate"].as_f64().unwrap()).round();
    let expected = EACH.as_nanos() as f64 / frames;
    for row in object["rows"].as_array().unwrap() {
        let ns = row["ns_per_sample"].as_f64().unwrap();
        assert!((ns / expected - 1.0).abs() < 0.1, "{ns} for {expected}: {row}");
    }
}

#[test]
fn what_cannot_be_measured_is_refused() {
    for (more, why) in &[
        (json!({"type": "acuracy"}), "cannot be read"),
        (json!({"text": "[MSA]\na = {}\n"}), "chain.ca.toml:1:2"),
        (json!({"text": "]"}), "chain.ca.toml:1:1"),
        (json!({"text": "[SOL]\nwall = {}\n"}), "no output to compare"),
        (json!({"text": CHAIN.replace("v = \"1 m/s\"", "x = 0")}), "no motion"),
        (json!({"probes": ["b"]}), "`b`"),
        (json!({"changes": [["b.m", "1 g"]]}), "no `b.m`"),
        (json!({"limit": 2}), "at most 2"),
        (json!({"seconds": 1e300}), "at most 10"),
        (json!({"seconds": -1}), "above 0"),
        (json!({"seconds": "1"}), "cannot be read"),
        (json!({"seconds": 10, "probes": vec!["a"; 100]}), "too much to compare"),
        (json!({"times": [0]}), "from 1 to 1024"),
        (json!({"times": [1024]}), "above the limit"),
        (json!({"times": [1e10]}), "cannot be read"),
        (json!({"reference": 2}), "from 4 to 4096"),
        (json!({"error": 0}), "`error`"),
    ] {
        let (object, bytes) = ask(&request(more), time);
        assert_eq!((&object["ok"], bytes.len()), (&json!(false), 0), "{more}");
        assert!(object["text"].as_str().unwrap().contains(*why), "{more}: {object}");
    }
}

#[test]
fn a_measurement_stops_when_it_is_told_to() {
    let (mut calls, mut steps) = (0, Vec::new());
    let clock = Clock { now: time, step: CLOCK_STEP };
    let request = request(&json!({"seconds": 1, "reference": 64})).to_string();
    let (object, _) = answer(request.as_bytes(), clock, &mut |done, of| {
        calls += 1;
        steps.push(done);
        assert!(done <= of && of > 4);
        done < 2
    });
    assert_eq!((&object["ok"], &object["text"]), (&json!(false), &json!("the measurement was stopped")));
    assert!(steps.is_sorted() && steps.last() == Some(&2) && calls > 100, "{calls}");
}
