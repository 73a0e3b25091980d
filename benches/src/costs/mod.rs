//! What each guard, check and method costs, and that what a scene does not use costs it nothing.
//!
//! Decides that a price is a difference: a run with the thing, less the same run without it, over the modules that have
//! it. So nothing is taken apart that runs as a whole, and what the compiler chooses otherwise because of it (another
//! law, another pass) is in the price. Two kinds of proof that nobody pays for what is absent: where a thing can stand
//! in a scene that does not hear it, both are counted and must be equal, and [`CostRow::nothing`] finds the same passes and
//! the same state in them; where it cannot, its passes and its numbers in the state are named, and are not there.
//!
//! The bench is `benches/costs.rs`; the page it writes, [`page`].

mod hand;
pub mod page;
mod scenes;

use crate::{compiled, model};
use ca_compile::KernelClass;
use ca_core::internal::state::give_to;
use ca_core::{Identity, Scene, State, tick};
pub use hand::Rig;
use std::hint::black_box;

/// What is played, by ticks of a scene or by gesture frames of a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Run {
    /// a scene
    Scene(Played),
    /// what stands between it and a hand
    Hand(Rig),
}

/// A scene as it is played.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// the model
    pub text: String,
    /// with the energy ledger
    pub energy: bool,
    /// what is done besides
    pub also: Also,
}

/// What is done besides ticking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Also {
    /// nothing
    Nothing,
    /// the live parameter `k` is always on its way
    Ramps,
    /// every gesture frame it is asked whether the state is sound
    Watches,
    /// every gesture frame the state is hashed
    Hashes,
    /// one pass is left out, by name
    Omits(&'static str),
}

/// Something that goes on for as many ticks or frames as asked.
pub type Player = Box<dyn FnMut(u32)>;

/// Why a scene without it pays nothing.
pub enum Without {
    /// this model has it where nothing hears it: counted, and the same passes and state as without
    Unheard(String),
    /// it is what makes these passes, and this many numbers of the state
    Absent(&'static [&'static str], fn(&State) -> usize),
    /// whoever plays the scene asks, not the scene
    Outside,
    /// a device has it, as the stage of this name where it is one, all devices or only those that ask
    Device(Option<&'static str>, bool),
    /// every scene has it
    Always,
}

/// A line of the page.
pub struct CostRow {
    /// what is priced
    pub thing: &'static str,
    /// with what, and of which module the price is
    pub with: &'static str,
    /// modules in the run
    pub modules: f64,
    /// without the thing
    pub plain: Run,
    /// with it
    pub used: Run,
    /// why others do not pay
    pub without: Without,
}

/// All rows, in the order of the page.
pub fn rows() -> Vec<CostRow> {
    let mut all = scenes::rows();
    all.extend(hand::rows());
    all
}

impl Played {
    /// A model, played as it is.
    pub fn new(text: impl Into<String>) -> Played {
        Played { text: text.into(), energy: false, also: Also::Nothing }
    }

    /// Compiled.
    pub fn scene(&self) -> Scene {
        let mut scene = compiled(&model(&self.text), KernelClass::Fast, self.energy);
        if let Also::Omits(name) = self.also {
            let all = scene.passes.moves.len();
            scene.passes.moves.retain(|op| op.name() != name);
            assert!(scene.passes.moves.len() < all, "there is no pass `{name}`");
        }
        scene
    }
}

/// Farther than anything here goes \[m\].
const DIVERGED: f64 = 1e3;

impl Played {
    /// From its beginning on.
    fn player(&self) -> Player {
        let (scene, also) = (self.scene(), self.also);
        let mut state = scene.state();
        if also == Also::Ramps {
            let mut controls = scene.controls();
            let k = controls.params().iter().find(|p| p.name == "k").map_or(0.0, |p| p.value);
            let patch = controls.set("k", 1.001 * k).expect("`k` is live");
            assert!(state.apply(&patch, u32::MAX) && state.ramps.is_moving());
        }
        let frame = if matches!(also, Also::Watches | Also::Hashes) { scene.rates.ratio } else { u32::MAX };
        Box::new(move |n| {
            let mut left = n;
            while left > 0 {
                let now = left.min(frame);
                (0..now).for_each(|_| tick(&scene, &mut state));
                left -= now;
                match also {
                    Also::Watches => assert!(state.is_bounded(DIVERGED)),
                    Also::Hashes => assert!(black_box(state.bits()) != 0),
                    _ => {}
                }
            }
            assert!(state.is_bounded(DIVERGED), "it diverges");
        })
    }
}

impl Run {
    /// From its beginning on.
    pub fn player(&self) -> Player {
        match self {
            Run::Scene(played) => played.player(),
            Run::Hand(rig) => rig.player(),
        }
    }

    /// Whether it goes by gesture frames, not by ticks.
    pub fn is_hand(&self) -> bool {
        matches!(self, Run::Hand(_))
    }

    fn scene(&self) -> Option<Scene> {
        if let Run::Scene(played) = self { Some(played.scene()) } else { None }
    }
}

/// Passes of a scene: name, modules, kernel.
fn passes(scene: &Scene) -> Vec<(&'static str, usize, usize)> {
    let all = [&scene.passes.reads[..], scene.passes.summed(), &scene.passes.writes, &scene.passes.moves]
        .into_iter()
        .flatten();
    all.map(|op| (op.name(), op.n, op.kernel as usize)).collect()
}

/// The state at load, but for whose it is and for what callers give to ports: they may, to those that nothing hears too.
fn state(scene: &Scene) -> State {
    let mut state = scene.state();
    give_to(&mut state, Identity::default());
    (state.input, state.ports.last_input) = (Vec::new(), Vec::new());
    state
}

impl CostRow {
    /// The scene of the row that has the thing and does not hear it.
    pub fn unheard(&self) -> Option<Run> {
        let Without::Unheard(text) = &self.without else { return None };
        Some(Run::Scene(Played::new(text.clone())))
    }

    /// Looks whether a scene without it really has nothing of it, and one with it has; says what is wrong.
    pub fn nothing(&self) -> Result<(), String> {
        let scenes = self.plain.scene().zip(self.used.scene());
        match (&self.without, scenes) {
            (Without::Unheard(_), Some((plain, used))) => {
                let Some(unheard) = self.unheard().and_then(|run| run.scene()) else { return Err("no scene".into()) };
                if passes(&plain) != passes(&unheard) || state(&plain) != state(&unheard) {
                    return Err(format!("{:?} instead of {:?}, or another state", passes(&unheard), passes(&plain)));
                }
                if passes(&plain) == passes(&used) && state(&plain) == state(&used) {
                    return Err("nothing is different with it".into());
                }
            }
            (Without::Absent(made, numbers), Some((plain, used))) => {
                let made = |scene: &Scene| passes(scene).iter().filter(|p| made.contains(&p.0)).count();
                let (of, with) = ((made(&plain), numbers(&plain.state())), (made(&used), numbers(&used.state())));
                if of != (0, 0) || with.0 == 0 {
                    return Err(format!("passes and numbers: {of:?} without it, {with:?} with it"));
                }
            }
            (Without::Outside, Some((plain, used))) => {
                if passes(&plain) != passes(&used) || state(&plain) != state(&used) {
                    return Err("the scene knows of it".into());
                }
            }
            (Without::Always, Some(_)) => {}
            (Without::Device(stage, asked), None) => return hand::nothing(*stage, *asked),
            _ => return Err("what is played is not what is asked about".into()),
        }
        Ok(())
    }
}
