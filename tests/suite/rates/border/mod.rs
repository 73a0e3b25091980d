//! The rate boundary: the energy that the hand gives is the energy that the scene receives.

mod degraded;
mod device_loop;
mod images;
mod space;

use crate::play::{Random, TURN, audited, case, mat, num, within};
use ca_core::internal::border::frame_due;
use ca_core::{Scene, compute_forces, integrate};

/// Tolerance of the energy balance, far below the tolerance of its case.
const EXACT: f64 = 1e-15;

const SPRING: &str = "[REF]\nlink = { between = [\"key\", \"wall\"], k = 2e4, z = 0.05 }\n";
const ONE_SIDED: &str = "[BUT]\nlink = { between = [\"key\", \"wall\"], k = 2e4, z = 0.05, d = 0 }\n";

const INSTRUMENT: &str = r#"
[TGR]
key = {}
[MAS]
hammer = { m = "5 g", x = "4 mm", v = "0.1 m/s" }
[REF]
shank = { between = ["key", "hammer"], k = "2 kN/m", z = "0.05 N s/m" }
[STRING]
low = { n = 10, f = "110 Hz", t60 = "1 s", m = "1 g", x = "8 mm" }
[BUT]
strike = { between = ["hammer", "low[3]"], k = "20 kN/m", z = "0.5 N s/m" }
[SOX]
out = { from = "low[5]" }
"#;

fn held(sound: u32, gesture: u32, link: &str) -> Scene {
    held_by("linear", sound, gesture, link)
}

fn held_by(border: &str, sound: u32, gesture: u32, link: &str) -> Scene {
    let rate = format!("sound = {sound}\ngesture = {gesture}\nborder = \"{border}\"");
    audited(&format!("[rate]\n{rate}\n[SOL]\nwall = {{}}\n[TGR]\nkey = {{}}\n{link}")).scene
}

/// The hand motion of E01, at rest at the end so that the last frame is complete.
fn hand(frames: usize, rate: f64) -> Vec<f64> {
    let mut rng = Random(43);
    let mut walk = 0.0;
    let mut x: Vec<f64> = (0..frames)
        .map(|n| {
            let t = n as f64 / rate;
            walk += 1e-5 * rng.uniform();
            3e-3 * (TURN * 7.0 * t).sin() + 1e-3 * (TURN * 43.0 * t + 1.0).sin() + walk
        })
        .collect();
    let last = x[frames - 1];
    x.extend([last; 2]);
    x
}

/// Energies of a run.
struct Played {
    /// Σ F̄ ΔX over frames: work of the hand on the scene
    frames: f64,
    /// Σ f_j (X_{j+1} − X_{j−1})/2 over ticks
    ticks: f64,
    /// the same from the ledger of the port
    ledger: f64,
    /// the same from the ledger of the boundary, frame by frame
    received: f64,
    /// Σ|P|
    scale: f64,
    /// residual of the whole ledger, relative to its peak
    residual: f64,
}

fn play(scene: &Scene, x: &[f64]) -> Played {
    let key = mat(scene, "key");
    let mut s = scene.state();
    let (mut frame, mut frames) = (0, 0.0);
    let (mut positions, mut forces) = (Vec::new(), Vec::new());
    s.input[0] = x[0];
    loop {
        if frame_due(scene, s.tick) && s.tick > 0 {
            frame += 1;
            if frame == x.len() {
                break;
            }
            s.input[0] = x[frame];
        }
        compute_forces(scene, &mut s);
        positions.push(s.x[key]);
        forces.push(s.f[key]);
        let last = s.tick > 0 && s.tick.is_multiple_of(u64::from(scene.rates.ratio));
        if last {
            frames -= s.ports.border[0].force * (x[frame] - x[frame - 1]);
        }
        integrate(scene, &mut s);
    }
    let at = |j: usize| positions[j.min(positions.len() - 1)];
    let power: Vec<f64> = (0..forces.len()).map(|j| -forces[j] * 0.5 * (at(j + 1) - at(j.saturating_sub(1)))).collect();
    let ledger = s.ledger.as_ref().expect("a ledger");
    let b = ledger.balance();
    Played {
        frames,
        ticks: power.iter().sum(),
        ledger: ledger.work[0],
        received: ledger.hands[0].received,
        scale: power.iter().map(|p| p.abs()).sum(),
        residual: b.residual.abs() / b.peak,
    }
}

#[test]
fn e01_the_border_makes_nothing() {
    assert!(EXACT <= num(case("E01"), "tolerance/rel"));
    for (sound, gesture) in [(48_000, 3000), (44_100, 2940), (48_000, 24_000), (48_000, 1000), (3000, 3000)] {
        let x = hand(gesture as usize, f64::from(gesture));
        for (name, link) in [("spring", SPRING), ("one-sided", ONE_SIDED)] {
            for border in ["linear", "hold"] {
                let scene = held_by(border, sound, gesture, link);
                assert_eq!(scene.rates.ratio, sound / gesture);
                let p = play(&scene, &x);
                let what = format!("E01 {name}, {border}, R = {}", scene.rates.ratio);
                assert!(p.scale > 1e-3);
                within(&format!("{what}, by the ledger"), (p.ticks - p.ledger).abs() / p.scale, EXACT);
                within(&format!("{what}, by the ledger"), (p.received - p.ticks).abs() / p.scale, EXACT);
                within(&format!("{what}, residual"), p.residual, 1e-12);
                if scene.rates.ratio > 1 {
                    within(&what, (p.frames - p.ticks).abs() / p.scale, EXACT);
                } else {
                    // at one rate the force of the tick itself is sent, which does make energy
                    assert!((p.frames - p.ticks).abs() > 1e-4 * p.scale, "{what}");
                }
            }
        }
    }
}

#[test]
fn e01_with_an_instrument_behind_the_key() {
    for border in ["linear", "hold"] {
        let text = format!("[rate]\nborder = \"{border}\"\n{INSTRUMENT}");
        let p = play(&audited(&text), &hand(3000, 3000.0));
        let what = format!("E01 an instrument, {border}");
        within(&what, (p.frames - p.ledger).abs() / p.scale, EXACT);
        within(&format!("{what}, by ticks"), (p.frames - p.ticks).abs() / p.scale, EXACT);
        within(&format!("{what}, by the ledger"), (p.received - p.ticks).abs() / p.scale, EXACT);
        within(&format!("{what}, residual"), p.residual, 1e-12);
    }
}

#[test]
fn force_is_that_on_the_hand() {
    // the key is 1 mm above a wall it is tied to: the spring pulls the hand down
    for (sound, gesture) in [(48_000, 3000), (3000, 3000)] {
        let scene = held(sound, gesture, "[RES]\nlink = { between = [\"wall\", \"key\"], k = 2e4 }\n");
        let mut s = scene.state();
        s.input[0] = 1e-3;
        (0..=scene.rates.ratio).for_each(|_| ca_core::tick(&scene, &mut s));
        within("20 N towards the wall", (s.ports.border[0].force + 20.0).abs(), 1e-12);
    }
    // a buffer below a key that dips into it pushes up
    let scene = held(48_000, 3000, "[BUT]\nlink = { between = [\"wall\", \"key\"], k = 2e4 }\n");
    let mut s = scene.state();
    s.input[0] = -1e-3;
    (0..=scene.rates.ratio).for_each(|_| ca_core::tick(&scene, &mut s));
    within("20 N out of the wall", (s.ports.border[0].force - 20.0).abs(), 1e-12);
}

#[test]
fn at_one_rate_the_force_is_that_of_the_tick() {
    let scene = held(3000, 3000, SPRING);
    assert_eq!(scene.rates.ratio, 1);
    let key = mat(&scene, "key");
    let mut s = scene.state();
    for x in hand(300, 3000.0) {
        s.input[0] = x;
        compute_forces(&scene, &mut s);
        if s.tick > 0 {
            assert_eq!(s.ports.border[0].force, s.f[key]);
            assert_eq!(s.x[key], x);
        }
        integrate(&scene, &mut s);
    }
}
