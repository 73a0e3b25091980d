//! Renders the model with other values, and counts the renders.
//!
//! Every render counts: trial steps, differences for derivatives, and the last one for the page. Values with which the
//! model does not compile or diverges are not an error of the fit but a step too far.

use super::target::{Samples, mixed};
use super::variables::Varied;
use ca_compile::Options;
use ca_compile::analysis::{Network, modes};
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_lab::load::{self, Loaded};
use ca_lab::play::{self, BLOCK};
use ca_lab::{Failure, catalog};

/// Modes are not computed for models with more moving places, since that takes longer than renders.
const PLACES: usize = 300;

/// Mode as it is heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AudibleMode {
    /// Frequency \[Hz\].
    pub f: f64,
    /// Decay time \[s\].
    pub t60: f64,
    /// Level at the outputs, relative to the strongest mode.
    pub level: f64,
}

pub(super) struct Player<'a> {
    loaded: &'a Loaded,
    varied: &'a [Varied],
    gesture: Option<&'a Gesture>,
    rate: f64,
    channels: usize,
    /// Samples per render.
    pub frames: u64,
    pub renders: u32,
    pub budget: u32,
    goes_on: &'a mut dyn FnMut(u32, u32) -> bool,
}

impl<'a> Player<'a> {
    pub fn new(
        loaded: &'a Loaded,
        varied: &'a [Varied],
        gesture: Option<&'a Gesture>,
        (rate, channels, budget): (f64, usize, u32),
        goes_on: &'a mut dyn FnMut(u32, u32) -> bool,
    ) -> Player<'a> {
        Player { loaded, varied, gesture, rate, channels, frames: 0, renders: 0, budget, goes_on }
    }

    pub fn left(&self) -> u32 {
        self.budget.saturating_sub(self.renders)
    }

    /// Returns the model at these search coordinates.
    pub fn model(&self, places: &[f64]) -> Result<Loaded, Failure> {
        let mut loaded = self.loaded.clone();
        for (v, place) in self.varied.iter().zip(places) {
            load::set(&mut loaded, &v.name, v.setting(v.value(*place)))?;
        }
        Ok(loaded)
    }

    fn options(&self, loaded: &Loaded) -> Options {
        Options { rate: Some(self.rate), clouds: loaded.clouds.clone(), ..Options::default() }
    }

    /// Renders the model at these search coordinates; `None` where it does not compile or diverges.
    ///
    /// # Errors
    /// If the progress callback stops the fit, or the gesture does not fit the model.
    pub fn render(&mut self, places: &[f64]) -> Result<Option<Samples>, Failure> {
        self.renders += 1;
        if !(self.goes_on)(self.renders, self.budget) {
            return Err(Failure::Stopped);
        }
        let loaded = self.model(places)?;
        let Ok(scene) = loaded.compile(&self.options(&loaded)) else { return Ok(None) };
        let performance = Performance::new(&scene, self.gesture)?;
        let (channels, n_out) = (scene.counts.channels, scene.counts.n_out);
        let mut heard: Samples = vec![Vec::with_capacity(self.frames as usize); channels];
        let played = play::play(performance, self.frames, BLOCK, &mut |_, rows, _| {
            for row in rows.chunks_exact(n_out.max(1)) {
                heard.iter_mut().zip(row).for_each(|(c, x)| c.push(*x));
            }
            Ok::<(), Failure>(())
        })?;
        let whole = played.diverged_at.is_none() && heard.iter().flatten().all(|x| x.is_finite());
        Ok(whole.then(|| if channels == self.channels { heard } else { mixed(&heard) }))
    }

    /// Returns the audible modes, lowest first, at these search coordinates, without a render. Returns `None` where
    /// there are none or too many to compute.
    pub fn modes(&self, places: &[f64]) -> Result<Option<Vec<AudibleMode>>, Failure> {
        let loaded = self.model(places)?;
        let Ok(network) = ca_compile::linear(&loaded.model, &catalog(), &self.options(&loaded)) else {
            return Ok(None);
        };
        if network.linear.dofs.is_empty() || network.linear.dofs.len() > PLACES {
            return Ok(None);
        }
        let Some(found) = modes::modes(&network) else { return Ok(None) };
        let heard = |m: &modes::Mode| level(&network, m) * m.heard;
        let top = found.list.iter().map(heard).fold(0.0, f64::max);
        let swings = found.list.iter().filter(|m| m.heard > 0.0 && !m.grows && top > 0.0);
        let list: Vec<AudibleMode> =
            swings.map(|m| AudibleMode { f: m.heard, t60: m.t60, level: heard(m) / top }).collect();
        Ok(Some(list).filter(|l| !l.is_empty()))
    }
}

/// Returns the level of a mode at the outputs: its displacement at their places, also for outputs of speed or
/// acceleration. Outputs of forces do not count.
///
/// The weight does not depend on frequency because it only has to exclude modes with a node at every output. With a
/// factor (2πf)², the fundamental of a string of 40 masses would count as a node beside its highest mode.
fn level(network: &Network, m: &modes::Mode) -> f64 {
    let places = network.ports.iter().filter(|p| p.role == "hears").chain(&network.derivatives);
    places.map(|p| m.at(&p.at).abs()).sum()
}
