//! Converts a take to a gesture, which plays the motion of the hands on this or another model.
//!
//! The take is replayed and the ports of its scene are read frame by frame, rather than the frames of the devices. The
//! ports hold the positions after calibration, gains and input checks, in the metres of the scene. Tracks have the
//! names of these ports and are sampled at the gesture rate, so that the same model at the same rates gives the same
//! bits. Changed parameters are tracks of steps. If a take has several versions of its model, the ports and parameters
//! of the first version are used, and found by name in the others.

use super::read::{Event, Take};
use super::replay::Replay;
use crate::version;
use ca_core::{Catalog, Input, InputRole, Scene};
use ca_io::error::FileError;
use ca_io::gesture::{Gesture, Track};
use std::path::Path;
use std::sync::Arc;

/// Returns the gesture in the take at `path`.
///
/// # Errors
/// If the file is not a take, its replay differs, records are missing, or it has no frames.
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
    // their places in the version of the model that plays
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
                // a port that is gone stays at its last position
                to.push(k.map_or_else(|| to.last().copied().unwrap_or(0.0), |k| engine.state.input[k]));
            }
        },
        &mut |_| Ok(()),
    )?;
    if let Some(d) = verdict.difference {
        let e = FileError::content(format!("the replay differs from the take: {d}")).file(path.display());
        return Err(e.fix("play it with the version of `ca` that wrote it"));
    }
    if let Some(t) = verdict.hole {
        let what = format!("records are missing at {t:.3} s, so the motion after that is unknown");
        let e = FileError::content(what).file(path.display());
        return Err(e.fix("`ca log export` writes the recorded frames"));
    }
    let rate = scene.rate / f64::from(scene.rates.ratio);
    let mut tracks = Vec::new();
    for (samples, name) in seen.into_iter().zip(ports) {
        tracks.push(Track::sampled(name, rate, samples).map_err(|e| e.file(path.display()))?);
    }
    tracks.extend(steps(&take, &scene, catalog).map_err(|e| e.file(path.display()))?);
    Gesture::new(tracks).map_err(|e| e.file(path.display()))
}

/// Returns the changed parameters of the first version of the model, as steps.
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
            // parameters are as at load again
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
