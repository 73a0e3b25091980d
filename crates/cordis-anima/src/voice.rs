//! Voice: a scene as a part of an audio program: blocks of planar `f32` in and out.
//!
//! Decides that a block never fails, allocates, locks or waits: names become handles before it, values out of range go to the end of
//! the range, a non-finite sample is silence, and so is all that follows once the scene has diverged. Who wants the
//! ticks themselves, or changes with an answer, uses [`tick`](crate::tick) and [`Scene::controls`](crate::Scene::controls).
//!
//! A voice is [`Send`] and belongs to one thread at a time, commonly that of the audio callback; scenes are shared between voices.
//! [`Voice::new`] allocates all there is and may take long; [`Voice::set`] computes the coefficients that follow from a parameter,
//! those of a whole string for its pitch. Where that is too much for a callback, another thread computes them with
//! [`Scene::controls`](crate::Scene::controls) and sends the patch, which [`Voice::apply`] takes at no cost.

use ca_core::{InputRole, LiveParam, NotRestored, Patch, Scene, State};
use ca_io::running::Running;
use ca_io::sound::Level;
use std::sync::Arc;

/// A live parameter of a scene; see [`Voice::param`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Param(usize);

/// A port of a scene; see [`Voice::port`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port(usize);

/// A scene that plays.
pub struct Voice {
    scene: Arc<Scene>,
    running: Running,
    patch: Patch,
    /// of each input, the force on its port at the last sample \[N\]
    felt: Vec<f64>,
}

impl Voice {
    /// A voice at the beginning: no port is driven, and the scene's own gesture is not played.
    pub fn new(scene: Arc<Scene>) -> Voice {
        let mut voice = Voice {
            running: Running::new(&scene),
            patch: Patch::default(),
            felt: vec![0.0; scene.inputs.len()],
            scene,
        };
        voice.warm();
        voice
    }

    /// The first change makes room for all others: each parameter goes where it is.
    fn warm(&mut self) {
        let controls = &mut self.running.controls;
        for p in 0..controls.params().len() {
            let value = controls.params()[p].value;
            // in range, since it is there
            let _ = controls.turn(p, value, &mut self.patch);
        }
    }

    /// What it plays.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Live parameters, with their present values, units and ranges.
    pub fn params(&self) -> &[LiveParam] {
        self.running.controls.params()
    }

    /// The live parameter called so.
    pub fn param(&self, name: &str) -> Option<Param> {
        self.params().iter().position(|p| p.name == name).map(Param)
    }

    /// The port called so, whatever its role.
    pub fn port(&self, name: &str) -> Option<Port> {
        self.scene.input(name).map(Port)
    }

    /// What a port takes: a position \[m\] or a force \[N\].
    pub fn role(&self, port: Port) -> Option<InputRole> {
        self.scene.inputs.get(port.0).map(|i| i.role)
    }

    /// Moves a live parameter to `value` \[SI\], or to the nearest end of its range, over so many samples (0 as 1), and returns
    /// the value that it goes to. NaN, or one that the scene cannot be computed with, leaves it as it was.
    pub fn set(&mut self, param: Param, value: f64, over: u32) -> f64 {
        let Some(p) = self.running.controls.params().get(param.0) else { return f64::NAN };
        // a NaN would be the lower end
        let (was, asked) = (p.value, value);
        let value = asked.max(p.min).min(p.max);
        if asked.is_nan() || self.running.controls.turn(param.0, value, &mut self.patch).is_err() {
            return was;
        }
        self.running.player.state.apply(&self.patch, over.saturating_mul(self.scene.oversample()));
        value
    }

    /// Takes a change that another thread computed, over so many samples; false where it is of another scene. What
    /// [`Voice::params`] says does not follow, and a later [`Voice::set`] of any parameter goes by that: a voice is given its values
    /// in one of the two ways.
    pub fn apply(&mut self, patch: &Patch, over: u32) -> bool {
        self.running.player.state.apply(patch, over.saturating_mul(self.scene.oversample()))
    }

    /// Gives a port a value that stays: absolute position \[m\], or force \[N\].
    pub fn hold(&mut self, port: Port, value: f64) {
        if let Some(input) = self.running.player.state.input.get_mut(port.0) {
            *input = value;
        }
    }

    /// Plays as many samples as the shortest of `out` has, a slice a channel, within ±1; channels that the scene does not have are
    /// silent. `inputs` drive ports sample by sample; where one is shorter, its last sample stays, and of all other ports
    /// what they had. A device port is read at the first sample of a gesture frame.
    pub fn process(&mut self, inputs: &[(Port, &[f32])], out: &mut [&mut [f32]]) {
        let n = out.iter().map(|channel| channel.len()).min().unwrap_or(0);
        for i in 0..n {
            for (port, samples) in inputs {
                if let (Some(v), Some(input)) = (samples.get(i), self.running.player.state.input.get_mut(port.0)) {
                    *input = f64::from(*v);
                }
            }
            self.running.player.sense(&self.scene);
            if i + 1 == n {
                self.felt.iter_mut().enumerate().for_each(|(k, felt)| *felt = self.running.force(k));
            }
            let Running { player, level, .. } = &mut self.running;
            for (k, channel) in out.iter_mut().enumerate() {
                channel[i] =
                    if k < self.scene.counts.channels { level.keep(k, player.state.output[k]) as f32 } else { 0.0 };
            }
            self.running.player.advance(&self.scene);
        }
    }

    /// The force on a position port at the last sample \[N\], of a device port that of the last whole frame; 0 on a force
    /// port, and once it has diverged.
    pub fn force(&self, port: Port) -> f64 {
        self.felt.get(port.0).copied().unwrap_or(0.0)
    }

    /// How loud it was, and how much was cut off.
    pub fn level(&self) -> &Level {
        &self.running.level
    }

    /// True once it has diverged: silent from there on.
    pub fn has_diverged(&self) -> bool {
        self.running.player.diverged
    }

    /// Back to the beginning, live parameters too; allocates, so between blocks and not in one.
    pub fn reset(&mut self) {
        *self = Voice::new(self.scene.clone());
    }

    /// How it stands.
    pub fn state(&self) -> &State {
        &self.running.player.state
    }

    /// All that decides its future as bytes, live parameters with it; allocates.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.running.to_bytes()
    }

    /// Goes on from such bytes of the same scene; allocates.
    ///
    /// # Errors
    /// [`NotRestored`], and nothing has changed.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), NotRestored> {
        self.running.restore(&self.scene, bytes)?;
        self.warm();
        Ok(())
    }
}
