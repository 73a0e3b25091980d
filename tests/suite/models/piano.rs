//! The hammer piano: its twelve pitches, and the page `docs/measured/hammer-piano.md`, made by a finger that is a list of
//! positions, through the engine and the guard of a TGR: how a key feels, what is heard, and where the energy goes.
//!
//! `UPDATE=1 cargo test -p ca-tests hammer_piano` writes the page anew.

use super::heard::{load, perform, play, scene};
use crate::acoustics::{cents, db, partial, peak};
use ca_compile::{Options, compile};
use ca_core::Scene;
use ca_core::equivalence::Gains;
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{Engine, EngineCommand, Options as EngineOptions, Port, Setup};
use ca_haptic::equivalence::gains;
use ca_haptic::frame::{DeviceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_io::gesture::{Gesture, Track};
use std::fmt::Write as _;
use std::sync::Arc;

const KEYS: [&str; 12] = ["c", "cis", "d", "dis", "e", "f", "fis", "g", "gis", "a", "ais", "b"];
/// Where a key rests, and where it meets its bed [m].
const UP: f64 = -8e-3;
const BED: f64 = -1e-3;

/// Moves one key, keeps the others.
fn one_key(key: &str, points: &[(f64, f64)]) -> Gesture {
    let track = |name: &str| {
        let own = if name == key { points.to_vec() } else { vec![(0.0, UP)] };
        Track::points(name, own).unwrap()
    };
    Gesture::new(KEYS.iter().map(|k| track(k)).collect()).unwrap()
}

pub fn hammer_piano() {
    let h = play("hammer_piano", &["strike_c", "strike_ais", "stop[0]"]);
    // the first note of the phrase and the last of the twelve: struck once, and free again
    for (i, t) in [(0, 0.1), (1, 0.1 + 11.0 * 0.26)] {
        assert!(peak(h.probed(i, t, t + 0.1)) > 1.0, "hammer {i} does not strike");
        assert_eq!(peak(h.probed(i, t + 0.2, t + 0.5)), 0.0, "hammer {i} stays");
    }
    assert!(peak(h.probed(2, 0.13, 0.5)) > 0.5, "the key does not meet its bed");
    // each key by itself sounds its note of equal temperament
    let scene = scene(&h.model, &[]);
    for (i, key) in KEYS.iter().enumerate() {
        let press = [(0.0, UP), (0.05, UP), (0.067, -0.9e-3), (1.0, -0.9e-3)];
        let alone = perform(load("hammer_piano"), &scene, Some(&one_key(key, &press)), 1.0);
        let want = 440.0 * 2f64.powf((i as f64 - 9.0) / 12.0);
        let found = partial(alone.at(0, 0.2, 1.0), alone.rate, want, 10.0).0;
        assert!(cents(found, want).abs() < 3.0, "{key}: {found:.2} Hz, not {want:.2} Hz");
    }
    // a key that goes down slowly is silent
    let slow = perform(load("hammer_piano"), &scene, Some(&one_key("c", &[(0.0, UP), (0.5, -0.9e-3)])), 1.0);
    assert_eq!(peak(&slow.sound[0]), 0.0);
    // and so are twelve keys that stand pressed when their device appears
    let mut found = Finger::at(0.0);
    found.stay(1.5);
    assert_eq!(found.engine.ports[0].hand.met, u32::MAX);
    assert_eq!(peak(&found.sound), 0.0);
}

/// A finger on the key `c` of a TGR, and the engine that answers.
struct Finger {
    scene: Arc<Scene>,
    engine: Engine,
    frame: DeviceFrame,
    /// where it is [m]
    x: f64,
    /// force on it, of the last frame [N], as sent
    force: f64,
    /// work it has done against the forces sent [J]
    work: f64,
    /// sound of everything so far
    sound: Vec<f64>,
}

impl Finger {
    /// At rest on a key whose forces are on.
    fn new() -> Finger {
        let mut f = Finger::at(UP);
        f.engine.command(EngineCommand::Order(None, Order::Arm));
        f.stay(1.2);
        assert_eq!(f.engine.ports[0].out.mode, Mode::On as u32, "forces are not on");
        f
    }

    /// A device whose keys all stand there, not heard of yet.
    fn at(x: f64) -> Finger {
        let options = Options { energy: true, ..Options::default() };
        let scene =
            Arc::new(compile(&load("hammer_piano"), &ca_tests::catalog(), &options).expect("it compiles").scene);
        let gains = gains(&scene, "tgr12");
        assert_eq!(gains, [Gains::default(); 12]);
        // the model as it is: what the guard takes from it has tests of its own
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

    /// Goes to a place and hears the answer: one gesture frame.
    fn to(&mut self, x: f64) {
        // what was sent is held while it moves
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

    fn stay(&mut self, seconds: f64) {
        (0..(seconds * 3000.0) as usize).for_each(|_| self.to(self.x));
    }

    /// In a straight line; gives place and force of each frame.
    fn line(&mut self, to: f64, speed: f64) -> Vec<[f64; 2]> {
        let (from, n) = (self.x, ((to - self.x).abs() / speed * 3000.0).ceil());
        (1..=n as usize)
            .map(|i| {
                self.to(from + (to - from) * i as f64 / n);
                [self.x, self.force]
            })
            .collect()
    }
}

/// Three digits of something in thousandths.
fn milli(v: f64) -> String {
    // no minus before nothing
    let v = 1e3 * v + 0.0;
    let digits = if v == 0.0 { 1 } else { (2 - v.abs().log10().floor() as i32).max(0) as usize };
    if v != 0.0 && v.abs() < 1e-3 { format!("{v:.1e}") } else { format!("{v:.digits$}") }
}

/// The page, and the worst residual over the energy given.
fn page() -> (String, f64) {
    let mut out = String::from(
        "# How the hammer piano feels, and where the energy of the finger goes\n\n\
         Made by `UPDATE=1 cargo test -p ca-tests hammer_piano`: do not edit.\n\n\
         Key `c` of `models/hammer_piano.ca.toml`, through the engine and the guard of a TGR (`tgr12`, 3 kHz), by a finger that\n\
         goes where it is told whatever it feels. The key rests at 0 and meets its bed at 7 mm; forces are what the device\n\
         is sent, positive against the finger.\n\n\
         ## A slow press\n\n\
         Down at 10 mm/s to 2 mm within the bed, and up again. What is felt is the spring that lifts the key and, a little,\n\
         the hammer drawn through its damper; then the bed. Up and down differ by that damper alone.\n\n\
         | depth (mm) | down (N) | up (N) |\n|---|---|---|\n",
    );
    let mut f = Finger::new();
    let down = f.line(BED + 2e-3, 0.01);
    f.stay(0.2);
    let up = f.line(UP, 0.01);
    let at = |path: &[[f64; 2]], x: f64| {
        path.iter().min_by(|a, b| (a[0] - x).abs().total_cmp(&(b[0] - x).abs())).map_or(0.0, |p| -p[1])
    };
    for mm in 0..=9 {
        let x = UP + f64::from(mm) * 1e-3;
        let _ = writeln!(out, "| {mm} | {:.3} | {:.3} |", at(&down, x) + 0.0, at(&up, x) + 0.0);
    }
    assert!(f.sound.iter().all(|s| *s == 0.0), "a slow key is silent");

    out += "\n## A fast press\n\n\
            Down to the bed in a straight line, held for half a second, and up at 0.1 m/s. *Travel* is the largest force before the\n\
            bed: the inertia of the hammer, felt through its shank. *Throw* is the largest force back, while the hammer flies on\n\
            and pulls. The level is that of the loudest sample.\n\n\
            | speed (m/s) | travel (N) | throw (N) | level (dBFS) |\n|---|---|---|---|\n";
    let speeds = [0.1, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45];
    let mut energy: Vec<[f64; 10]> = Vec::new();
    let mut levels = Vec::new();
    for speed in speeds {
        let mut f = Finger::new();
        let travel = f.line(BED, speed).iter().fold(0.0, |m: f64, p| m.max(-p[1]));
        let before = f.force;
        let mut throw: f64 = 0.0;
        for _ in 0..150 {
            f.to(f.x);
            // the spring that lifts is there all the time
            throw = throw.max(f.force - 60.0 * (UP - f.x)).max(0.0);
        }
        assert!(before < 0.0, "the key pushes back");
        f.stay(0.45);
        f.line(UP, 0.1);
        f.stay(0.5);
        let level = db(peak(&f.sound));
        let shown = if peak(&f.sound) == 0.0 { "silent".into() } else { format!("{level:.1}") };
        levels.push(level);
        let _ = writeln!(out, "| {speed} | {travel:.3} | {throw:.3} | {shown} |");
        energy.push(account(&f));
    }
    assert!(levels.windows(2).all(|w| w[0] <= w[1]), "faster is not louder: {levels:?}");

    out += "\n## Energy from finger to string\n\n\
            The same presses, from the first motion to half a second after the key is up again, in millijoules. What the finger\n\
            gave is the force sent times its motion; the border makes the rest, by answering a frame late, and the model receives\n\
            the sum. *Residual* is what all of it does not account for.\n\n| mJ |";
    for speed in speeds {
        let _ = write!(out, " {speed} m/s |");
    }
    out += "\n|---|";
    out += &"---|".repeat(speeds.len());
    let rows = [
        "given by the finger",
        "made by the border",
        "= received by the model",
        "lost in the hammer's damper",
        "lost in the felt of the hammer",
        "lost in the bed",
        "lost in the strings",
        "lost in the bridge, to its board",
        "still in motion",
        "error of the scheme",
    ];
    for (i, row) in rows.iter().enumerate() {
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

/// Where the energy of a finger went [J]: given, made by the border, received; lost in the hammer's damper, in its felt,
/// in the bed, in the strings, in the bridge; in motion; made by the scheme, negative.
fn account(f: &Finger) -> [f64; 10] {
    let ledger = f.engine.state.ledger.as_ref().expect("the ledger is kept");
    let hand = f.scene.tgr.iter().position(|p| f.scene.inputs[p.input as usize].name == "c").expect("the key");
    let (received, given) = (ledger.hands[hand].received, ledger.hands[hand].given);
    // the ledger of the border and the forces on the wire, which are of single precision, tell the same
    assert!((f.work / given - 1.0).abs() < 1e-6, "the finger worked {} J, the ledger says {given} J", f.work);
    let lost = |name: &str| -> f64 {
        let of = |i: usize| f.scene.audited_name(i).is_some_and(|n| n.split(['[', '_']).next() == Some(name));
        ledger.lost.iter().enumerate().filter(|(i, _)| of(*i)).map(|(_, l)| l).sum()
    };
    let links = ["calm", "strike", "stop", "board"].map(lost);
    let all: f64 = ledger.lost.iter().sum();
    assert!((links.iter().sum::<f64>() - all).abs() <= 1e-15 * all, "heat in a link that is not in the table");
    let [calm, strike, stop, board] = links;
    let made = -ledger.scheme_error.iter().sum::<f64>();
    [given, received - given, received, calm, strike, stop, ledger.lost_mats, board, ledger.h - ledger.h0, made]
}

#[test]
fn the_page_of_the_hammer_piano_holds() {
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
        "docs/measured/hammer-piano.md is stale; run `UPDATE=1 cargo test -p ca-tests hammer_piano`\n{want}"
    );
}
