//! Compares the closed loop through shared memory with theory: the figures of the single-process loops
//! (docs/numerics.md §5.2, §5.3), here with two processes, gateway, rings and frames. Lock-step makes the loop
//! reproducible.

use crate::sandbox::Sandbox;

/// Record of a run: positions per frame \[m\], and the log as text.
struct Run {
    x: Vec<f64>,
    text: String,
}

/// The device of E02: 0.2 kg, 2 N s/m, without limits or delays.
fn profile(force: f64, passivity: bool) -> String {
    format!(
        r#"
name = "key"
title = "one key"
source = "E02"
dof = 1
range = [-1000, 1000]
force = {force:e}
rate = 3000
[body]
mass = 0.2
friction = 2.0
[guard]
speed = 20
slew = 1e8
edge = 0
passivity = {passivity}
coupling = false
oscillation = false
clear = 1
clear_time = 0.01
ramp = 0.01
ttl = 0.1
"#
    )
}

/// Plays `model` in lock-step for `seconds` of the loop. If the machine stalls longer than the engine waits, the engine
/// adds a frame, so the run is repeated.
fn run(model: &str, profile: &str, push: &str, delay: &str, seconds: &str) -> Run {
    for _ in 0..10 {
        let sandbox = Sandbox::new();
        sandbox.put("c/profiles/key.toml", profile).put("loop.ca.toml", model);
        let server = sandbox.serve("loop.ca.toml", &["--arm", "--clock", "device", "--json"]);
        let args = ["--script", "push", "--push", push, "--delay", delay, "--seconds", seconds];
        let device = sandbox.key(&[&args[..], &["--lockstep", "--force-log", "felt.csv", "--json"]].concat());
        let seen = device.end().is(0).json();
        let reported = server.stop().json();
        let text = sandbox.read("felt.csv");
        // after the device ends, the engine waits in vain at least once
        let alone = reported["frames"].as_u64().unwrap() - reported["devices"][0]["frames"].as_u64().unwrap();
        let lost = seen["asked_again"].as_u64().unwrap() + reported["faults"].as_array().unwrap().len() as u64;
        if lost == 0 && alone < 40 && is_whole(&text) {
            let x = text.lines().skip(1).map(|l| l.split(',').nth(7).unwrap().parse().unwrap()).collect();
            return Run { x, text };
        }
    }
    panic!("this machine stands still for a tenth of a second in each of ten runs");
}

/// Returns true if every position was answered by the next force, from the first answer on.
fn is_whole(log: &str) -> bool {
    let seq: Vec<u64> = log.lines().skip(1).map(|l| l.split(',').nth(2).unwrap().parse().unwrap()).collect();
    seq.windows(2).all(|w| w[1] == w[0] + 1)
}

fn spring(k: f64) -> String {
    let key = crate::sandbox::KEY.replace("0.9 mm", "0 mm").replace("k = 500", &format!("k = {k:e}"));
    assert!(key.contains(&format!("{k:e}")));
    key
}

fn swing(x: &[f64]) -> f64 {
    x.iter().fold(f64::MIN, |a, b| a.max(*b)) - x.iter().fold(f64::MAX, |a, b| a.min(*b))
}

/// Returns true if the oscillation of a key on a spring grows.
fn grows(k: f64, delay: &str) -> bool {
    // a force step of any size, because the loop is linear
    let r = run(&spring(k), &profile(1000.0, false), "1e-6", delay, "2");
    let (early, late) = (swing(&r.x[1000..2000]), swing(&r.x[5000..6000]));
    assert!(early > 0.0);
    late > early
}

#[test]
fn e02_the_stiffest_key_across_shared_memory_is_that_of_theory() {
    // κ = 1: the force of a frame is held during the next; κ = 2: one frame later, as in free-running devices
    for (delay, limit) in [("0", 6006.664), ("1", 3004.161)] {
        assert!(!grows(0.98 * limit, delay), "stable below {limit} N/m");
        assert!(grows(1.02 * limit, delay), "unstable above {limit} N/m");
    }
}

/// Peak-to-peak motion \[m\] in the last half second, for a wall of stiffness `k` pressed with 2 N for five seconds.
fn pressed(k: f64, passivity: bool, force: f64) -> f64 {
    let wall = format!(
        "[TGR]\nkey = {{ device = \"key\", dof = 0 }}\n[SOL]\nwall = {{}}\n[BUT]\nstop = {{ between = [\"wall\", \"key\"], k = {k:e} }}\n"
    );
    let r = run(&wall, &profile(force, passivity), "-2", "0", "5");
    swing(&r.x[r.x.len() - 1500..])
}

#[test]
fn h12_a_pressed_wall_swings_as_theory_says_and_less_with_the_stage() {
    let free = pressed(20_000.0, false, 100.0);
    // docs/numerics.md §5.3: 2970 um, three digits
    assert!((free / 2970e-6 - 1.0).abs() < 0.005, "{free}");
    let held = pressed(20_000.0, true, 100.0);
    assert!(held < free, "{held}");
    // near the limit, where it rings for a long time
    let (free, held) = (pressed(5500.0, false, 100.0), pressed(5500.0, true, 100.0));
    assert!(free > 50e-6 && held < 5e-6, "{free} {held}");
}

#[test]
fn in_lock_step_the_loop_is_the_same_every_time() {
    let p = profile(1000.0, true);
    let p = p.replace("friction = 2.0", "friction = 2.0\nnoise = 1e-6\nstep = 1e-7");
    let [a, b] = [0, 1].map(|_| run(&spring(2000.0), &p, "0.5", "1", "1").text);
    let parts = |t: &str| t.lines().map(|l| l.splitn(8, ',').nth(7).unwrap().to_owned()).collect::<Vec<_>>();
    let (a, b) = (parts(&a), parts(&b));
    let first = a.iter().zip(&b).position(|(a, b)| a != b);
    assert_eq!(first.map(|i| (i, &a[i], &b[i])), None, "the first line that differs");
    assert!(a.len() == 3001 && b.len() == 3001 && swing(&run(&spring(2000.0), &p, "0.6", "1", "1").x) > 0.0);
}
