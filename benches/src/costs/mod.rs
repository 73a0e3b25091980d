//! Cost of each guard, check and method, and proof that a scene without it pays nothing.
//!
//! A price is a difference: a run with the thing, less the same run without it, divided by the number of modules that
//! have it. No part of a running whole is measured alone, and the price includes other choices that the compiler makes
//! because of it (another law, another pass).
//!
//! There are two kinds of proof that a scene without the thing pays nothing. If the thing can be in a scene without
//! reaching an output, both scenes are counted and must be equal; [`CostRow::nothing`] also compares their passes and
//! states. Otherwise its passes and its numbers in the state are named, and must be absent.
//!
//! The bench is `benches/costs.rs`; [`page`] makes its page.

mod device_costs;
pub mod page;
mod scenes;

use crate::{compiled, model};
use ca_compile::KernelClass;
use ca_core::internal::state::give_to;
use ca_core::{Identity, Scene, State, tick};
pub use device_costs::Rig;
use std::hint::black_box;

/// A run, by ticks of a scene or by gesture frames of a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Run {
    /// A scene.
    Scene(Played),
    /// The parts between a scene and a hand.
    Hand(Rig),
}

/// A scene and how it is played.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// Model.
    pub text: String,
    /// Plays with the energy ledger.
    pub energy: bool,
    /// Additional work.
    pub also: Also,
}

/// Work in addition to the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Also {
    /// None.
    Nothing,
    /// The live parameter `k` is always ramping.
    Ramps,
    /// The state is checked every gesture frame.
    Watches,
    /// The state is hashed every gesture frame.
    Hashes,
    /// The pass of this name is left out.
    Omits(&'static str),
}

/// Runs the given number of ticks or frames.
pub type Player = Box<dyn FnMut(u32)>;

/// Reason why a scene without the thing pays nothing.
pub enum Without {
    /// This model has it where it reaches no output: counted, with the same passes and state as without it.
    Unheard(String),
    /// It consists of these passes, and of this many numbers in the state.
    Absent(&'static [&'static str], fn(&State) -> usize),
    /// It is requested by the caller, not by the scene.
    Outside,
    /// It belongs to a device, as the stage of this name if it is one; with `true` only if the device asks for it.
    Device(Option<&'static str>, bool),
    /// Every scene has it.
    Always,
}

/// A row of the page.
pub struct CostRow {
    /// Thing that is priced.
    pub thing: &'static str,
    /// Scene in which it is priced, and module for which.
    pub with: &'static str,
    /// Number of modules in the run.
    pub modules: f64,
    /// Run without the thing.
    pub plain: Run,
    /// Run with it.
    pub used: Run,
    /// Reason why others do not pay.
    pub without: Without,
}

/// Returns all rows, in the order of the page.
pub fn rows() -> Vec<CostRow> {
    let mut all = scenes::rows();
    all.extend(device_costs::rows());
    all
}

impl Played {
    /// Takes a model, played as it is.
    pub fn new(text: impl Into<String>) -> Played {
        Played { text: text.into(), energy: false, also: Also::Nothing }
    }

    /// Compiles the scene.
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

/// Displacement beyond which a scene has diverged \[m\].
const DIVERGED: f64 = 1e3;

impl Played {
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
    /// Starts from the beginning.
    pub fn player(&self) -> Player {
        match self {
            Run::Scene(played) => played.player(),
            Run::Hand(rig) => rig.player(),
        }
    }

    /// Returns true for a run by gesture frames, false for one by ticks.
    pub fn is_hand(&self) -> bool {
        matches!(self, Run::Hand(_))
    }

    fn scene(&self) -> Option<Scene> {
        if let Run::Scene(played) = self { Some(played.scene()) } else { None }
    }
}

/// Returns the passes of a scene: name, modules, kernel.
fn passes(scene: &Scene) -> Vec<(&'static str, usize, usize)> {
    let all = [&scene.passes.reads[..], scene.passes.summed(), &scene.passes.writes, &scene.passes.moves]
        .into_iter()
        .flatten();
    all.map(|op| (op.name(), op.n, op.kernel as usize)).collect()
}

/// Returns the state at load without identity and inputs, which may differ because a caller may also drive ports that
/// reach no output.
fn state(scene: &Scene) -> State {
    let mut state = scene.state();
    give_to(&mut state, Identity::default());
    (state.input, state.ports.last_input) = (Vec::new(), Vec::new());
    state
}

impl CostRow {
    /// Returns the scene of the row that has the thing where it reaches no output.
    pub fn unheard(&self) -> Option<Run> {
        let Without::Unheard(text) = &self.without else { return None };
        Some(Run::Scene(Played::new(text.clone())))
    }

    /// Checks that a scene without the thing has nothing of it, and that one with it has; returns an error text.
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
            (Without::Device(stage, asked), None) => return device_costs::nothing(*stage, *asked),
            _ => return Err("what is played is not what is asked about".into()),
        }
        Ok(())
    }
}
