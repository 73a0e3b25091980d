//! How a simulated device plays an instrument: the arguments of `ca device sim`.
//!
//! Decides that the built-in gesture says where a hand rests and how far it goes, so that most instruments need no numbers of their
//! own: each degree of freedom rests where its port begins, and one of them strikes as far as its gesture goes.

use ca_core::Scene;
use ca_core::scene::Input;

/// A stroke of a simulated hand. Lengths are those of the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// `--script`
    pub script: &'static str,
    /// degrees of freedom that move, the others rest; the first that the built-in gesture moves where empty
    pub dof: &'static [u32],
    /// where each degree of freedom rests \[m\]; where the built-in gesture begins where empty
    pub rest: &'static [f64],
    /// how far it goes \[m\]; as far as the built-in gesture where 0
    pub depth: f64,
    /// fastest moment \[m/s\]
    pub speed: f64,
    /// part of the largest force of the device that may press while forces begin, where the instrument has a weight that the
    /// hand carries; that of the profile of the device where 0
    pub clear: f64,
    /// how long it plays, from before forces come \[s\]
    pub seconds: f64,
    /// least peak that must be heard \[dBFS\]
    pub heard: f64,
    /// least force that must be felt \[N\]
    pub felt: f64,
}

impl Stroke {
    /// What suits a key.
    pub const DEFAULT: Stroke = Stroke {
        script: "strike",
        dof: &[],
        rest: &[],
        depth: 0.0,
        speed: 0.4,
        clear: 0.0,
        seconds: 4.0,
        heard: -40.0,
        felt: 0.05,
    };

    /// Arguments of `ca device sim` that play this scene; `None` where it has no port of a device.
    pub fn arguments(&self, scene: &Scene) -> Option<Vec<String>> {
        let ports: Vec<(&Input, &str, u32)> =
            scene.inputs.iter().filter_map(|i| i.device.as_ref().map(|(d, k)| (i, d.as_str(), *k))).collect();
        let device = ports.first()?.1;
        let ports = || ports.iter().filter(|p| p.1 == device);
        let points = |i: &Input| scene.gestures.iter().find(|g| g.0 == i.name).map(|g| &g.1);
        let begin = |i: &Input| points(i).and_then(|p| p.first()).map_or(i.rest, |p| p[1]) / i.gains.alpha;
        let mut rest = self.rest.to_vec();
        if rest.is_empty() {
            rest = vec![0.0; 1 + ports().map(|p| p.2 as usize).max()?];
            ports().for_each(|p| rest[p.2 as usize] = begin(p.0));
        }
        let moved = ports().find(|p| if self.dof.is_empty() { points(p.0).is_some() } else { p.2 == self.dof[0] });
        let moved = moved.or_else(|| ports().next())?;
        let way = |i: &Input| {
            let all = points(i).into_iter().flatten().map(|p| p[1] / i.gains.alpha - begin(i));
            all.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
        };
        let depth = if self.depth == 0.0 { way(moved.0) } else { self.depth };
        let dof = if self.dof.is_empty() { vec![moved.2] } else { self.dof.to_vec() };
        let list = |v: Vec<String>| v.join(",");
        let profile = if device == "stick" && self.clear == 0.0 { "unknown" } else { device };
        let mut all: Vec<String> =
            ["--profile", profile, "--name", device, "--script", self.script].map(String::from).into();
        all.push(format!("--rest={}", list(rest.iter().map(f64::to_string).collect())));
        all.push(format!("--dof={}", list(dof.iter().map(u32::to_string).collect())));
        if !["hold", "push"].contains(&self.script) {
            all.push(format!("--depth={depth}"));
            all.push(format!("--speed={}", self.speed));
        }
        all.push(format!("--seconds={}", self.seconds));
        Some(all)
    }
}
