//! Plays the hammer piano through shared memory with a simulated TGR and a compliant hand, for
//! `docs/measured/hammer-piano-played.md`.
//!
//! Device and engine wait for each other, so the page is reproducible up to a last digit. `UPDATE=1` writes the page.

use crate::long_form::long_form;
use crate::sandbox::{Sandbox, patient};
use ca_haptic::profile::SHIPPED;
use serde_json::Value;
use std::fmt::Write as _;

/// Largest speeds of the hand \[m/s\].
const SPEEDS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Rest position of the keys \[mm\], and depths at which the force is sampled.
const UP: f64 = -8.0;
const DEPTHS: [f64; 11] = [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 8.5, 9.0];
/// Depths of the let-off and of the key bed \[mm\].
const LET_OFF: f64 = 7.5;
const BED: f64 = 9.2;
/// Level between the sound of dampers lifting from twelve strings and the sound of hammers.
const SOFT: f64 = 3e-3;

/// A performance: data of the first key from the device, and data of all keys from the engine.
struct Played {
    /// Time \[s\], depth \[mm\] and applied force \[N\] of each frame in mode on.
    felt: Vec<[f64; 3]>,
    peak: f64,
    energy: Value,
}

fn play(speed: f64) -> Played {
    // repeats if the engine waited for 100 ms and continued without its device
    (0..4).find_map(|_| attempt(speed)).expect("a performance without a hole")
}

fn attempt(speed: f64) -> Option<Played> {
    let sandbox = Sandbox::new();
    let tgr12 = SHIPPED.iter().find(|s| s.0 == "tgr12").expect("shipped").1;
    sandbox.put("c/profiles/tgr12.toml", &patient(tgr12));
    let hand = format!("{speed} m/s");
    let server =
        sandbox.serve("hammer_piano", &["--clock", "device", "--arm", "--json", "-o", "p.wav", "--log", "p.mcap"]);
    let device = sandbox.spawn(&[
        "device",
        "sim",
        "--lockstep",
        "--rest",
        "-8 mm",
        "--depth",
        "9.6 mm",
        "--speed",
        &hand,
        "--seconds",
        "4",
        "--force-log",
        "felt.csv",
    ]);
    device.end().is(0);
    let reported = server.stop();
    let summary = reported.json();
    let frames = summary["devices"][0]["frames"].as_u64()?;
    let faults = summary["faults"].as_array()?;
    assert!(faults.iter().all(|f| f["cause"] == "WATCHDOG_OUT" || f["cause"] == "DEVICE_LOST"), "{faults:?}");
    if frames != 12_000 || !faults.is_empty() {
        eprintln!("once more: {frames} frames, {faults:?}");
        return None;
    }
    let log = sandbox.read("felt.csv");
    let felt: Vec<[f64; 3]> = log
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect::<Vec<_>>())
        .filter(|c| c[4] == "on")
        .map(|c| [1, 7, 19].map(|i: usize| c[i].parse::<f64>().expect("a number")))
        .map(|[t, x, f]| [t, 1e3 * x - UP, f])
        .collect();
    let sound = hound::WavReader::open(sandbox.path("p.wav")).unwrap();
    let peak = sound.into_samples::<f32>().map(|s| f64::from(s.unwrap().abs())).fold(0.0, f64::max);
    let replay = sandbox.ca(&["replay", "p.mcap", "--verify", "--energy", "--json"]).is(0).json();
    let energy = replay["energy"].clone();
    Some(Played { felt, peak, energy })
}

impl Played {
    /// Frames of the first stroke, from the last depth below 0.3 mm to the deepest.
    fn stroke(&self) -> &[[f64; 3]] {
        let end = self.felt.windows(2).position(|w| w[0][1] > 9.0 && w[1][1] <= w[0][1]).expect("a stroke");
        let begin = self.felt[..end].iter().rposition(|f| f[1] < 0.3).expect("its beginning");
        &self.felt[begin..=end]
    }
    /// Force against the finger \[N\] and speed \[m/s\] at a depth on the way down.
    fn at(&self, depth: f64) -> Option<[f64; 2]> {
        let pair = self.stroke().windows(2).find(|w| w[0][1] < depth && w[1][1] >= depth)?;
        let part = (depth - pair[0][1]) / (pair[1][1] - pair[0][1]);
        let force = pair[0][2] + part * (pair[1][2] - pair[0][2]);
        Some([-force, 1e-3 * (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])])
    }
    /// Largest forces against the finger: down to the let-off, down to the key bed, and overall.
    fn most(&self) -> [f64; 3] {
        let of = |deepest: f64| self.stroke().iter().filter(|f| f[1] < deepest).fold(0.0, |m: f64, f| m.max(-f[2]));
        [of(LET_OFF), of(BED), of(f64::INFINITY)]
    }
    /// Sum of the rows whose names begin with one of `names` \[J\].
    fn joules(&self, names: &[&str]) -> f64 {
        let rows = ["sources", "sinks"].map(|k| self.energy[k].as_array().unwrap()).into_iter().flatten();
        let of = |r: &&Value| names.iter().any(|n| r["what"].as_str().unwrap().starts_with(n));
        rows.filter(of).map(|r| r["joules"].as_f64().unwrap()).sum()
    }
}

fn milli(v: f64) -> String {
    let v = 1e3 * v;
    if v.abs() < 5e-4 {
        return "0".into();
    }
    let digits = (2 - v.abs().log10().floor() as i32).max(0) as usize;
    format!("{v:.digits$}")
}

fn page(all: &[Played]) -> String {
    let mut out = String::from(
        "# The hammer piano, played by a device\n\n\
         Made by `UPDATE=1 cargo test $ALL --test loop -- piano` ($ALL is in CONTRIBUTING.md): do not edit.\n\n\
         `ca device sim --profile tgr12 --script strike` strikes the twelve keys of `ca serve hammer_piano` across shared\n\
         memory, five times each. Its hand is a compliant finger (5 kN/m, 20 g) on keys of 200 g; its largest speed is at the\n\
         head of each column. Device and engine wait for each other, so the figures are the same every time, except for a last\n\
         digit; a force is valid for 0.1 s instead of 5 ms, since this loop does not run in real time.\n\n\
         ## What the finger feels\n\n\
         Key C4, first stroke, on its way down: the force its motor held, positive against the finger, and the speed of the key\n\
         at that depth. The let-off begins at 7.7 mm, the bed is at 9.2 mm.\n\n| depth (mm) |",
    );
    let head = |out: &mut String| {
        for v in SPEEDS {
            let _ = write!(out, " {v} m/s |");
        }
        let _ = write!(out, "\n|---|{}", "---|".repeat(SPEEDS.len()));
    };
    head(&mut out);
    for depth in DEPTHS {
        let _ = write!(out, "\n| {depth} |");
        for p in all {
            let _ = match p.at(depth) {
                Some([force, speed]) => write!(out, " {:.3} N at {speed:.2} m/s |", force + 0.0),
                None => write!(out, " |"),
            };
        }
    }
    for (i, what) in ["most before the let-off", "most before the bed", "most"].iter().enumerate() {
        let _ = write!(out, "\n| {what} |");
        for p in all {
            let _ = write!(out, " {:.3} N |", p.most()[i]);
        }
    }
    out += "\n\n## What is heard\n\n| |";
    head(&mut out);
    out += "\n| loudest sample (dBFS) |";
    for p in all {
        let _ = write!(out, " {:.1} |", 20.0 * p.peak.log10());
    }
    out += "\n\nAt 0.05 m/s the hammers do not reach the strings: the sound is of the dampers, as they leave the strings.\n\n\
            ## Where the energy of the finger went\n\n\
            All keys and strokes, from `ca replay TAKE --energy`, in millijoules. The energy given by the hands is the force the\n\
            motors held times the motion of the keys, from the device frames. The border makes energy because it answers a frame\n\
            late; the guard takes the same amount out before it reaches the hand (−).\n\n| mJ |";
    head(&mut out);
    let rows: [(&str, &[&str]); 8] = [
        ("given by the finger", &["given by the hands"]),
        ("added by guard and device (−: taken)", &["added by"]),
        ("made by the border", &["made by the border"]),
        ("lost in the links of the keys: actions, felt, dampers, strings", &["lost in `key"]),
        ("lost in the links of the board", &["lost in `board"]),
        ("lost in the masses of strings, pins and board", &["lost in masses"]),
        ("stored", &["stored"]),
        ("taken by the scheme", &["taken by the scheme"]),
    ];
    for (what, names) in rows {
        let _ = write!(out, "\n| {what} |");
        for p in all {
            let _ = write!(out, " {} |", milli(p.joules(names)));
        }
    }
    out += "\n| not explained |";
    for p in all {
        let of = (p.energy["residual"].as_f64().unwrap() / p.energy["peak"].as_f64().unwrap()).abs();
        let _ = write!(out, " {} |", if of <= 1e-9 { "< 1e-9 of it" } else { "too much" });
        assert!(of <= 1e-9, "{of:e}");
        // the rows of the table are complete too
        let whole: f64 = rows[..3].iter().map(|r| p.joules(r.1)).sum();
        let there: f64 = rows[3..].iter().map(|r| p.joules(r.1)).sum();
        assert!((whole - there).abs() <= 1e-9 * whole, "{whole} J came in, {there} J are somewhere");
    }
    out + "\n"
}

/// Compares two pages word by word, with 2 % tolerance for numbers. The number of frames without the device varies, and
/// last digits may change.
fn same(a: &str, b: &str) -> bool {
    let near = |(a, b): (&str, &str)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 0.02 * a.abs().max(b.abs()),
        _ => a == b,
    };
    a.lines().count() == b.lines().count()
        && a.split_whitespace().count() == b.split_whitespace().count()
        && a.split_whitespace().zip(b.split_whitespace()).all(near)
}

#[test]
fn the_page_of_the_piano_played_by_a_device_holds() {
    if !long_form("the hammer piano at all its speeds, and its page") && std::env::var_os("UPDATE").is_none() {
        let one = play(SPEEDS[2]);
        assert!(one.peak > SOFT && one.most()[0] > 0.0, "{} N, {}", one.most()[0], one.peak);
        page(&[one]);
        return;
    }
    let all: Vec<Played> = SPEEDS.into_iter().map(play).collect();
    // a faster key is louder and needs more force
    let peaks: Vec<f64> = all.iter().map(|p| p.peak).collect();
    assert!(peaks[0] < SOFT && peaks[1..].iter().all(|p| *p > SOFT), "no hammer from a slow key: {peaks:?}");
    assert!(peaks.is_sorted_by(|a, b| a < b), "{peaks:?}");
    let most: Vec<[f64; 3]> = all.iter().map(Played::most).collect();
    assert!(most.is_sorted_by(|a, b| a[0] < b[0]), "{most:?}");
    // the let-off can be felt where the inertia of the action does not mask it
    assert!(most[..2].iter().all(|m| m[1] > 1.5 * m[0]), "{most:?}");
    let want = page(&all);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/measured/hammer-piano-played.md");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(path, &want).expect("docs/ is there");
    }
    let is = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        same(&is, &want),
        "docs/measured/hammer-piano-played.md is stale; run `UPDATE=1 cargo test $ALL --test loop -- piano`\n{want}"
    );
}
