//! A take as a gesture: what the hands did, to be played on this or another model.
//!
//! Decides to replay the take and to read the ports of its scene, frame by frame, rather than the frames of the
//! devices: what the scene had is what calibrations, gains and input checks left of them, in its own metres. The tracks
//! are called like those ports and sampled at the gesture rate, so the same model at the same rates gets the same
//! bits. Parameters that were changed are tracks of steps.

use super::read::{Event, Take};
use super::replay::Replay;
use ca_core::Catalog;
use ca_core::scene::InputRole;
use ca_io::error::FileError;
use ca_io::gesture::{Gesture, Track};
use std::path::Path;

/// The gesture in the take at `path`.
///
/// # Errors
/// Where the file is no take, or has no positions of devices.
pub fn gesture(path: impl AsRef<Path>, catalog: &Catalog) -> Result<Gesture, FileError> {
    let path = path.as_ref();
    let take = Take::open(path)?;
    let mut replay = Replay::new(&take, catalog)?;
    let scene = replay.engine.scene.clone();
    let ports: Vec<usize> = scene
        .inputs
        .iter()
        .enumerate()
        .filter(|(_, i)| i.role == InputRole::Device)
        .filter(|(_, i)| i.device.as_ref().is_some_and(|d| take.header.setups.iter().any(|s| s.device == d.0)))
        .map(|(k, _)| k)
        .collect();
    let mut seen: Vec<Vec<f64>> = vec![Vec::new(); ports.len()];
    let verdict = replay.run(
        &take,
        &mut |engine| {
            for (to, k) in seen.iter_mut().zip(&ports) {
                to.push(engine.state.input[*k]);
            }
        },
        &mut |_| Ok(()),
    )?;
    if let Some(d) = verdict.difference {
        let e = FileError::content(format!("its replay is not as it was: {d}")).file(path.display());
        return Err(e.fix("play it with the version of `ca` that wrote it"));
    }
    if let Some(t) = verdict.hole {
        let what = format!("records are missing in it at {t:.3} s, so what came after is not known");
        let e = FileError::content(what).file(path.display());
        return Err(e.fix("`ca log export` gives the frames that are there"));
    }
    let rate = scene.rate / f64::from(scene.ratio);
    let mut tracks = Vec::new();
    for (samples, k) in seen.into_iter().zip(ports) {
        tracks.push(Track::sampled(&scene.inputs[k].name, rate, samples).map_err(|e| e.file(path.display()))?);
    }
    for (p, param) in scene.live.params.iter().enumerate() {
        let mut points = vec![(0.0, param.value)];
        for event in take.events()? {
            let (tick, new) = match event? {
                Event::Change(tick, change) => {
                    let new = change.params.iter().rfind(|c| c.0 as usize == p).map(|c| c.1);
                    (tick, new)
                }
                // as at load again
                Event::Reload(r) => (r.tick, Some(param.value)),
                _ => continue,
            };
            let last = points[points.len() - 1].1;
            if let Some(new) = new.filter(|v| *v != last) {
                let t = tick as f64 * scene.sample_dt;
                points.extend([(t, last), (t, new)]);
            }
        }
        if points.len() > 1 {
            tracks.push(Track::points(&param.name, points).map_err(|e| e.file(path.display()))?);
        }
    }
    Gesture::new(tracks).map_err(|e| e.file(path.display()))
}
