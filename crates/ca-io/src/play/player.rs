//! Player: steps a state until it diverges, for any number type of the tick.
//!
//! All loops over a scene step a player: by halves or ticks if the caller reads or writes between them, by blocks
//! otherwise. All of these give the same bits.

use ca_core::{Real, Scene, State, compute_forces, integrate, process};

/// Displacement beyond which a scene has diverged \[m\]: far above the scales of models (1e-9 to 1e9), far below
/// overflow.
pub const DIVERGED: f64 = 1e15;

/// Ticks between two checks for divergence.
const LOOK: u64 = 64;

/// A state being played. Every call takes the scene of the state.
pub struct Player<R: Real = f64> {
    /// State.
    pub state: State<R>,
    /// True once positions have left every sensible range; then nothing is computed and outputs are 0.
    pub diverged: bool,
}

impl<R: Real> Player<R> {
    /// Starts from a state.
    pub fn new(state: State<R>) -> Player<R> {
        Player { state, diverged: false }
    }

    /// Runs the first half of a tick, which gives outputs and forces.
    #[inline]
    pub fn sense(&mut self, scene: &Scene<R>) {
        if self.diverged {
            self.state.output.fill(R::Outer::of(0.0));
        } else {
            compute_forces(scene, &mut self.state);
        }
    }

    /// Runs the second half of a tick, which moves the masses.
    #[inline]
    pub fn advance(&mut self, scene: &Scene<R>) {
        if !self.diverged {
            integrate(scene, &mut self.state);
            self.look();
        }
    }

    /// Runs both halves; the outputs are in `state.output`.
    #[inline]
    pub fn tick(&mut self, scene: &Scene<R>) {
        self.sense(scene);
        self.advance(scene);
    }

    /// Runs `n` ticks with constant inputs, and appends the outputs of each to `rows`.
    pub fn ticks(&mut self, scene: &Scene<R>, n: u64, rows: &mut Vec<R::Outer>) {
        let mut left = n;
        while left > 0 {
            let run = left.min(LOOK - self.state.tick % LOOK);
            let first = rows.len();
            rows.resize(first + run as usize * scene.counts.n_out, R::Outer::of(0.0));
            if scene.counts.n_out > 0 && !self.diverged {
                let played = process(scene, &mut self.state, &mut rows[first..]);
                debug_assert!(played, "the state is of this scene, and rows are whole");
                self.look();
            } else {
                (0..run).for_each(|_| self.tick(scene));
            }
            left -= run;
        }
    }

    fn look(&mut self) {
        self.diverged = self.state.tick.is_multiple_of(LOOK) && !self.state.is_bounded(DIVERGED);
    }
}
