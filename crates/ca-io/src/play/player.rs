//! Player: a state that is played, over any number of the tick, until it has diverged.
//!
//! Loops over a scene step this: by halves or ticks where a caller reads or writes between them, by blocks where nothing interacts.
//! All of these give the same bits.

use ca_core::{Real, Scene, State, compute_forces, integrate, process};

/// A scene has diverged beyond this displacement \[m\]. Far above any scale models are written in (1e-9 to 1e9), far below overflow.
pub const DIVERGED: f64 = 1e15;

/// Ticks between two looks at whether it has diverged.
const LOOK: u64 = 64;

/// A state under way. Every call takes the scene it is of.
pub struct Player<R: Real = f64> {
    /// how it stands
    pub state: State<R>,
    /// true once positions have left every sensible range; nothing is computed any more, outputs are 0
    pub diverged: bool,
}

impl<R: Real> Player<R> {
    /// From a state on.
    pub fn new(state: State<R>) -> Player<R> {
        Player { state, diverged: false }
    }

    /// The first half of a tick: its outputs and its forces are there.
    #[inline]
    pub fn sense(&mut self, scene: &Scene<R>) {
        if self.diverged {
            self.state.output.fill(R::Outer::of(0.0));
        } else {
            compute_forces(scene, &mut self.state);
        }
    }

    /// The second half: masses move.
    #[inline]
    pub fn advance(&mut self, scene: &Scene<R>) {
        if !self.diverged {
            integrate(scene, &mut self.state);
            self.look();
        }
    }

    /// Both halves; the outputs are in `state.output`.
    #[inline]
    pub fn tick(&mut self, scene: &Scene<R>) {
        self.sense(scene);
        self.advance(scene);
    }

    /// Runs `n` ticks with the inputs as they are, and appends the outputs of each to `rows`.
    pub fn ticks(&mut self, scene: &Scene<R>, n: u64, rows: &mut Vec<R::Outer>) {
        let mut left = n;
        while left > 0 {
            // nothing is to be done between two looks at the state
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
