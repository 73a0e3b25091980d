//! Plays every bundled instrument with device ports by `ca serve` and a simulated device through shared memory. The
//! instrument must sound, the hand must receive a force, and the guard must not trip. The hand follows the built-in
//! gesture of the model.
//!
//! Device and engine wait for each other, so a run takes only the time of their computation; two run at once. Profiles
//! are the bundled ones, but with a time limit that no stall reaches ([`patient`]). `benches/src/instruments` defines
//! the requirements for each instrument.

use crate::long_form::long_form;
use crate::sandbox::{Sandbox, patient};
use ca_benches::instruments::{Instrument, Stroke, all};
use ca_compile::Options;
use ca_core::Scene;
use ca_haptic::profile::SHIPPED;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Returns true if device or engine waited too long for the other.
fn late(faults: &[serde_json::Value]) -> bool {
    faults.iter().any(|f| ["DEVICE_LOST", "WATCHDOG_OUT"].iter().any(|why| f.to_string().contains(why)))
}

/// Lists the errors of a run. Returns `None` if the engine continued without its device on a busy machine.
fn attempt(sandbox: &Sandbox, i: &Instrument, hand: &[String]) -> Option<Vec<String>> {
    let sound = format!("{}.wav", i.model);
    let server = sandbox.serve(i.model, &["--clock", "device", "--arm", "--json", "-o", &sound]);
    let mut args = vec!["device", "sim", "--lockstep", "--wait", "--json"];
    args.extend(hand.iter().map(String::as_str));
    let felt = sandbox.spawn(&args).end();
    let run = server.stop();
    if felt.code != Some(0) {
        return Some(vec![felt.err]);
    }
    let (felt, summary) = (felt.json(), run.json());
    let frames = &summary["devices"][0]["frames"];
    let faults = summary["faults"].as_array().expect("a list");
    if *frames != felt["frames"] || late(faults) {
        return None;
    }
    let mut wrong = Vec::new();
    if !faults.is_empty() || summary["unstable"] != false || run.code != Some(0) {
        wrong.push(format!("exit {:?}, faults {}, unstable {}", run.code, summary["faults"], summary["unstable"]));
    }
    if summary["devices"][0]["forces_on"] != true {
        wrong.push(format!("forces stay off: {}", summary["devices"][0]["waits"]));
    }
    let largest = felt["largest"].as_array().expect("a list").iter().filter_map(serde_json::Value::as_f64);
    let largest = largest.fold(0.0, f64::max);
    if largest < i.stroke.min_force {
        wrong.push(format!("the hand feels {largest:.4} N, not {} N", i.stroke.min_force));
    }
    let sound = hound::WavReader::open(sandbox.path(&sound)).expect("a sound");
    let peak = sound.into_samples::<f32>().map(|s| f64::from(s.expect("a sample").abs())).fold(0.0, f64::max);
    let level = 20.0 * peak.max(1e-9).log10();
    if !(i.stroke.min_peak..=0.0).contains(&level) {
        wrong.push(format!("it peaks at {level:.1} dBFS, not at {} or more", i.stroke.min_peak));
    }
    eprintln!("{}: {level:.1} dBFS, {largest:.3} N", i.model);
    Some(wrong)
}

/// Plays an instrument with device ports and at most `most` modules, and describes the errors.
fn played(i: &Instrument, most: usize) -> Option<String> {
    let scene = i.load().compile(&Options::default()).expect("a bundled model compiles").scene;
    let (device, gesture) = hand(&scene, &i.stroke).filter(|_| scene.mats() + scene.lias() <= most)?;
    let sandbox = Sandbox::shared();
    sandbox.put("hand.csv", &gesture);
    let shipped = |name: &str| SHIPPED.iter().find(|s| s.0 == name).map(|s| s.1);
    // a second device of the same type, or one with a user profile
    let own = if device.starts_with("tgr12") { "tgr12" } else { "unknown" };
    let text = shipped(device).or(shipped(own)).expect("shipped");
    let mut text = patient(&text.replace(&format!("name = {own:?}"), &format!("name = {device:?}")));
    if i.stroke.clear > 0.0 {
        text = text.replace("[guard]\n", &format!("[guard]\nclear = {}\n", i.stroke.clear));
    }
    sandbox.put(&format!("c/profiles/{device}.toml"), &text);
    let seconds = i.stroke.seconds.to_string();
    let args = ["--profile", device, "--script", "file", "--gesture", "hand.csv", "--seconds", &seconds];
    let args = args.map(String::from);
    let wrong = (0..8).find_map(|_| attempt(&sandbox, i, &args)).unwrap_or(vec!["no run without a hole".into()]);
    Some(if wrong.is_empty() { String::new() } else { format!("{}: {}", i.model, wrong.join("; ")) })
}

#[test]
fn every_instrument_with_ports_of_a_device_is_played_by_one() {
    let (most, least) = if long_form("instruments of more than 200 modules") { (usize::MAX, 10) } else { (200, 4) };
    let (all, next, found) = (all(), AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|s| {
        for _ in 0..2 {
            s.spawn(|| {
                while let Some(i) = all.get(next.fetch_add(1, Relaxed)) {
                    found.lock().unwrap().extend(played(i, most));
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    assert!(found.len() >= least, "only {} instruments have ports of a device", found.len());
    let wrong: Vec<String> = found.into_iter().filter(|w| !w.is_empty()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Returns the first device of a scene and its gesture as CSV, with a column per degree of freedom \[m\]. Returns
/// `None` for a scene without a device port. A degree of freedom without a gesture stays at the initial position of its
/// port.
fn hand<'a>(scene: &'a Scene, stroke: &Stroke) -> Option<(&'a str, String)> {
    let device = scene.inputs.iter().find_map(|i| i.device.as_ref())?.0.as_str();
    let mut ways: BTreeMap<u32, Vec<[f64; 2]>> = BTreeMap::new();
    for i in &scene.inputs {
        let Some((name, dof)) = &i.device else { continue };
        if name != device {
            continue;
        }
        let way =
            match (stroke.motions.iter().find(|w| w.0 == *dof), scene.about.gestures.iter().find(|g| g.0 == i.name)) {
                (Some((_, own)), _) => own.to_vec(),
                (None, Some((_, points))) => {
                    points.iter().map(|[t, x]| [t * stroke.slower, x / i.gains.alpha]).collect()
                }
                (None, None) => vec![[0.0, i.rest / i.gains.alpha]],
            };
        ways.insert(*dof, way);
    }
    let mut csv = String::from("time");
    let last = *ways.keys().next_back()?;
    (0..=last).for_each(|k| _ = write!(csv, ",dof{k}"));
    csv.push('\n');
    let mut rows: Vec<(f64, u32, f64)> = (0..=last).map(|k| (0.0, k, ways.get(&k).map_or(0.0, |w| w[0][1]))).collect();
    rows.extend(ways.iter().flat_map(|(k, w)| w.iter().map(|p| (p[0], *k, p[1]))));
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (t, k, x) in rows {
        _ = write!(csv, "{t}");
        (0..=last).for_each(|c| _ = if c == k { write!(csv, ",{x}") } else { write!(csv, ",") });
        csv.push('\n');
    }
    Some((device, csv))
}
