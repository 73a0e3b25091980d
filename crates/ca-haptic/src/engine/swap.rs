//! Replaces the scene by another version while it plays: masses with the same name continue from where they are.
//!
//! The new scene is made outside the engine, because that allocates, and replaces the old one between two gesture
//! frames. The old scene runs for [`FADE`] without devices, and its sound fades into the new sound to avoid a click. It
//! stays in memory until the next swap, because the engine frees nothing. Both scenes must have the same rates, outputs
//! and devices, because clocks, rings and files are made for these. Ports of devices are replaced: the last force on a
//! hand fades out, as without device frames, and forces begin again from zero if the device is armed.

use super::manual::ManualState;
use super::port::{Port, Setup};
use crate::guard::Order;
use ca_core::internal::border::group;
use ca_core::internal::op::layout::SlowGroup;
use ca_core::{InputRole, Location, Scene, State, compute_forces, integrate};
use std::collections::HashMap;
use std::sync::Arc;

/// Duration of the fade from the old sound to the new \[s\].
const FADE: f64 = 0.02;

/// A scene that replaces another; afterwards it contains the replaced one. A clone is only for the record: it contains
/// the number, but not the scene.
pub struct Swap {
    /// Number of versions before this one.
    pub number: u32,
    next: Option<Next>,
}

struct Next {
    scene: Arc<Scene>,
    state: State,
    ports: Vec<Port>,
    manual: ManualState,
    /// Places that continue: in the old state, and in the new one.
    carried: Vec<[u32; 2]>,
    /// The same in the states of groups at the gesture rate.
    slow: Vec<[u32; 2]>,
    /// The same for the values that links across the rate boundary hold, by index.
    held: Vec<[u32; 2]>,
    inputs: Vec<[u32; 2]>,
    /// Ticks left of the fade, and all its ticks.
    left: u32,
    fade: u32,
}

fn devices(scene: &Scene) -> Vec<&(String, u32)> {
    scene.inputs.iter().filter(|i| i.role == InputRole::Device).filter_map(|i| i.device.as_ref()).collect()
}

/// Returns the places of the MAT with the same name in both scenes: in the states of `old` and of `scene`, ordered by
/// the latter.
pub fn continuing_masses(old: &Scene, scene: &Scene) -> Vec<[u32; 2]> {
    let before = places(old);
    let mut carried: Vec<[u32; 2]> = Vec::new();
    for (name, (to, axes)) in places(scene) {
        if let Some((from, _)) = before.get(&name).filter(|b| b.1 == axes) {
            carried.extend((0..u32::from(axes)).map(|k| [from + k, to + k]));
        }
    }
    // in the order of memory
    carried.sort_unstable_by_key(|c| c[1]);
    carried
}

/// Returns the continuing places that belong to groups at the gesture rate in both scenes: as indices into the states
/// of the groups, and into the values that links across the rate boundary hold.
fn slow(old: &Scene, scene: &Scene, carried: &[[u32; 2]]) -> [Vec<[u32; 2]>; 2] {
    let own = |scene: &Scene| -> HashMap<u32, (u32, Option<u32>)> {
        let of = |g: &Arc<SlowGroup>| {
            let held = |i: usize| (i < g.coupled).then_some(i as u32);
            let all = g.ports.iter().chain(&g.shown).enumerate();
            all.map(|(i, p)| (p.at, (p.own, held(i)))).collect::<Vec<_>>()
        };
        scene.rates.slow.iter().flat_map(of).collect()
    };
    let (before, now) = (own(old), own(scene));
    let both: Vec<_> = carried.iter().filter_map(|[from, to]| Some([*before.get(from)?, *now.get(to)?])).collect();
    let held = both.iter().filter_map(|[from, to]| Some([from.1?, to.1?])).collect();
    [both.iter().map(|[from, to]| [from.0, to.0]).collect(), held]
}

/// Returns the first place and the number of axes of each MAT, by name.
fn places(scene: &Scene) -> HashMap<String, (u32, u8)> {
    let mats = (0..scene.mats()).filter_map(|i| scene.symbols.get(i));
    let place = |s: ca_core::Symbol| {
        let Location::Mat(place) = s.location else { return None };
        Some((s.name.to_string(), (place, if s.axes > 1 { 3 } else { 1 })))
    };
    mats.filter_map(place).collect()
}

/// A part of a scene that cannot change while it plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FixedPart {
    /// The rates of sound and gesture.
    Rates,
    /// The sound channels.
    Outputs,
    /// The device ports.
    Devices,
}

impl core::fmt::Display for FixedPart {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let what = match self {
            FixedPart::Rates => "the rates",
            FixedPart::Outputs => "the outputs",
            FixedPart::Devices => "the devices",
        };
        write!(f, "{what} cannot change while the model plays; stop it and start it again")
    }
}

impl core::error::Error for FixedPart {}

impl Swap {
    /// Prepares the change from `old` to `scene`, which begins in `state`. Masses with the same name continue from
    /// where they are, unless `anew` is true.
    ///
    /// # Errors
    /// If the scenes differ in a part that cannot change while it plays.
    pub fn new(
        old: &Scene,
        scene: Arc<Scene>,
        mut state: State,
        setups: &[Setup],
        (number, anew): (u32, bool),
    ) -> Result<Swap, FixedPart> {
        if (old.rate, old.rates.ratio) != (scene.rate, scene.rates.ratio) {
            return Err(FixedPart::Rates);
        }
        if old.names.channel_names != scene.names.channel_names {
            return Err(FixedPart::Outputs);
        }
        if devices(old) != devices(&scene) {
            return Err(FixedPart::Devices);
        }
        let same = |i: &ca_core::Input| old.inputs.iter().position(|o| (&o.name, o.role) == (&i.name, i.role));
        let inputs = scene.inputs.iter().enumerate().filter_map(|(to, i)| Some([same(i)? as u32, to as u32]));
        let inputs = if anew { Vec::new() } else { inputs.collect() };
        state.placed();
        let carried = if anew { Vec::new() } else { continuing_masses(old, &scene) };
        let [slow, held] = slow(old, &scene, &carried);
        let ports = setups.iter().map(|s| Port::new(&scene, s.clone())).collect();
        let fade = (FADE * scene.rate).round() as u32;
        let manual = ManualState::new(&scene);
        Ok(Swap {
            number,
            next: Some(Next { scene, state, ports, manual, carried, slow, held, inputs, left: fade, fade }),
        })
    }

    /// Exchanges the scenes without allocating. With `goes_on` the old state continues, with `fades` forces fade out.
    /// Returns false for a clone.
    pub(super) fn swap(
        &mut self,
        scene: &mut Arc<Scene>,
        state: &mut State,
        ports: &mut Vec<Port>,
        manual: &mut ManualState,
        (goes_on, fades): (bool, bool),
    ) -> bool {
        let Some(next) = &mut self.next else { return false };
        if goes_on {
            for [from, to] in &next.carried {
                let (from, to) = (*from as usize, *to as usize);
                (next.state.x[to], next.state.d[to]) = (state.x[from], state.d[from]);
            }
            let own = (state.slow.as_deref(), next.state.slow.as_deref_mut(), next.scene.rates.slow.as_deref());
            if let (Some(old), Some(slow), Some(group)) = own {
                for [from, to] in &next.slow {
                    let (from, to) = (*from as usize, *to as usize);
                    (slow.state.x[to], slow.state.d[to]) = (old.state.x[from], old.state.d[from]);
                }
                group::placed(group, slow);
                for [from, to] in &next.held {
                    let (from, to) = (*from as usize, *to as usize);
                    slow.ports[to].force = old.ports[from].force;
                    if let (Some(now), Some(before)) = (slow.unknown.get_mut(to), old.unknown.get(from)) {
                        *now = *before;
                    }
                }
                slow.state.tick = old.state.tick;
            }
            for [from, to] in &next.inputs {
                next.state.input[*to as usize] = state.input[*from as usize];
                next.state.ports.last_input[*to as usize] = state.ports.last_input[*from as usize];
            }
        } else {
            next.left = 0;
        }
        next.state.tick = state.tick;
        for (new, old) in next.ports.iter_mut().zip(ports.iter()) {
            if old.chain.is_armed() {
                new.chain.order(Order::Arm);
            }
            new.follow(old);
            if fades {
                new.fade_from(old);
            }
            new.reach_again(&next.state);
        }
        core::mem::swap(scene, &mut next.scene);
        core::mem::swap(state, &mut next.state);
        core::mem::swap(ports, &mut next.ports);
        core::mem::swap(manual, &mut next.manual);
        true
    }

    /// Plays one tick of the old scene up to its outputs, and fades them into `sound`, the outputs of the new scene.
    pub(super) fn sample(&mut self, sound: &mut [f64]) {
        let Some(next) = self.next.as_mut().filter(|n| n.left > 0) else { return };
        compute_forces(&next.scene, &mut next.state);
        let share = f64::from(next.left) / f64::from(next.fade);
        for (to, old) in sound.iter_mut().zip(&next.state.output) {
            // silence if it diverges meanwhile
            let old = if old.is_finite() { *old } else { 0.0 };
            *to += share * (old - *to);
        }
        next.left -= 1;
    }

    pub(super) fn advance(&mut self) {
        if let Some(next) = self.next.as_mut().filter(|n| n.left > 0) {
            integrate(&next.scene, &mut next.state);
        }
    }
}

impl Clone for Swap {
    fn clone(&self) -> Swap {
        Swap { number: self.number, next: None }
    }
}

impl PartialEq for Swap {
    fn eq(&self, other: &Swap) -> bool {
        self.number == other.number
    }
}

impl core::fmt::Debug for Swap {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Swap").field("number", &self.number).finish_non_exhaustive()
    }
}
