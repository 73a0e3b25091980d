//! Inputs and outputs of a scene while it plays, and its end.

use crate::Error;
use ca_io::gesture::Gesture;
use ca_io::perform::{self, Performance};
pub(crate) use ca_io::play::BLOCK;
use ca_io::play::play;

/// Callback during play that returns whether to go on.
pub type GoesOn<'a> = &'a mut dyn FnMut() -> bool;

pub(crate) struct Played {
    pub(crate) frames: usize,
    /// Inputs of the ports (frames x inputs).
    pub(crate) given: Vec<f64>,
    /// Position of each hand at the first tick and its change per tick (inputs).
    pub(crate) hands: Vec<Option<[f64; 2]>>,
}

impl Played {
    pub(crate) fn new(
        scene: &ca_core::Scene,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        goes_on: GoesOn,
    ) -> Result<Played, Error> {
        let mut p = Performance::new(scene, gesture)?;
        known(scene, &p)?;
        let frames = perform::frames(scene, perform::seconds(&p, seconds)) as usize;
        let n = scene.inputs.len();
        let hands = (0..n).map(|i| p.hand(i)).collect();
        let mut given = zeros(frames, n, 1)?;
        for rows in given.chunks_mut(BLOCK as usize * n.max(1)) {
            p.given(rows);
            if !goes_on() {
                return Err(Error::Stopped);
            }
        }
        Ok(Played { frames, given, hands })
    }
}

/// Allocates a table of frames, outputs and numbers for each, all 0.
pub(crate) fn zeros(frames: usize, outputs: usize, each: usize) -> Result<Vec<f64>, Error> {
    let (n, mut all) = (frames.checked_mul(outputs).and_then(|n| n.checked_mul(each)), Vec::new());
    match n.filter(|n| all.try_reserve_exact(*n).is_ok()) {
        Some(n) => {
            all.resize(n, 0.0);
            Ok(all)
        }
        None => Err(Error::refused(format!(
            "{frames} samples with {each} numbers for each of {outputs} outputs do not fit into memory; play fewer seconds, or compute a gradient"
        ))),
    }
}

pub(crate) fn diverged() -> Error {
    Error::refused(
        "the scene diverges, and so do its derivatives; play fewer seconds, reduce stiffness or increase mass",
    )
}

pub(crate) fn output(
    scene: &ca_core::Scene,
    seconds: Option<f64>,
    gesture: Option<&Gesture>,
    goes_on: GoesOn,
) -> Result<Vec<f64>, Error> {
    let p = Performance::new(scene, gesture)?;
    let frames = perform::frames(scene, perform::seconds(&p, seconds));
    let mut all = zeros(usize::try_from(frames).unwrap_or(usize::MAX), scene.counts.n_out, 1)?;
    all.clear();
    let mut silent = false;
    play(p, frames, BLOCK, &mut |p, rows, _| {
        all.extend_from_slice(rows);
        silent = p.diverged;
        if goes_on() { Ok(()) } else { Err(Error::Stopped) }
    })?;
    if silent { Err(diverged()) } else { Ok(all) }
}

/// Returns the number of samples of a cotangent, or an error where it is empty, not finite or has a part of a row.
pub(crate) fn frames_of(cotangent: &[f64], outputs: usize) -> Result<usize, Error> {
    if let Some(at) = cotangent.iter().position(|v| !v.is_finite()) {
        let what = format!("the cotangent of sample {} is {}; it must be finite", at / outputs, cotangent[at]);
        return Err(Error::refused(what));
    }
    if cotangent.is_empty() {
        return Err(Error::refused("the cotangent is empty: the scene lacks outputs, or 0 samples are played"));
    }
    if !cotangent.len().is_multiple_of(outputs) {
        let what = format!(
            "the cotangent needs {outputs} numbers per sample, one for each output, but has {} in total",
            cotangent.len()
        );
        return Err(Error::refused(what));
    }
    Ok(cotangent.len() / outputs)
}

/// Refuses a gesture that moves a live parameter.
pub(crate) fn known(scene: &ca_core::Scene, p: &Performance) -> Result<(), Error> {
    match p.driven().into_iter().find(|name| scene.input(name).is_none()) {
        Some(name) => Err(Error::refused(format!(
            "a gesture drives the live parameter `{name}`, which is not differentiated; drive only ports"
        ))),
        None => Ok(()),
    }
}
