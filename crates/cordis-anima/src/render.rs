//! Plays a scene to its end, in memory.
//!
//! The loop is [`ca_io::play`], which the command and Python use too, so the bits are the same. To write a file, to
//! play another gesture or for the energy ledger, use [`ca_io`] (`examples/render.rs`).

use crate::error::Error;
use ca_core::Scene;
use ca_io::perform::{self, Performance};
use ca_io::play::{BLOCK, play};
use ca_io::{FileError, FileErrorKind};

/// Sound of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Number of sound channels.
    pub channels: usize,
    /// Samples, interleaved (frames × channels); 1 is full scale.
    pub sound: Vec<f64>,
    /// Time at which the scene had diverged and silence began \[s\].
    pub diverged: Option<f64>,
}

impl Rendered {
    /// Returns the number of samples in each channel.
    pub fn frames(&self) -> usize {
        self.sound.len() / self.channels.max(1)
    }
}

/// Plays a scene with its built-in gesture, for `seconds`, else for the length of the model, else until it dies away.
///
/// # Errors
/// [`Error::File`] if the gesture drives an unknown port, if `seconds` is negative or NaN, or if memory is too small.
pub fn render(scene: &Scene, seconds: Option<f64>) -> Result<Rendered, Error> {
    let p = Performance::new(scene, None)?;
    let seconds = perform::seconds(&p, seconds);
    if seconds.is_nan() || seconds < 0.0 {
        let e = FileError::new(FileErrorKind::Usage, format!("the duration {seconds} s is not valid"));
        return Err(e.fix("give 0 seconds or more").into());
    }
    let frames = perform::frames(scene, seconds);
    let (mut sound, mut diverged) = (Vec::new(), None);
    let len = usize::try_from(frames).ok().and_then(|n| n.checked_mul(scene.counts.channels.max(1)));
    if len.is_none_or(|n| sound.try_reserve_exact(n).is_err()) {
        let e = FileError::new(FileErrorKind::Usage, format!("{seconds} s of sound do not fit into memory"));
        return Err(e.fix("play a shorter time, or play in blocks with `ca_io::perform::Performance`").into());
    }
    play(p, frames, BLOCK, &mut |p, rows, _| {
        for row in rows.chunks_exact(scene.counts.n_out.max(1)) {
            sound.extend_from_slice(&row[..scene.counts.channels]);
        }
        if p.diverged && diverged.is_none() {
            diverged = Some(p.state.tick as f64 * scene.rates.sample_dt);
        }
        Ok::<(), Error>(())
    })?;
    Ok(Rendered { rate: scene.rate, channels: scene.counts.channels, sound, diverged })
}
