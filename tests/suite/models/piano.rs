//! The hammer piano: its twelve pitches, dynamics, pedals and release, and the page `docs/measured/hammer-piano.md`.
//!
//! The page is measured with a finger that follows a list of positions, through the engine and the guard of a TGR:
//! force at the key, sound, and energy flow. `UPDATE=1 cargo test $ALL --test suite -- hammer_piano` rewrites it.

use super::rendering::{Rendering, by_hand, count_contacts, load, play};
use crate::acoustics::{centroid, cents, db, partial, peak, rms, t60};
use ca_compile::{Options, compile};
use ca_core::Scene;
use ca_core::equivalence::Gains;
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{Engine, EngineCommand, Options as EngineOptions, Port, Setup};
use ca_haptic::equivalence::gains;
use ca_haptic::frame::{DeviceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_model::Model;
use ca_tests::long_form::long_form;
use std::fmt::Write as _;
use std::sync::Arc;

/// Position of a key at rest, and where it meets its bed [m].
pub const UP: f64 = -8e-3;
pub const BED: f64 = 1.2e-3;

/// A press of `speed` [m/s] at 0.1 s to just within the bed, held until `to` [s], then released.
pub fn press(speed: f64, to: f64) -> Vec<(f64, f64)> {
    vec![(0.0, UP), (0.1, UP), (0.1 + 9.3e-3 / speed, 1.3e-3), (to, 1.3e-3), (to + 0.06, UP)]
}

/// Plays one key of a model alone, pressed at `speed` and held until `to`.
pub fn one_key(model: &Model, key: &str, probes: &[&str], speed: f64, to: f64, seconds: f64) -> Rendering {
    by_hand(model, probes, &[(key, &press(speed, to))], seconds)
}

pub fn hammer_piano() {
    let strikes: Vec<String> =
        (0..12).flat_map(|i| [format!("key[{i}].strike"), format!("key[{i}].strike2")]).collect();
    let h = play("hammer_piano", &strikes.iter().map(String::as_str).collect::<Vec<_>>());
    // one contact per stroke of the gesture
    let strokes = [3, 1, 2, 1, 3, 2, 1, 3, 1, 2, 1, 2];
    for (i, n) in strokes.into_iter().enumerate() {
        assert_eq!(count_contacts(&h.probe[2 * i], h.rate), n, "key {i}");
    }
    // una corda leaves the second string unstruck
    assert!(peak(h.probed(0, 3.6, 4.0)) > 0.0 && peak(h.probed(1, 0.1, 0.4)) > 0.0);
    assert_eq!(peak(h.probed(1, 3.6, 4.0)), 0.0);
    // with the pedal it rings on after its keys are up, and stops when the pedal does
    let level = |t0: f64, t1: f64| db(rms(h.at(0, t0, t1)));
    assert!(level(7.3, 7.5) > level(6.2, 6.4) - 25.0 && level(8.1, 8.3) < level(7.3, 7.5) - 20.0);
    let long =
        long_form("eleven of twelve keys by themselves, and how one is heard that is hit harder, held and let go");
    for i in 0..if long { 12 } else { 1 } {
        let want = 440.0 * 2f64.powf((f64::from(i) - 9.0) / 12.0);
        let alone = one_key(&h.model, &format!("key[{i}].key"), &[&strikes[2 * i as usize]], 0.3, 2.0, 1.6);
        let found = partial(alone.at(0, 0.3, 1.5), alone.rate, want, 10.0).0;
        assert_eq!(count_contacts(&alone.probe[0], h.rate), 1, "key {i}");
        assert!(cents(found, want).abs() < 2.0, "key {i}: {found:.2} Hz, not {want:.2} Hz");
    }
    if !long {
        return;
    }
    for (speed, f) in [(0.08, 324.0), (0.58, 641.0)] {
        let x = one_key(&h.model, "key[0].key", &[], speed, 1.1, 1.1);
        let is = centroid(x.at(0, 0.1, 1.1), h.rate);
        assert!((is / f - 1.0).abs() < 0.2, "{speed} m/s: {is:.0} Hz, not {f} Hz");
    }
    let long = one_key(&h.model, "key[0].key", &[], 0.3, 6.0, 6.0);
    let (early, late) = (t60(long.at(0, 0.2, 1.0), h.rate, 261.63), t60(long.at(0, 3.0, 5.9), h.rate, 261.63));
    assert!((1.6..3.2).contains(&early) && (7.0..15.0).contains(&late), "T60 {early:.2} s, then {late:.2} s");
    // after a release the level falls by 40 dB within 0.3 s
    let short = one_key(&h.model, "key[0].key", &[], 0.3, 0.8, 1.3);
    let fell = db(rms(short.at(0, 0.7, 0.8)) / rms(short.at(0, 1.1, 1.2)));
    assert!(fell > 40.0, "{fell:.1} dB");
    let slow = one_key(&h.model, "key[0].key", &["key[0].strike"], 0.05, 0.5, 0.5);
    assert_eq!(peak(&slow.probe[0]), 0.0);
    // except for the dampers, which settle at load and then lift
    let heard = peak(slow.at(0, 0.3, 0.5));
    assert!(heard < 2e-3, "{:.1} dBFS", db(heard));
    // twelve keys that are pressed when their device connects are silent too
    let mut found = Finger::at("hammer_piano", 0.0);
    found.stay(1.5);
    assert_eq!(found.engine.ports[0].hand.arrived, u32::MAX);
    assert!(peak(&found.sound) < 2e-3, "{:.1} dBFS", db(peak(&found.sound)));
}

/// A finger on the first key of a TGR, with the engine.
pub struct Finger {
    scene: Arc<Scene>,
    engine: Engine,
    frame: DeviceFrame,
    /// Position [m].
    x: f64,
    /// Force of the last frame [N], as sent.
    force: f64,
    /// Work done against the forces sent [J].
    work: f64,
    /// All sound so far.
    pub sound: Vec<f64>,
}

impl Finger {
    /// A finger at rest on a key, with forces on.
    pub fn new(model: &str) -> Finger {
        let mut f = Finger::at(model, UP);
        f.engine.command(EngineCommand::Order(None, Order::Arm));
        f.stay(1.2);
        assert_eq!(f.engine.ports[0].out.mode, Mode::On as u32, "forces are not on");
        f
    }

    /// A device with all keys at `x`, before its first frame.
    pub fn at(model: &str, x: f64) -> Finger {
        let options = Options { energy: true, ..Options::default() };
        let scene = Arc::new(compile(&load(model), &ca_tests::catalog(), &options).expect("it compiles").scene);
        let gains = gains(&scene, "tgr12");
        assert!(gains.iter().all(|g| *g == Gains::default()), "{gains:?}");
        // the forces of the model, without the stages of the guard that change them
        let mut profile = Profile::shipped("tgr12").expect("shipped");
        (profile.guard.passivity, profile.guard.oscillation, profile.guard.edge) = (false, false, 0.0);
        let setup = Setup { device: "tgr12".into(), profile, calibration: Calibration::default(), gains };
        let port = Port::new(&scene, setup);
        let engine = Engine::new(scene.clone(), vec![port], EngineOptions::default());
        let mut frame = DeviceFrame::new("tgr12", 12);
        frame.session = 1;
        frame.pos[..12].fill(x);
        Finger { scene, engine, frame, x, force: 0.0, work: 0.0, sound: Vec::new() }
    }

    /// Moves to `x` for one gesture frame and receives the force.
    pub fn to(&mut self, x: f64) {
        // the force that was sent is held during the motion
        self.work -= self.force * (x - self.x);
        self.x = x;
        self.frame.seq += 1;
        self.frame.t_device_ns = self.frame.seq * 333_333;
        self.frame.pos[0] = x;
        self.engine.take(0, &mut self.frame);
        self.force = f64::from(self.engine.answer().next().expect("one device").force[0]);
        self.sound.extend(self.engine.finish());
        assert_eq!(self.engine.counts.faults, 0, "the guard tripped at {x} m");
    }

    pub fn stay(&mut self, seconds: f64) {
        (0..(seconds * 3000.0) as usize).for_each(|_| self.to(self.x));
    }

    /// Moves in a straight line; returns position and force of each frame.
    pub fn line(&mut self, to: f64, speed: f64) -> Vec<[f64; 2]> {
        let (from, n) = (self.x, ((to - self.x).abs() / speed * 3000.0).ceil());
        (1..=n as usize)
            .map(|i| {
                self.to(from + (to - from) * i as f64 / n);
                [self.x, self.force]
            })
            .collect()
    }
}

/// Formats a value in thousandths with three digits.
fn milli(v: f64) -> String {
    // no minus sign before zero
    let v = 1e3 * v + 0.0;
    let digits = if v == 0.0 { 1 } else { (2 - v.abs().log10().floor() as i32).max(0) as usize };
    if v != 0.0 && v.abs() < 1e-3 { format!("{v:.1e}") } else { format!("{v:.digits$}") }
}

/// The page, and the worst residual relative to the energy given.
fn page() -> (String, f64) {
    let mut out = String::from(
        "# How the hammer piano feels, and where the energy of the finger goes\n\n\
         Made by `UPDATE=1 cargo test $ALL --test suite -- hammer_piano` ($ALL is in CONTRIBUTING.md): do not edit.\n\n\
         Key `key[0].key` (C4) of `models/hammer_piano.ca.toml`, through the engine and the guard of a TGR (`tgr12`, 3 kHz), by\n\
         a finger that follows a list of positions whatever the force. The key rests at 0 and meets its bed at 9.2 mm; forces\n\
         are the forces sent to the device, positive against the finger.\n\n\
         ## A slow press\n\n\
         Down at 10 mm/s to 1 mm within the bed, and up again: the weight of the key, the damper from 3 mm on, the hammer, the\n\
         let-off at 8.8 mm and the bed. The hammer does not reach the string; the sound of the lifting damper is below -54\n\
         dBFS.\n\n\
         | depth (mm) | down (N) | up (N) |\n|---|---|---|\n",
    );
    let mut f = Finger::new("hammer_piano");
    let down = f.line(BED + 1e-3, 0.01);
    f.stay(0.2);
    let up = f.line(UP, 0.01);
    for mm in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 8.5, 8.8, 9.0, 9.2, 10.0] {
        let x = UP + mm * 1e-3;
        let _ = writeln!(out, "| {mm} | {:.3} | {:.3} |", felt(&down, x) + 0.0, felt(&up, x) + 0.0);
    }
    assert!(peak(&f.sound) < 2e-3, "a slow key is heard: {:.1} dBFS", db(peak(&f.sound)));

    out += "\n## A fast press\n\n\
            Down to the bed in a straight line, held for half a second, and up at 0.1 m/s. *Travel* is the largest force on the\n\
            way: inertia of tail, jack and hammer, transmitted by the lever of the key, and the let-off. The level is the level of\n\
            the loudest sample, the centroid is taken from the spectrum of the half second.\n\n\
            | speed (m/s) | travel (N) | level (dBFS) | centroid (Hz) |\n|---|---|---|---|\n";
    let speeds = [0.05, 0.08, 0.12, 0.2, 0.28, 0.36, 0.45];
    let mut energy: Vec<[f64; ROWS.len()]> = Vec::new();
    let mut levels = Vec::new();
    for speed in speeds {
        let mut f = Finger::new("hammer_piano");
        let start = f.sound.len();
        let travel = f.line(BED, speed).iter().fold(0.0, |m: f64, p| m.max(-p[1]));
        f.stay(0.5);
        let x: Vec<f64> = f.sound[start..].iter().step_by(2).copied().collect();
        f.line(UP, 0.1);
        f.stay(0.5);
        let level = db(peak(&x));
        let heard =
            if level < -50.0 { "silent | –".into() } else { format!("{level:.1} | {:.0}", centroid(&x, 48e3)) };
        levels.push(level);
        let _ = writeln!(out, "| {speed} | {travel:.3} | {heard} |");
        energy.push(account(&f));
    }
    assert!(levels.windows(2).all(|w| w[0] < w[1]), "faster is not louder: {levels:?}");

    out += "\n## Energy from finger to string\n\n\
            The same presses, from the first motion to half a second after the key is up again, in millijoules. The energy given\n\
            by the finger is the force sent times its motion; the border makes the rest, because it answers a frame late, and the\n\
            model receives the sum. *Residual* is the energy that the rows do not account for.\n\n| mJ |";
    for speed in speeds {
        let _ = write!(out, " {speed} m/s |");
    }
    out += "\n|---|";
    out += &"---|".repeat(speeds.len());
    for (i, row) in ROWS.iter().enumerate() {
        let _ = write!(out, "\n| {row} |");
        for e in &energy {
            let _ = write!(out, " {} |", milli(e[i]));
        }
    }
    out += "\n| residual |";
    let mut worst: f64 = 0.0;
    for e in &energy {
        let residual = e[0] + e[1] - e[3..].iter().sum::<f64>();
        worst = worst.max(residual.abs() / e[0].abs());
        let _ = write!(out, " {} |", if residual.abs() <= 1e-9 * e[0].abs() { "< 1e-9 of it" } else { "too large" });
    }
    out.push('\n');
    (out, worst)
}

/// Force against the finger [N] at the point of a path (position, force) nearest to `x` [m].
pub fn felt(path: &[[f64; 2]], x: f64) -> f64 {
    path.iter().min_by(|a, b| (a[0] - x).abs().total_cmp(&(b[0] - x).abs())).map_or(0.0, |p| -p[1])
}

/// Rows of the energy table. The third, received, is the sum of the first two and of all that follow.
const ROWS: [&str; 11] = [
    "given by the finger",
    "made by the border",
    "= received by the model",
    "lost at key and tail",
    "lost at the jack",
    "lost where the hammer rests and is checked",
    "lost in the felt of the hammer",
    "lost in the damper",
    "lost in strings, pins and board",
    "still in motion",
    "error of the scheme",
];

/// Links of the action that lose energy, for the rows from the fourth on.
const LINKS: [&[&str]; 6] = [
    &["drag"],
    &["fall", "escape", "let_off"],
    &["push", "rest", "check"],
    &["strike", "strike2"],
    &["lift", "mute"],
    &["link", "ties", "foot"],
];

/// Energy [J] for each of `ROWS`.
fn account(f: &Finger) -> [f64; ROWS.len()] {
    let ledger = f.engine.state.ledger.as_ref().expect("the ledger is kept");
    let hand =
        f.scene.ports.tgr.iter().position(|p| f.scene.inputs[p.input as usize].name == "key[0].key").expect("the key");
    let (received, given) = (ledger.hands[hand].received, ledger.hands[hand].given);
    // the ledger of the rate boundary agrees with the single-precision forces on the wire
    assert!((f.work / given - 1.0).abs() < 1e-6, "the finger worked {} J, the ledger says {given} J", f.work);
    let lost = |names: &[&str]| -> f64 {
        let last = |n: std::borrow::Cow<str>| n.rsplit('.').next().map(|n| n.split('[').next().unwrap_or(n).to_owned());
        let of = |i: usize| f.scene.audited_name(i).and_then(last).is_some_and(|n| names.contains(&n.as_str()));
        ledger.lost.iter().enumerate().filter(|(i, _)| of(*i)).map(|(_, l)| l).sum()
    };
    let links = LINKS.map(lost);
    let all: f64 = ledger.lost.iter().sum();
    assert!(
        (links.iter().sum::<f64>() - all).abs() <= 1e-12 * all,
        "heat in a link that is not in the table: {:?}",
        (0..ledger.lost.len()).filter(|i| ledger.lost[*i] != 0.0).find_map(|i| f.scene.audited_name(i))
    );
    let [key, jack, hammer, felt, damper, strings] = links;
    let made = -ledger.scheme_error.iter().sum::<f64>();
    let moving = ledger.h - ledger.h0;
    [given, received - given, received, key, jack, hammer, felt, damper, strings + ledger.lost_mats, moving, made]
}

#[test]
fn the_page_of_the_hammer_piano_holds() {
    if !long_form("the page of the hammer piano") && std::env::var_os("UPDATE").is_none() {
        return;
    }
    let (want, worst) = page();
    println!("hammer piano: worst residual {worst:.2e} of the energy given");
    assert!(worst <= 1e-9, "the energy of the finger is not accounted for: {worst:e}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/measured/hammer-piano.md");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(path, &want).expect("docs/ is there");
    }
    let is = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        is == want,
        "docs/measured/hammer-piano.md is stale; run `UPDATE=1 cargo test $ALL --test suite -- hammer_piano`\n{want}"
    );
}
