//! Plays a scene inside an audio program, in blocks of planar `f32`.
//!
//! A block never fails, allocates, locks or waits. Names are resolved to handles beforehand, values are clamped to
//! their range, a non-finite sample becomes silence, and a scene that has diverged stays silent. For single ticks use
//! [`tick`](crate::tick), and for changes that report errors [`Scene::controls`](crate::Scene::controls).
//!
//! A voice is [`Send`] and belongs to one thread at a time, commonly the audio callback; voices can share a scene.
//! [`Voice::new`] makes all allocations and may take long. [`Voice::set`] computes all coefficients that depend on a
//! parameter; a pitch changes a whole string. If that is too slow for a callback, another thread computes them by
//! [`Scene::controls`](crate::Scene::controls) and sends the patch to [`Voice::apply`].

use ca_core::{InputRole, LiveParam, NotRestored, Patch, Scene, State};
use ca_io::running::Running;
use ca_io::sound::Level;
use std::sync::Arc;

/// Handle of a live parameter, from [`Voice::param`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Param(usize);

/// Handle of a port, from [`Voice::port`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port(usize);

/// Scene that plays.
pub struct Voice {
    scene: Arc<Scene>,
    running: Running,
    patch: Patch,
    /// Force on each input port at the last sample \[N\].
    felt: Vec<f64>,
}

impl Voice {
    /// Starts a voice at the beginning. Its ports rest, and the built-in gesture of the scene is not played.
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

    /// Sets each parameter to its present value, so that later changes find their memory allocated.
    fn warm(&mut self) {
        let controls = &mut self.running.controls;
        for p in 0..controls.params().len() {
            let value = controls.params()[p].value;
            // cannot fail: the present value is in range
            let _ = controls.set_indexed(p, value, &mut self.patch);
        }
    }

    /// Returns the scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Returns the live parameters, with their present values, units and ranges.
    pub fn params(&self) -> &[LiveParam] {
        self.running.controls.params()
    }

    /// Returns the handle of the live parameter `name`.
    pub fn param(&self, name: &str) -> Option<Param> {
        self.params().iter().position(|p| p.name == name).map(Param)
    }

    /// Returns the handle of the port `name`, of any role.
    pub fn port(&self, name: &str) -> Option<Port> {
        self.scene.input(name).map(Port)
    }

    /// Returns the role of a port, which says whether it takes a position \[m\] or a force \[N\].
    pub fn role(&self, port: Port) -> Option<InputRole> {
        self.scene.inputs.get(port.0).map(|i| i.role)
    }

    /// Ramps a live parameter to `value` (SI units, clamped to its range) over `over` samples (0 acts as 1) and returns
    /// the target. NaN, or a value without valid coefficients, changes nothing and returns the current value.
    pub fn set(&mut self, param: Param, value: f64, over: u32) -> f64 {
        let Some(p) = self.running.controls.params().get(param.0) else { return f64::NAN };
        // `max` and `min` would make NaN the lower end
        let (was, asked) = (p.value, value);
        let value = asked.max(p.min).min(p.max);
        if asked.is_nan() || self.running.controls.set_indexed(param.0, value, &mut self.patch).is_err() {
            return was;
        }
        self.running.player.state.apply(&self.patch, over.saturating_mul(self.scene.oversample()));
        value
    }

    /// Applies a change that another thread computed, over `over` samples. Returns false for a patch of another scene.
    /// [`Voice::params`] does not follow the change, and the next [`Voice::set`] of any parameter starts from those
    /// values, so use one of the two ways for each voice.
    pub fn apply(&mut self, patch: &Patch, over: u32) -> bool {
        self.running.player.state.apply(patch, over.saturating_mul(self.scene.oversample()))
    }

    /// Sets a port to a value that stays: absolute position \[m\], or force \[N\].
    pub fn hold(&mut self, port: Port, value: f64) {
        if let Some(input) = self.running.player.state.input.get_mut(port.0) {
            *input = value;
        }
    }

    /// Plays the next block: as many samples as the shortest slice of `out`, which has a slice for each channel.
    ///
    /// Samples are within ±1; channels that the scene does not have are silent. `inputs` drive ports sample by sample.
    /// A port whose slice is shorter keeps its last sample, and the other ports keep their value. A device port is read
    /// at the first sample of a gesture frame.
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
                    if k < self.scene.counts.channels { level.count(k, player.state.output[k]) as f32 } else { 0.0 };
            }
            self.running.player.advance(&self.scene);
        }
    }

    /// Returns the force on a position port at the last sample \[N\], for a device port in the last whole frame. It is
    /// 0 on a force port, and after the scene has diverged.
    pub fn force(&self, port: Port) -> f64 {
        self.felt.get(port.0).copied().unwrap_or(0.0)
    }

    /// Returns the level of the sound and the number of clipped samples.
    pub fn level(&self) -> &Level {
        &self.running.level
    }

    /// Returns true once the scene has diverged. The voice is then silent.
    pub fn has_diverged(&self) -> bool {
        self.running.player.diverged
    }

    /// Returns to the beginning, live parameters included. It allocates, so call it between blocks.
    pub fn reset(&mut self) {
        *self = Voice::new(self.scene.clone());
    }

    /// Returns the state of the scene.
    pub fn state(&self) -> &State {
        &self.running.player.state
    }

    /// Saves all that determines the future of the voice as bytes, live parameters included. Allocates.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.running.to_bytes()
    }

    /// Continues from bytes of the same scene. Allocates.
    ///
    /// # Errors
    /// [`NotRestored`]; the voice is unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), NotRestored> {
        self.running.restore(&self.scene, bytes)?;
        self.warm();
        Ok(())
    }
}
