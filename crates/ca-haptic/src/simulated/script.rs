//! Intentions of a simulated player: functions of time for each degree of freedom.
//!
//! Six gestures exercise a loop: `strike` hits things fast and lets go, `bow` crosses them back and forth, `shake` is
//! fast and small, `hold` stays while a force acts, `push` is a force without a position, and `file` is a recording.
//! Each begins at rest, so that arming need not wait. Like fingers, each DOF begins a little after the one before.

use crate::profile::Profile;
use ca_io::gesture::Gesture;
use std::f64::consts::PI;

/// Intention at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intention {
    /// Position to which the hand moves \[m\].
    pub position: f64,
    /// Force with which it pushes at any position \[N\].
    pub force: f64,
}

/// Gesture of a simulated player.
#[derive(Clone, Debug, PartialEq)]
pub enum Script {
    /// Moves down and up again, from `rest` by `depth` \[m\] (negative is down), `rate` times a second.
    Strike {
        /// Position of rest \[m\].
        rest: f64,
        /// Amplitude \[m\].
        depth: f64,
        /// Strokes a second \[Hz\].
        rate: f64,
        /// Duration of a stroke \[s\].
        stroke: f64,
    },
    /// Moves at constant speed between two ends, with smooth reversals.
    Bow {
        /// Middle of the path \[m\].
        rest: f64,
        /// Distance to each side \[m\].
        depth: f64,
        /// Cycles a second \[Hz\].
        rate: f64,
    },
    /// Moves as a sine.
    Shake {
        /// Middle of the motion \[m\].
        rest: f64,
        /// Distance to each side \[m\].
        depth: f64,
        /// Frequency \[Hz\].
        rate: f64,
    },
    /// Stays in one position.
    Hold {
        /// The position \[m\].
        rest: f64,
    },
    /// Pushes from the first moment.
    Push {
        /// The force \[N\].
        force: f64,
    },
    /// Plays a script per DOF; further DOF play the last one.
    Each(Vec<Script>),
    /// Plays the tracks of a gesture, one per DOF \[m\]; further DOF stay at 0.
    File(Gesture),
}

/// Names of the scripts that need no file.
pub const SCRIPTS: [&str; 5] = ["strike", "bow", "shake", "hold", "push"];

/// Delay of each DOF after the one before \[s\].
const LATER: f64 = 0.05;
/// Time before the first motion \[s\]; forces need 1.1 s to be on (H5: 0.1 s clear, 1 s of ramp).
const BEGIN: f64 = 1.5;

/// Options of a script; absent ones suit the device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScriptOptions {
    /// Position of rest \[m\]; by default the middle of the travel.
    pub rest: Option<f64>,
    /// Amplitude from there \[m\], negative for down.
    pub depth: Option<f64>,
    /// Largest speed \[m/s\]; by default at most half of what trips the guard.
    pub speed: Option<f64>,
}

impl Script {
    /// Returns the script with this name for a device and these options; `None` for an unknown name.
    pub fn named(name: &str, profile: &Profile, options: ScriptOptions) -> Option<Script> {
        let [low, high] = profile.range;
        let (rest, travel) = (options.rest.unwrap_or(0.5 * (low + high)), high - low);
        let deep = |part: f64| options.depth.unwrap_or(part * travel);
        let fast = |suits: f64| options.speed.unwrap_or(suits.min(0.5 * profile.guard.speed));
        Some(match name {
            "strike" => {
                let depth = deep(-0.35);
                let stroke = PI * depth.abs() / fast(6.0 * PI * depth.abs());
                Script::Strike { rest, depth, rate: (1.0 / (3.0 * stroke)).min(2.0), stroke }
            }
            "bow" => {
                let depth = deep(0.3);
                Script::Bow { rest, depth, rate: fast(5.5 * depth.abs()) / (5.5 * depth.abs()) }
            }
            "shake" => {
                let depth = deep(0.05);
                Script::Shake { rest, depth, rate: fast(16.0 * PI * depth.abs()) / (2.0 * PI * depth.abs()) }
            }
            "hold" => Script::Hold { rest },
            "push" => Script::Push { force: -0.2 * profile.force },
            _ => return None,
        })
    }

    /// Returns the intention of DOF `k` at `t` seconds.
    pub fn at(&self, k: usize, t: f64) -> Intention {
        if let Script::Each(all) = self {
            return all.get(k).or(all.last()).map_or(Intention::default(), |s| s.at(k, t));
        }
        let turn = std::f64::consts::TAU;
        let t = t - BEGIN - LATER * k as f64;
        let since = t.max(0.0);
        let position = match self {
            Script::Strike { rest, depth, rate, stroke } => {
                let phase = (since * rate).fract() / (rate * stroke);
                if phase < 1.0 { rest + 0.5 * depth * (1.0 - (turn * phase).cos()) } else { *rest }
            }
            // the first two terms of a triangle: nearly constant speed, smooth ends
            Script::Bow { rest, depth, rate } => {
                let w = turn * rate * since;
                rest + depth * (w.sin() - (3.0 * w).sin() / 9.0) * 0.9
            }
            Script::Shake { rest, depth, rate } => rest + depth * (turn * rate * since).sin(),
            Script::Hold { rest } => *rest,
            Script::Each(_) => 0.0,
            Script::Push { force } => return Intention { position: 0.0, force: *force },
            // a file is not delayed
            Script::File(g) => g.tracks().get(k).map_or(0.0, |track| track.at(t + BEGIN + LATER * k as f64)),
        };
        Intention { position, force: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::SHIPPED;
    use ca_io::gesture::Track;

    #[test]
    fn every_script_begins_at_rest_and_stays_in_the_travel_of_every_device() {
        for (name, _) in SHIPPED {
            let p = Profile::shipped(name).expect("shipped");
            for script in SCRIPTS {
                let s = Script::named(script, &p, ScriptOptions::default()).expect("a script");
                let (mut last, mut moved) = (s.at(0, 0.0), false);
                for n in 0..20_000 {
                    let now = s.at(0, f64::from(n) / 2000.0);
                    assert!(now.position >= p.range[0] && now.position <= p.range[1], "{name} {script}");
                    let speed = (now.position - last.position).abs() * 2000.0;
                    assert!(speed <= 0.51 * p.guard.speed, "{name} {script}: {speed} m/s");
                    assert!(n > 2900 || now == last, "{name} {script} begins at rest");
                    moved |= speed > 0.0;
                    last = now;
                }
                assert_eq!(moved, !matches!(script, "hold" | "push"), "{name} {script}");
                assert!(last.force.abs() <= p.force);
            }
        }
        assert_eq!(Script::named("wave", &Profile::shipped("tgr12").expect("shipped"), ScriptOptions::default()), None);
    }

    #[test]
    fn a_script_rests_and_goes_where_it_says() {
        let p = Profile::shipped("tgr12").expect("shipped");
        for (script, low, high) in [("strike", -0.008, -6e-4), ("bow", -0.0154, -6e-4), ("shake", -0.0154, -6e-4)] {
            for speed in [None, Some(0.4)] {
                let options = ScriptOptions { rest: Some(-0.008), depth: Some(0.0074), speed };
                let s = Script::named(script, &p, options).expect("a script");
                let way: Vec<f64> = (0..40_000).map(|n| s.at(0, f64::from(n) / 4000.0).position).collect();
                let (least, most) = way.iter().fold((0.0f64, -1.0f64), |m, x| (m.0.min(*x), m.1.max(*x)));
                // a bow is only the start of a triangle series
                assert!((least - low).abs() < 6e-4 && (most - high).abs() < 6e-4, "{script}: {least} to {most}");
                let fastest = way.windows(2).map(|w| (w[1] - w[0]).abs() * 4000.0).fold(0.0, f64::max);
                let want = speed.unwrap_or(fastest);
                assert!((0.95..1.01).contains(&(fastest / want)) && fastest > 0.03, "{script}: {fastest} m/s");
            }
        }
    }

    #[test]
    fn each_dof_has_a_script_of_its_own() {
        let (hold, other) = (Script::Hold { rest: -0.004 }, Script::Hold { rest: 0.002 });
        let p = Profile::shipped("tgr12").expect("shipped");
        let strike = Script::named("strike", &p, ScriptOptions::default()).expect("a script");
        let s = Script::Each(vec![hold, strike.clone(), other]);
        assert!([0.0, 1.7, 3.0].into_iter().all(|t| s.at(0, t).position == -0.004 && s.at(1, t) == strike.at(1, t)));
        assert!((2..12).all(|k| s.at(k, 1.8).position == 0.002));
        assert_eq!(Script::Each(Vec::new()).at(0, 1.0), Intention::default());
    }

    #[test]
    fn a_file_moves_dof_by_dof() {
        let a = Track::points("a", vec![(0.0, 0.0), (1.0, 0.01)]).expect("a track");
        let s = Script::File(Gesture::new(vec![a]).expect("a gesture"));
        assert!((s.at(0, 0.5).position - 0.005).abs() < 1e-15);
        assert_eq!(s.at(1, 0.5), Intention::default());
    }
}
