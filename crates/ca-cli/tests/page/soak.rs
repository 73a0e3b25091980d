//! Tests long sessions: one client pulls, plays, changes and edits all the time, another listens, and some disappear.
//! Memory stays bounded, and the take saved at the end replays to the bit. Lasts five seconds, or an hour with
//! `CA_LONG=1`.

use crate::STRING;
use crate::host::{Host, until};
use crate::long_form::long_form;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Memory that a session may gain after its start \[MB\].
const GROWTH: f64 = 64.0;

/// A reproducible sequence of pseudo-random numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    fn part(&mut self) -> f64 {
        self.below(1000) as f64 / 1000.0
    }
}

/// Resident memory of a process \[MB\], or 0 if the system does not report it.
fn memory(process: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmRSS:"));
    line.and_then(|l| l.split_whitespace().nth(1)?.parse::<f64>().ok()).map_or(0.0, |kb| kb / 1024.0)
}

pub fn a_long_session() {
    let long = long_form("all but five seconds of an hour");
    let seconds = if long { 3600 } else { 5 };
    let mut host = Host::play(STRING, &[]);
    let (mut page, listens) = (host.page(), host.page().listen());
    let masses = page.next("scene")["drawing"]["masses"].as_u64().unwrap();
    let (mut random, begin) = (Random(1), Instant::now());
    let (mut done, mut refused, mut edits, mut early) = (0_u64, 0_u64, 0_u32, None);
    while begin.elapsed() < Duration::from_secs(seconds) {
        let request = match random.below(10) {
            0 => json!({"type": "grab", "mass": random.below(masses)}),
            1..=3 => json!({"type": "drag", "by": [2e-3 * (random.part() - 0.5)]}),
            4 => json!({"type": "release"}),
            5 => json!({"type": "port", "name": "push", "value": random.part()}),
            6 => json!({"type": "set", "values": {"k": 200.0 + 3000.0 * random.part()}}),
            7 => json!({"type": "midi", "bytes": [0x90, 60 + random.below(5), random.below(128)]}),
            8 => json!({"type": "gesture", "play": random.below(2) == 0}),
            // also an invalid request
            _ => json!({"type": "fly", "to": "nowhere"}),
        };
        let reply = page.ask(&request);
        done += 1;
        refused += u64::from(reply["ok"] == false);
        if done.is_multiple_of(200) {
            edits += 1;
            host.write(&STRING.replace("n = 30", &format!("n = {}", 28 + edits % 5)));
            // a client that disappears while it holds a mass
            let mut other = host.page();
            let _ = other.ask(&json!({"type": "grab", "mass": 3}));
            drop(other);
        }
        if done.is_multiple_of(20) {
            std::thread::sleep(Duration::from_millis(5));
        }
        // after the initial allocations
        if early.is_none() && begin.elapsed() > Duration::from_secs(seconds / 3) {
            early = Some(memory(host.process()));
        }
    }
    assert!(done > 100 && refused < done, "{refused} of {done} refused");
    let state: Value = page.next("state");
    assert_eq!(state["diverged"], false, "{state}");
    let (early, late) = (early.unwrap_or_default(), memory(host.process()));
    println!("{seconds} s: {done} requests, {refused} refused, {edits} edits; memory {early:.1} MB, then {late:.1} MB");
    assert!(late < early + GROWTH, "memory grew from {early} to {late} MB");
    page.done(&json!({"type": "release"}));
    // one more second, so that a hash follows the last action
    let end = state["seconds"].as_f64().unwrap() + 1.1;
    until("a second has passed", || page.next("state")["seconds"].as_f64().unwrap() > end);
    page.done(&json!({"type": "save"}));
    until("the take is there", || page.next("said")["text"].as_str().unwrap().contains("model-1.mcap"));
    page.done(&json!({"type": "stop"}));
    host.ended();
    let heard = listens.join().unwrap() as f64 / (2.0 * 48_000.0);
    assert!(heard > 0.5 * seconds as f64 && heard < 2.0 * end, "{heard} s were heard");
    let replayed = host.ca(&["replay", "model-1.mcap", "--verify", "--json"]);
    let verdict: Value = serde_json::from_str(&replayed).unwrap();
    assert_eq!(verdict["identical"], true, "{replayed}");
}
