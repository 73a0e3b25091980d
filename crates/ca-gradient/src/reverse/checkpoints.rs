//! Checkpoints: a scene that was played for a later backward pass, with a state stored now and then.
//!
//! Checkpoints are √n ticks apart, so memory grows with the root of the number of ticks. Half or a quarter of that
//! distance would let the replayed ticks fit into a nearer cache, but storing the states took as long as was gained.

use super::{Gradient, Reverse};
use crate::parts::no;
use crate::play_io::{BLOCK, diverged, frames_of, known, zeros};
use crate::{Error, GoesOn};
use ca_core::State;
use ca_core::internal::numeric::Aligned;
use ca_io::gesture::Gesture;
use ca_io::perform::{self, Performance};
use std::sync::Arc;

/// Scene played by [`Reverse::play`]: its outputs, and what a backward pass needs.
pub struct Checkpoints {
    reverse: Arc<Reverse>,
    kept: Checkpointed,
    /// Outputs, with the bits of a render (frames x outputs).
    pub output: Vec<f64>,
}

impl Reverse {
    /// Plays the scene and stores what a gradient needs, for a loss that is computed from the outputs. This takes as
    /// long as playing; [`Reverse::gradient`] plays once more instead.
    ///
    /// # Errors
    /// As [`Reverse::output`]; [`Error::Refused`] where the gesture is not supported, as [`Reverse::knows`].
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
        let kept = Checkpointed::of(self, frames, gesture, &mut |row| output.extend_from_slice(row), goes_on)?;
        Ok(Checkpoints { reverse: self.clone(), kept, output })
    }
}

impl Checkpoints {
    /// Number of samples played.
    pub fn frames(&self) -> usize {
        self.kept.frames
    }

    /// Returns the gradient of a loss of the outputs from its cotangent (frames x outputs), as [`Reverse::gradient`].
    ///
    /// # Errors
    /// As [`Reverse::gradient`]; [`Error::Refused`] where the cotangent has another number of samples than the outputs.
    pub fn gradient(&self, cotangent: &[f64], goes_on: GoesOn) -> Result<Gradient, Error> {
        let outputs = self.reverse.outputs().max(1);
        if frames_of(cotangent, outputs)? != self.kept.frames {
            let what = format!(
                "the cotangent has {} samples, but {} were played",
                cotangent.len() / outputs,
                self.kept.frames
            );
            return Err(Error::refused(what));
        }
        self.reverse.back(&self.kept, cotangent, goes_on)
    }
}

pub(super) struct Checkpointed {
    pub frames: usize,
    /// Ticks between two states.
    pub stretch: usize,
    /// State at the beginning of each stretch, without its coefficients if nothing changes them.
    states: Vec<State>,
    coef: Option<Aligned>,
    /// Inputs of the ports (frames x inputs).
    pub given: Vec<f64>,
}

impl Checkpointed {
    /// Plays a scene; `on_outputs` receives the outputs of each stretch (its ticks x outputs).
    pub fn of(
        reverse: &Reverse,
        frames: usize,
        gesture: Option<&Gesture>,
        on_outputs: &mut dyn FnMut(&[f64]),
        goes_on: GoesOn,
    ) -> Result<Checkpointed, Error> {
        let scene = &reverse.scene;
        let mut p = Performance::new(scene, gesture)?;
        known(scene, &p)?;
        if let Some(port) = reverse.starting_port(&p) {
            return Err(no(&format!("its initial state depends on the position of the port `{port}` at load")));
        }
        let (inputs, stretch) = (scene.inputs.len(), stretch(frames));
        let mut kept =
            Checkpointed { frames, stretch, states: Vec::new(), coef: None, given: zeros(frames, inputs, 1)? };
        // no gesture moves a live parameter, so only ports can drive coefficients
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
            on_outputs(&row);
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

    /// Calls `each` with the index and first state of each stretch, from the last to the first, until it fails.
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

/// Ticks between two states, for `frames` ticks in all.
fn stretch(frames: usize) -> usize {
    (frames as f64).sqrt().ceil() as usize
}
