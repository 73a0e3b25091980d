//! Message `scene`: everything that a page shows and plays.

use crate::energy::KineticEnergy;
use crate::protocol::{Message, Param, PortInfo, PortRole, Preset};
use ca_core::internal::io::midi::MidiSource;
use ca_core::{Input, InputRole, LiveParam, Scene};
use ca_view::Drawing;
use std::collections::BTreeSet;

/// Makes the message `scene` for version `generation` of the model named `model`. `stability` describes the proven
/// stability.
pub fn greeting(scene: &Scene, drawing: &Drawing, model: &str, generation: u32, stability: String) -> Message {
    let params = scene.controls().params().iter().map(param).collect();
    let ports = scene.inputs.iter().enumerate().map(|(k, i)| port(scene, drawing, k, i)).collect();
    Message::Scene {
        generation,
        title: scene.about.title.clone(),
        model: model.into(),
        rate: scene.rate,
        frame: scene.rates.ratio,
        channels: scene.names.channel_names.clone(),
        drawing: drawing.json(),
        params,
        ports,
        gesture: !scene.about.gestures.is_empty(),
        presets: scene.about.presets.iter().map(preset).collect(),
        notes: notes(scene),
        seconds: scene.about.seconds,
        energy: KineticEnergy::new(scene).names().to_vec(),
        stability,
    }
}

/// Describes a live parameter, without infinite bounds.
fn param(p: &LiveParam) -> Param {
    let finite = |v: f64| v.is_finite().then_some(v);
    let (unit, doc) = (p.unit.symbol.into(), p.doc.clone());
    Param { name: p.name.clone(), value: p.value, min: finite(p.min), max: finite(p.max), unit, doc }
}

fn preset((name, values): &(String, Vec<(String, f64)>)) -> Preset {
    Preset { name: name.clone(), values: values.iter().cloned().collect() }
}

/// Returns the keys that play, lowest first, or `None`.
///
/// A port that only drives a parameter, such as the loudness of all notes, does not give keys, unless there are no
/// others.
fn notes(scene: &Scene) -> Option<Vec<u8>> {
    let range = |i: &Input| match i.midi?.source {
        MidiSource::Note { low, high } => Some(low..=high),
        _ => None,
    };
    let drives = |i: &Input| scene.live.driven.iter().any(|d| d.port == i.name);
    let (turn, play): (Vec<&Input>, Vec<&Input>) = scene.inputs.iter().partition(|i| drives(i));
    let of = |ports: Vec<&Input>| ports.into_iter().filter_map(range).flatten().collect::<BTreeSet<u8>>();
    let keys = Some(of(play)).filter(|k| !k.is_empty()).unwrap_or_else(|| of(turn));
    (!keys.is_empty()).then(|| keys.into_iter().collect())
}

fn port(scene: &Scene, drawing: &Drawing, k: usize, input: &Input) -> PortInfo {
    let role = match input.role {
        InputRole::Position => PortRole::Position,
        InputRole::Force => PortRole::Force,
        InputRole::Device => PortRole::Device,
    };
    let mut ports = scene.layout.ports.enx.iter().chain(&scene.layout.ports.tgr);
    let place = ports.find(|p| p.input as usize == k).map(|p| p.mat);
    let mass = place.and_then(|place| scene.symbols.places().iter().position(|p| *p == place));
    let mass = mass.and_then(|m| drawing.drawn_mass(m)).map(|m| m as u64);
    PortInfo { name: input.name.clone(), role, mass, rest: input.rest }
}
