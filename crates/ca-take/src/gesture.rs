//! Opens the gesture files named on a command line.

use ca_core::Scene;
use ca_io::gesture::{Gesture, Track, port_maps};
use ca_lab::load::{has_extension, ticked};
use ca_lab::{Failure, catalog};
use ca_model::select::is_name;
use std::path::Path;

/// Splits `key=take.wav` into port and file, unless `folder` has a file with that whole name.
pub fn port_and_file<'a>(text: &'a str, folder: &Path) -> (Option<&'a str>, &'a Path) {
    match text.split_once('=') {
        Some((port, file)) if !folder.join(text).exists() && is_name(port) => (Some(port), Path::new(file)),
        _ => (None, Path::new(text)),
    }
}

/// Opens all files as one gesture. Returns `None` if `files` is empty.
///
/// `rate` \[Hz\] applies to arrays without times. Paths are relative to `folder`. `note` receives remarks on a file.
///
/// # Errors
/// Returns [`Failure::Usage`] if a file drives nothing or if `PORT=` names a file with several tracks. Passes on the
/// errors of the file readers.
pub fn open(
    files: &[String],
    rate: Option<f64>,
    scene: &Scene,
    folder: &Path,
    note: &mut dyn FnMut(&str),
) -> Result<Option<Gesture>, Failure> {
    let ports = port_maps(scene);
    let mut all = Vec::new();
    for text in files {
        let (port, file) = port_and_file(text, folder);
        let file = &*folder.join(file);
        // among several files, the rate applies to arrays only
        let array = has_extension(file, "npy") || files.len() == 1;
        let gesture = if has_extension(file, "mcap") {
            ca_haptic::take::gesture(file, &catalog())?
        } else {
            Gesture::open(file, &ports, rate.filter(|_| array))?
        };
        for what in gesture.remarks() {
            note(&format!("`{}`: {what}", file.display()));
        }
        let Some(port) = port else {
            nameless(gesture.tracks(), scene, file)?;
            all.push(gesture);
            continue;
        };
        let names = ticked(gesture.tracks().iter().map(Track::name));
        let what = format!("`{}` has {} tracks, {names}", file.display(), gesture.tracks().len());
        let one = gesture.named(port);
        all.push(one.ok_or(Failure::Usage(format!("--gesture: {what}; `{port}=` needs a file with one track")))?);
    }
    Ok(if files.is_empty() { None } else { Some(Gesture::together(all)?) })
}

/// Refuses a single track `ch0` if nothing has that name, and explains how to name it.
fn nameless(tracks: &[Track], scene: &Scene, file: &Path) -> Result<(), Failure> {
    let [one] = tracks else { return Ok(()) };
    let drives = |n: &str| scene.inputs.iter().any(|i| i.name == n) || scene.live.params.iter().any(|p| p.name == n);
    let first = scene.inputs.first().map(|i| &i.name).or(scene.live.params.first().map(|p| &p.name));
    match first {
        Some(first) if one.name() == "ch0" && !drives("ch0") => {
            let what =
                format!("`{}`: its only track, `ch0`, is not a port or live parameter of the model", file.display());
            Err(Failure::Usage(format!("{what}; name the port, as in `--gesture {first}=FILE`")))
        }
        _ => Ok(()),
    }
}
