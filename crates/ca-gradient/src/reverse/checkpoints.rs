//! Checkpoints: a scene that was played to be gone back over, with a state kept now and then.
//!
//! Decides for √n ticks between two: memory grows with the root of the number of ticks. With half or a quarter as many, of which all
//! that is played again would stay in a nearer cache, to keep the states took as long as was gained.

use super::{Gradient, Reverse};
use crate::parts::no;
use crate::played::{BLOCK, diverged, frames_of, known, zeros};
use crate::{Error, GoesOn};
use ca_core::State;
use ca_core::internal::numeric::Aligned;
use ca_io::gesture::Gesture;
use ca_io::perform::{self, Performance};
use std::sync::Arc;

/// A scene that was played by [`Reverse::play`]: what was heard, and what it takes to go back over it.
pub struct Checkpoints {
    reverse: Arc<Reverse>,
    kept: Kept,
    /// what was heard; the bits of a render (frames x outputs)
    pub output: Vec<f64>,
}

impl Reverse {
    /// Plays it, and keeps what a gradient begins with: for a loss that is known when the sound is. Takes as long as to play it;
    /// [`Reverse::gradient`] plays once more instead.
    ///
    /// # Errors
    /// As [`Reverse::output`]; [`Error::Refused`] where it does not know the gesture, as [`Reverse::knows`].
    pub fn play(
        self: &Arc<Self>,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        goes_on: GoesOn,
    ) -> Result<Checkpoints, Error> {
        let seconds = perform::seconds(&Performance::new(&self.scene, gesture)?, seconds);
        let frames = usize::try_from(perform::frames(&self.scene, seconds)).unwrap_or(usize::MAX);
        let mut output = zeros(frames, self.scene.counts.n_out, 1)?;
        output.clear();
        let kept = Kept::of(self, frames, gesture, &mut |row| output.extend_from_slice(row), goes_on)?;
        Ok(Checkpoints { reverse: self.clone(), kept, output })
    }
}

impl Checkpoints {
    /// How many samples were played.
    pub fn frames(&self) -> usize {
        self.kept.frames
    }

    /// The gradient of a loss of what was heard, from its cotangent (frames x outputs), as [`Reverse::gradient`].
    ///
    /// # Errors
    /// As [`Reverse::gradient`]; [`Error::Refused`] where the cotangent has not as many numbers as what was heard.
    pub fn gradient(&self, cotangent: &[f64], goes_on: GoesOn) -> Result<Gradient, Error> {
        let outputs = self.reverse.outputs().max(1);
        if frames_of(cotangent, outputs)? != self.kept.frames {
            let what = format!(
                "a cotangent of {} samples, of {} that were heard",
                cotangent.len() / outputs,
                self.kept.frames
            );
            return Err(Error::refused(what));
        }
        self.reverse.back(&self.kept, cotangent, goes_on)
    }
}

/// What it takes to go back over so many ticks.
pub(super) struct Kept {
    pub frames: usize,
    /// ticks between two states
    pub stretch: usize,
    /// those each stretch begins with, without their coefficients where nothing changes these
    states: Vec<State>,
    coef: Option<Aligned>,
    /// what the ports were given (frames x inputs)
    pub given: Vec<f64>,
}

impl Kept {
    /// Of a scene, played for so many ticks; each stretch is `heard` (its ticks x outputs).
    pub fn of(
        reverse: &Reverse,
        frames: usize,
        gesture: Option<&Gesture>,
        heard: &mut dyn FnMut(&[f64]),
        goes_on: GoesOn,
    ) -> Result<Kept, Error> {
        let scene = &reverse.scene;
        let mut p = Performance::new(scene, gesture)?;
        known(scene, &p)?;
        if let Some(port) = reverse.starting_port(&p) {
            return Err(no(&format!("where the port `{port}` is at load is part of the start")));
        }
        let (inputs, stretch) = (scene.inputs.len(), stretch(frames));
        let mut kept = Kept { frames, stretch, states: Vec::new(), coef: None, given: zeros(frames, inputs, 1)? };
        // no gesture moves a live parameter, so ports alone may drive them
        let same = reverse.parts.driven.is_empty();
        let (given, mut row) = (&mut kept.given, Vec::new());
        let (driven, mut asked) = (!p.driven().is_empty(), 0);
        for first in (0..frames).step_by(stretch) {
            let coef = same.then(|| std::mem::take(&mut p.state.coef));
            kept.states.push(p.state.clone());
            if let Some(coef) = coef {
                p.state.coef = coef;
            }
            let ticks = stretch.min(frames - first);
            row.clear();
            if driven {
                for to in given[first * inputs..][..ticks * inputs].chunks_exact_mut(inputs) {
                    p.tick();
                    to.copy_from_slice(&p.state.input);
                    row.extend_from_slice(&p.state.output[..scene.counts.n_out]);
                }
            } else {
                p.ticks(ticks as u64, &mut row);
                for to in given[first * inputs..][..ticks * inputs].chunks_exact_mut(inputs.max(1)) {
                    to.copy_from_slice(&p.state.input);
                }
            }
            heard(&row);
            asked += ticks as u64;
            if asked >= BLOCK {
                asked = 0;
                if !goes_on() {
                    return Err(Error::Stopped);
                }
            }
        }
        let silent = p.diverged;
        kept.coef = same.then_some(p.player.state.coef);
        if silent { Err(diverged()) } else { Ok(kept) }
    }

    /// Calls with the number of each stretch and the state it begins with, from the last to the first, until one is an error.
    pub fn back(&self, mut each: impl FnMut(usize, &mut State) -> Result<(), Error>) -> Result<(), Error> {
        let mut coef = self.coef.clone();
        for (k, state) in self.states.iter().enumerate().rev() {
            let mut state = state.clone();
            if let Some(coef) = &mut coef {
                std::mem::swap(&mut state.coef, coef);
            }
            each(k, &mut state)?;
            if let Some(coef) = &mut coef {
                std::mem::swap(&mut state.coef, coef);
            }
        }
        Ok(())
    }
}

/// Ticks between two states, of so many in all.
fn stretch(frames: usize) -> usize {
    (frames as f64).sqrt().ceil() as usize
}
