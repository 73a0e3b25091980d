//! Running: a scene driven by a program from outside, with inputs in, and sound and forces out.
//!
//! A [`Running`] holds the player with its live parameters, its level, and the source of the force on each port. A
//! block of an audio program (`cordis_anima::Voice`) and one of Python (`Sim`) are loops over the two halves of its
//! player. A scene that plays its own gesture is a [`Performance`](crate::perform::Performance).

use crate::play::player::Player;
use crate::sound::Level;
use ca_core::internal::state::checksum;
use ca_core::{Controls, NotRestored, Scene};

/// Source of the force on a port.
#[derive(Clone, Copy, Debug)]
enum PortForce {
    /// Force on a MAT.
    Mat(usize),
    /// Force of the last whole frame of a device.
    Border(usize),
    /// No force: a force port.
    None,
}

/// A player with its parameters, level and port forces. Every call takes the scene of the player.
pub struct Running {
    /// Player with the state.
    pub player: Player,
    /// Live parameters.
    pub controls: Controls,
    /// Level of the sound so far.
    pub level: Level,
    forces: Vec<PortForce>,
}

impl Running {
    /// Starts at the beginning of the scene.
    pub fn new(scene: &Scene) -> Running {
        let mut forces = vec![PortForce::None; scene.inputs.len()];
        scene.ports.enx.iter().for_each(|p| forces[p.input as usize] = PortForce::Mat(p.mat as usize));
        scene.ports.tgr.iter().enumerate().for_each(|(k, p)| forces[p.input as usize] = PortForce::Border(k));
        let level = Level::new(scene.counts.channels);
        Running { player: Player::new(scene.state()), controls: scene.controls(), level, forces }
    }

    /// Returns the inputs with a force: ports of positions.
    pub fn force_inputs(&self) -> Vec<usize> {
        (0..self.forces.len()).filter(|i| !matches!(self.forces[*i], PortForce::None)).collect()
    }

    /// Returns the force on the port of an input, between the halves of a tick \[N\]; for a device, the force of the
    /// last whole frame. It is 0 on a force port, for a force that is not finite, and after a divergence.
    pub fn force(&self, input: usize) -> f64 {
        let force = match self.forces.get(input) {
            Some(PortForce::Mat(m)) => self.player.state.f[*m],
            Some(PortForce::Border(k)) => self.player.state.ports.border[*k].force,
            _ => 0.0,
        };
        if self.player.diverged || !force.is_finite() { 0.0 } else { force }
    }

    /// Returns everything as bytes: the state, then the rest, eight bytes a number, little-endian.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Level { peak, clipped, beyond, non_finite } = &self.level;
        let values = self.controls.params().iter().map(|p| p.value).chain(peak.iter().copied()).map(f64::to_bits);
        let counts = [*clipped, *beyond, *non_finite, u64::from(self.player.diverged)];
        let mut bytes = self.player.state.to_bytes();
        values.chain(counts).for_each(|v| bytes.extend(v.to_le_bytes()));
        let sum = checksum(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    /// Restores from such bytes.
    ///
    /// # Errors
    /// [`NotRestored`]; then nothing has changed.
    pub fn restore(&mut self, scene: &Scene, bytes: &[u8]) -> Result<(), NotRestored> {
        let mut restored = Running::new(scene);
        let params = restored.controls.params().len();
        let beside = 8 * (params + restored.level.peak.len() + 4);
        let (whole, sum) = bytes.split_at(bytes.len().saturating_sub(8));
        let (state, beside) = whole.split_at(whole.len().saturating_sub(beside));
        // the state of another scene gives its own error, before the checksum
        restored.player.state.restore(state)?;
        if sum.first_chunk().map(|w| u64::from_le_bytes(*w)) != Some(checksum(whole)) {
            return Err(NotRestored::Damaged);
        }
        let mut words = beside.as_chunks::<8>().0.iter().map(|w| u64::from_le_bytes(*w));
        let mut next = || words.next().ok_or(NotRestored::Damaged);
        let mut patch = ca_core::Patch::default();
        for p in 0..params {
            // the state already contains its effect on coefficients
            let value = f64::from_bits(next()?);
            restored.controls.set_indexed(p, value, &mut patch).map_err(|_| NotRestored::Damaged)?;
        }
        for peak in &mut restored.level.peak {
            *peak = f64::from_bits(next()?);
        }
        let Level { clipped, beyond, non_finite, .. } = &mut restored.level;
        (*clipped, *beyond, *non_finite) = (next()?, next()?, next()?);
        restored.player.diverged = next()? != 0;
        *self = restored;
        Ok(())
    }
}
