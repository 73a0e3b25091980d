//! All models, and playing one by its own gesture.

use ca_core::{Scene, State};
pub use cordis_anima::catalog;
use std::path::Path;

/// Name and text of every model: the examples of the catalog, `models/` without its parts, and `tests/models/`.
pub fn texts() -> Vec<(String, String)> {
    let mut all: Vec<_> = catalog().iter().map(|k| (format!("example of {}", k.code), k.example.into())).collect();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in [here.join("../models"), here.join("../../models")] {
        let mut found = Vec::new();
        collect(&folder, &mut found);
        found.sort();
        all.extend(found);
    }
    all
}

fn collect(folder: &Path, found: &mut Vec<(String, String)>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()) {
        if path.is_dir() && !path.ends_with("parts") {
            collect(&path, found);
        } else if path.to_string_lossy().ends_with(".ca.toml") {
            if let Ok(text) = std::fs::read_to_string(&path) {
                found.push((path.file_name().unwrap_or_default().to_string_lossy().into(), text));
            }
        }
    }
}

/// Value of breakpoints at time `t` \[s\], constant outside.
pub fn follow(points: &[[f64; 2]], t: f64) -> f64 {
    let i = points.partition_point(|p| p[0] <= t);
    match (i.checked_sub(1).map(|i| points[i]), points.get(i).copied()) {
        (Some([t0, v0]), Some([t1, v1])) => v0 + (v1 - v0) * ((t - t0) / (t1 - t0)),
        (Some([_, v]), None) | (None, Some([_, v])) => v,
        (None, None) => 0.0,
    }
}

/// Sets the ports by the scene's own gesture for the next tick. Live parameters stay unchanged.
pub fn gesture(scene: &Scene, s: &mut State) {
    let t = s.tick as f64 * scene.rates.sample_dt;
    for (name, points) in &scene.about.gestures {
        if let Some(i) = scene.inputs.iter().position(|input| input.name == *name) {
            s.input[i] = follow(points, t);
        }
    }
}
