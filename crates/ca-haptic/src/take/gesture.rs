//! A take as a gesture: what the hands did, to be played on this or another model.
//!
//! Decides to replay the take and to read the ports of its scene, frame by frame, rather than the frames of the
//! devices: what the scene had is what calibrations, gains and input checks left of them, in its own metres. The tracks
//! are called like those ports and sampled at the gesture rate, so the same model at the same rates gets the same
//! bits. Parameters that were changed are tracks of steps. Where the take has several versions of its model, ports and parameters
//! are those of the first, and found by name in the others.

use super::read::{Event, Take};
use super::replay::Replay;
use crate::version;
use ca_core::{Catalog, Input, InputRole, Scene};
use ca_io::error::FileError;
use ca_io::gesture::{Gesture, Track};
use std::path::Path;
use std::sync::Arc;

/// The gesture in the take at `path`.
///
/// # Errors
/// Where the file is no take, or has no positions of devices.
pub fn gesture(path: impl AsRef<Path>, catalog: &Catalog) -> Result<Gesture, FileError> {
    let path = path.as_ref();
    let take = Take::open(path)?;
    let mut replay = Replay::new(&take, catalog)?;
    let scene = replay.engine.scene.clone();
    let from_device = |i: &&Input| {
        let device = i.device.as_ref().filter(|_| i.role == InputRole::Device);
        device.is_some_and(|d| take.header.setups.iter().any(|s| s.device == d.0))
    };
    let ports: Vec<&str> = scene.inputs.iter().filter(from_device).map(|i| i.name.as_str()).collect();
    // where they are in the version of the model that plays
    let places = |scene: &Scene| -> Vec<Option<usize>> {
        ports.iter().map(|name| scene.inputs.iter().position(|i| i.name == *name)).collect()
    };
    let mut now = (scene.clone(), places(&scene));
    let mut seen: Vec<Vec<f64>> = vec![Vec::new(); ports.len()];
    let verdict = replay.run(
        &take,
        &mut |engine| {
            if !Arc::ptr_eq(&now.0, &engine.scene) {
                now = (engine.scene.clone(), places(&engine.scene));
            }
            for (to, k) in seen.iter_mut().zip(&now.1) {
                // one that is gone stays where it was
                to.push(k.map_or_else(|| to.last().copied().unwrap_or(0.0), |k| engine.state.input[k]));
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
    let rate = scene.rate / f64::from(scene.rates.ratio);
    let mut tracks = Vec::new();
    for (samples, name) in seen.into_iter().zip(ports) {
        tracks.push(Track::sampled(name, rate, samples).map_err(|e| e.file(path.display()))?);
    }
    tracks.extend(steps(&take, &scene, catalog).map_err(|e| e.file(path.display()))?);
    Gesture::new(tracks).map_err(|e| e.file(path.display()))
}

/// Parameters of the first version of the model that were changed, by the values that they had.
fn steps(take: &Take, first: &Arc<Scene>, catalog: &Catalog) -> Result<Vec<Track>, FileError> {
    let load = |scene: &Scene| scene.live.params.iter().map(|p| (p.name.clone(), p.value)).collect::<Vec<_>>();
    let mut curves: Vec<Vec<(f64, f64)>> = load(first).iter().map(|p| vec![(0.0, p.1)]).collect();
    let mut now = first.clone();
    for event in take.events()? {
        let (tick, new) = match event? {
            Event::Change(tick, change) => {
                let name = |k: u32| now.live.params.get(k as usize).map(|p| p.name.clone());
                (tick, change.params.iter().filter_map(|(k, v)| Some((name(*k)?, *v))).collect())
            }
            // as at load again
            Event::Reload(r) => (r.tick, load(&now)),
            Event::Model(tick, next) => {
                now = Arc::new(take.header.version(&next).scene(catalog)?.scene);
                let (_, controls) = version::begin(&now, &next.moved);
                (tick, controls.params().iter().map(|p| (p.name.clone(), p.value)).collect())
            }
            _ => continue,
        };
        let t = tick as f64 * first.rates.sample_dt;
        for (points, param) in curves.iter_mut().zip(&first.live.params) {
            let last = points[points.len() - 1].1;
            let new = new.iter().rfind(|n| n.0 == param.name).map(|n| n.1);
            if let Some(new) = new.filter(|v| *v != last) {
                points.extend([(t, last), (t, new)]);
            }
        }
    }
    let changed = first.live.params.iter().zip(curves).filter(|(_, points)| points.len() > 1);
    changed.map(|(p, points)| Track::points(&p.name, points)).collect()
}
