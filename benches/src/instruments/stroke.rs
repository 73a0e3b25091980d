//! How a simulated device plays an instrument: by the gesture that its model has built in.
//!
//! Decides that the hand of the simulated device follows the gesture itself, in the lengths of the hand, rather than a script with
//! numbers of its own: so a built-in gesture that no hand could play, by its travel, is found out, and one that is too fast for the
//! guard says by how much.

use ca_core::Scene;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What is asked of an instrument that is played by a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// part of the largest force of the device that may press while forces begin, where the instrument has a weight that the
    /// hand carries; that of the profile of the device where 0
    pub clear: f64,
    /// how long it plays, from before forces come \[s\]
    pub seconds: f64,
    /// how many times slower than the gesture that is built in the hand goes, where a mallet is swung faster than the guard of
    /// the device lets a hand go
    pub slower: f64,
    /// where degrees of freedom go, as times \[s\] and places \[m\] in the lengths of the hand, where the model has no gesture of
    /// theirs built in
    pub ways: &'static [(u32, &'static [[f64; 2]])],
    /// least peak that must be heard \[dBFS\]
    pub heard: f64,
    /// least force that must be felt \[N\]
    pub felt: f64,
}

impl Stroke {
    /// What suits most.
    pub const DEFAULT: Stroke = Stroke { clear: 0.0, slower: 1.0, seconds: 5.0, ways: &[], heard: -40.0, felt: 0.05 };
}

/// The first device of a scene and its gesture, as a CSV file with a column for each degree of freedom \[m\]; `None` where the
/// scene has no port of a device. A degree of freedom without a gesture stays where its port begins.
pub fn hand<'a>(scene: &'a Scene, stroke: &Stroke) -> Option<(&'a str, String)> {
    let device = scene.inputs.iter().find_map(|i| i.device.as_ref())?.0.as_str();
    let mut ways: BTreeMap<u32, Vec<[f64; 2]>> = BTreeMap::new();
    for i in &scene.inputs {
        let Some((name, dof)) = &i.device else { continue };
        if name != device {
            continue;
        }
        let way = match (stroke.ways.iter().find(|w| w.0 == *dof), scene.about.gestures.iter().find(|g| g.0 == i.name))
        {
            (Some((_, own)), _) => own.to_vec(),
            (None, Some((_, points))) => points.iter().map(|[t, x]| [t * stroke.slower, x / i.gains.alpha]).collect(),
            (None, None) => vec![[0.0, i.rest / i.gains.alpha]],
        };
        ways.insert(*dof, way);
    }
    let mut csv = String::from("time");
    let last = *ways.keys().next_back()?;
    (0..=last).for_each(|k| _ = write!(csv, ",dof{k}"));
    csv.push('\n');
    let mut rows: Vec<(f64, u32, f64)> = (0..=last).map(|k| (0.0, k, ways.get(&k).map_or(0.0, |w| w[0][1]))).collect();
    rows.extend(ways.iter().flat_map(|(k, w)| w.iter().map(|p| (p[0], *k, p[1]))));
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (t, k, x) in rows {
        _ = write!(csv, "{t}");
        (0..=last).for_each(|c| _ = if c == k { write!(csv, ",{x}") } else { write!(csv, ",") });
        csv.push('\n');
    }
    Some((device, csv))
}
