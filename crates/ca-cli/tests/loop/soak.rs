//! A minute of playing while both cores are busy (long form only): every frame accounted for, no memory lost, and the
//! table of round trips with and without load. It asserts counts; times are printed.

use super::stage::{Stage, until};
use serde_json::Value;
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Resident memory of a process \[kB\].
fn resident(id: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// Plays for so many seconds; what device and server told, and the server's memory after a sixth and at the end \[kB\].
fn played(seconds: u64, load: bool) -> (Value, Value, [u64; 2]) {
    let stage = Stage::new();
    let server = stage.serve("key.ca.toml", &["--json"]);
    let stop = Arc::new(AtomicBool::new(false));
    let burners: Vec<_> = (0..if load { 2 } else { 0 })
        .map(|_| {
            let stop = stop.clone();
            std::thread::spawn(move || {
                while !stop.load(Relaxed) {
                    std::hint::spin_loop();
                }
            })
        })
        .collect();
    let device = stage.key(&["--script", "shake", "--seconds", &seconds.to_string(), "--json"]);
    stage.arm();
    let at = |part: u64| 3000 * seconds * part / 6;
    let mut early = 0;
    // frames of the engine are the clock of this test
    let begin = stage.ask(&ca_haptic::host::control::Request::Status).unwrap().fields["frames"].as_u64().unwrap();
    let wait = |n: u64| {
        for _ in 0..10 {
            let mut there = false;
            let end = std::time::Instant::now() + std::time::Duration::from_secs(25);
            while !there && std::time::Instant::now() < end {
                let now = stage.ask(&ca_haptic::host::control::Request::Status);
                there = now.is_some_and(|r| r.fields["frames"].as_u64().unwrap() >= begin + n);
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
            if there {
                return;
            }
        }
        panic!("{n} frames do not come");
    };
    wait(at(1));
    early += resident(server.id());
    wait(at(5));
    let late = resident(server.id());
    let told = device.end().is(0).json();
    let mut frames = 0;
    until("the server has all", || {
        let now = stage.state().2;
        std::mem::replace(&mut frames, now) == now
    });
    let summary = server.stop().json();
    stop.store(true, Relaxed);
    for b in burners {
        b.join().unwrap();
    }
    (told, summary, [early, late])
}

fn number(v: &Value, path: &[&str]) -> u64 {
    path.iter().fold(v, |v, k| &v[*k]).as_u64().unwrap_or_else(|| panic!("no {path:?} in {v:#}"))
}

/// Every frame is somewhere.
fn account(device: &Value, server: &Value) {
    // from the first that was answered: before it the lines were being opened
    let sent = number(device, &["frames"]) + 1 - number(device, &["first_answered"]);
    let t = |k: &str| number(server, &["traffic", k]);
    let (received, missed) = (t("received"), t("missed"));
    // the last of a device that leaves can be gone before somebody looks, and the first answer can be to the last of
    // several: four lie in the queue
    assert!(sent.abs_diff(received + missed) <= 4, "{sent} sent, {received} + {missed}");
    assert_eq!(t("foreign"), 0);
    assert_eq!(number(server, &["lost_records"]), 0);
    assert_eq!(received - t("full"), number(&server["devices"][0], &["frames"]), "what came went to the engine");
    // and every force: those of the engine are sent, or counted; the last is that forces are off
    let forces = t("sent") + t("unsent") + number(server, &["lost_forces"]);
    assert_eq!(forces, number(server, &["frames"]));
}

fn table(what: &str, device: &Value, server: &Value) {
    let times = |v: &Value| ["p50", "p99", "p999", "max"].map(|k| format!("{:>9.1}", v[k].as_f64().unwrap())).join("");
    eprintln!("{what:<22}{:>9}{:>9}{:>9}{:>9} us", "p50", "p99", "p99.9", "max");
    eprintln!("{:<22}{}", "  position to force", times(&device["loop_us"]));
    eprintln!("{:<22}{}", "  position to its use", times(&server["devices"][0]["loop_us"]));
    eprintln!("{:<22}{}", "  frame begins late", times(&server["late_us"]));
    eprintln!(
        "  {} frames, {} left out, {} missed by the gateway",
        server["frames"], server["missed"], server["traffic"]["missed"]
    );
}

#[test]
fn every_frame_is_accounted_for() {
    let (device, server, _) = played(6, false);
    account(&device, &server);
}

#[test]
fn a_minute_under_load_loses_nothing_uncounted_and_no_memory() {
    if std::env::var_os("CA_LONG").is_none() {
        return;
    }
    let (device, server, _) = played(12, false);
    account(&device, &server);
    table("without load", &device, &server);
    let (device, server, [early, late]) = played(60, true);
    account(&device, &server);
    table("both cores busy", &device, &server);
    eprintln!("memory of the server: {early} kB after ten seconds, {late} kB after fifty");
    assert!(late <= early + 2048, "{early} kB, then {late} kB");
}
