//! Running: a scene that a program plays sample by sample, from outside: inputs in, sound and forces out.
//!
//! With a state that is played by hand go its live parameters, its level, and the place of the force on each port. A block of an
//! audio program (`cordis_anima::Voice`) and one of Python (`Sim`) are loops over the two halves of its player; a scene that plays its
//! own gesture is a [`Performance`](crate::perform::Performance).

use crate::play::player::Player;
use crate::sound::Level;
use ca_core::internal::state::checksum;
use ca_core::{Controls, NotRestored, Scene};

/// Where the force on a port stands.
#[derive(Clone, Copy, Debug)]
enum PortForce {
    /// that on its MAT
    Mat(usize),
    /// that of the last whole frame of a device
    Border(usize),
    /// it gives one, and feels none
    None,
}

/// A player with all that goes with it. Every call takes the scene it is of.
pub struct Running {
    /// how it stands
    pub player: Player,
    /// live parameters
    pub controls: Controls,
    /// how loud it was
    pub level: Level,
    /// of each input
    forces: Vec<PortForce>,
}

impl Running {
    /// At the beginning.
    pub fn new(scene: &Scene) -> Running {
        let mut forces = vec![PortForce::None; scene.inputs.len()];
        scene.ports.enx.iter().for_each(|p| forces[p.input as usize] = PortForce::Mat(p.mat as usize));
        scene.ports.tgr.iter().enumerate().for_each(|(k, p)| forces[p.input as usize] = PortForce::Border(k));
        let level = Level::new(scene.counts.channels);
        Running { player: Player::new(scene.state()), controls: scene.controls(), level, forces }
    }

    /// Inputs that feel a force: ports of positions.
    pub fn felt(&self) -> Vec<usize> {
        (0..self.forces.len()).filter(|i| !matches!(self.forces[*i], PortForce::None)).collect()
    }

    /// The force on the port of an input, between the halves \[N\]: of a device that of the last whole frame; 0 on a
    /// force port, where it is not finite, and once it has diverged.
    pub fn force(&self, input: usize) -> f64 {
        let force = match self.forces.get(input) {
            Some(PortForce::Mat(m)) => self.player.state.f[*m],
            Some(PortForce::Border(k)) => self.player.state.ports.border[*k].force,
            _ => 0.0,
        };
        if self.player.diverged || !force.is_finite() { 0.0 } else { force }
    }

    /// All of it as bytes: the state, then what goes with it, eight bytes a number, lowest first.
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

    /// Goes on from such bytes.
    ///
    /// # Errors
    /// [`NotRestored`], and nothing has changed.
    pub fn restore(&mut self, scene: &Scene, bytes: &[u8]) -> Result<(), NotRestored> {
        let mut restored = Running::new(scene);
        let params = restored.controls.params().len();
        let beside = 8 * (params + restored.level.peak.len() + 4);
        let (whole, sum) = bytes.split_at(bytes.len().saturating_sub(8));
        let (state, beside) = whole.split_at(whole.len().saturating_sub(beside));
        // what is of another scene says so before anything else
        restored.player.state.restore(state)?;
        if sum.first_chunk().map(|w| u64::from_le_bytes(*w)) != Some(checksum(whole)) {
            return Err(NotRestored::Damaged);
        }
        let mut words = beside.as_chunks::<8>().0.iter().map(|w| u64::from_le_bytes(*w));
        let mut next = || words.next().ok_or(NotRestored::Damaged);
        let mut patch = ca_core::Patch::default();
        for p in 0..params {
            // what it does to coefficients is in the state already
            let value = f64::from_bits(next()?);
            restored.controls.turn(p, value, &mut patch).map_err(|_| NotRestored::Damaged)?;
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
