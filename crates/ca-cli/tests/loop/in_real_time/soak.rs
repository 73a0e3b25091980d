//! Plays for a minute with both cores busy (long form only). Every frame must be accounted for, and no memory may leak.
//! `tests/alloc` checks that the engine thread allocates nothing, and the bench `latency` measures delays.

use crate::force_watcher::{ForceWatcher, Seen, key};
use crate::helper_process;
use crate::long_form::long_form;
use crate::sandbox::{Sandbox, until};
use serde_json::Value;
use std::fs;
use std::time::{Duration, Instant};

fn resident(id: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

struct Played {
    device: Value,
    server: Value,
    /// Memory of the server after a sixth of the time and at the end \[kB\].
    memory: [u64; 2],
    forces: Seen,
}

fn played(seconds: u64, load: bool) -> Played {
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let server = sandbox.serve("key.ca.toml", &["--json"]);
    let load = load.then(|| helper_process::load(&sandbox.site));
    let mut device = sandbox.key(&["--script", "shake", "--seconds", &seconds.to_string(), "--json"]);
    sandbox.arm();
    // device frames are the clock of this test; a stalled device has fewer
    let early = 3000 * seconds / 6;
    let waited = Instant::now() + Duration::from_secs(30 + seconds);
    while sandbox.state().2 < early && device.is_running() {
        assert!(Instant::now() < waited, "{early} frames do not come: {:?}", sandbox.state());
        std::thread::sleep(Duration::from_millis(50));
    }
    let early = resident(server.id());
    let device = device.end().is(0).json();
    let mut frames = 0;
    until("the server has all", || {
        let now = sandbox.state().2;
        std::mem::replace(&mut frames, now) == now
    });
    let memory = [early, resident(server.id())];
    let server = server.stop().json();
    for l in load.into_iter().flatten() {
        l.end();
    }
    Played { device, server, memory, forces: watch.end(&key()) }
}

fn number(v: &Value, path: &[&str]) -> u64 {
    path.iter().fold(v, |v, k| &v[*k]).as_u64().unwrap_or_else(|| panic!("no {path:?} in {v:#}"))
}

/// Checks that every frame is accounted for.
fn account(p: &Played) {
    let Played { device, server, forces, .. } = p;
    // counted from the first answered frame; before it, the lines were being opened
    let sent = number(device, &["frames"]) + 1 - number(device, &["first_answered"]);
    let t = |k: &str| number(server, &["traffic", k]);
    let (received, missed) = (t("received") - t("unclaimed"), t("missed"));
    // the queue holds four: the last frames may be lost when the device leaves, and the first answer may refer to the
    // last of several
    assert!(sent.abs_diff(received + missed) <= 4, "{sent} sent, {received} + {missed}");
    assert_eq!(t("foreign"), 0);
    assert_eq!(number(server, &["lost_records"]), 0);
    assert_eq!(received - t("full"), number(&server["devices"][0], &["frames"]), "what came went to the engine");
    // every force of the engine is sent or counted; the last one reports that forces are off
    let (made, left) =
        (number(server, &["frames"]), t("unsent") + t("unclaimed_forces") + number(server, &["lost_forces"]));
    assert_eq!(t("sent") + left, made);
    // the watcher saw each one or knows that it is missing
    let seen = forces.frames.len() as u64;
    assert_eq!(seen + forces.unseen, made, "{seen} forces seen, {} missing by number", forces.unseen);
    eprintln!(
        "positions: {sent} sent = {received} taken + {missed} missed by number, {} of them not used; \
         periods left out: {} by the device, {} by the engine",
        t("full"),
        device["left_out"],
        server["missed"]
    );
    eprintln!("forces: {made} made = {} sent + {left} counted as lost; {seen} watched", t("sent"));
}

#[test]
fn every_frame_is_accounted_for() {
    account(&played(6, false));
}

#[test]
fn a_minute_under_load_loses_nothing_uncounted_and_no_memory() {
    if !long_form("all of it") {
        return;
    }
    let p = played(60, true);
    account(&p);
    let [early, late] = p.memory;
    eprintln!("memory of the server: {early} kB after ten seconds, {late} kB at the end");
    // a margin of a few pages; a leak of 8 bytes per frame would exceed it
    assert!(late <= early + 1024, "{early} kB, then {late} kB");
}
