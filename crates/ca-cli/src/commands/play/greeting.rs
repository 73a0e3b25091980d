//! What a page is sent first: what there is to see and to touch.

use super::energy::KineticEnergy;
use crate::commands::render::stability;
use crate::commands::serve::param;
use ca_core::Scene;
use ca_core::io::midi::MidiSource;
use ca_core::scene::{Input, InputRole};
use ca_view::Drawing;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// The message `scene`.
pub(super) fn greeting(scene: &Scene, drawing: &Drawing, model: &str, generation: u32) -> Value {
    let params: Vec<Value> = scene.controls().params().iter().map(param).collect();
    let ports: Vec<Value> = scene.inputs.iter().enumerate().map(|(k, i)| port(scene, drawing, k, i)).collect();
    json!({
        "type": "scene",
        "generation": generation,
        "title": scene.title,
        "model": model,
        "rate": scene.rate,
        "frame": scene.ratio,
        "channels": scene.channel_names,
        "drawing": drawing.json(),
        "params": params,
        "ports": ports,
        "gesture": !scene.gestures.is_empty(),
        "notes": notes(scene),
        "seconds": scene.seconds,
        "energy": KineticEnergy::new(scene).names(),
        "stability": stability(&scene.certificate),
    })
}

/// The keys that play, lowest first, or none.
///
/// A port that drives a parameter, such as the loudness of all notes, makes no key sound by itself.
fn notes(scene: &Scene) -> Value {
    let range = |i: &Input| match i.midi?.source {
        MidiSource::Note { low, high } => Some(low..=high),
        _ => None,
    };
    let drives = |i: &Input| scene.live.driven.iter().any(|d| d.port == i.name);
    let (turn, play): (Vec<&Input>, Vec<&Input>) = scene.inputs.iter().partition(|i| drives(i));
    let of = |ports: Vec<&Input>| ports.into_iter().filter_map(range).flatten().collect::<BTreeSet<u8>>();
    let keys = Some(of(play)).filter(|k| !k.is_empty()).unwrap_or_else(|| of(turn));
    if keys.is_empty() { Value::Null } else { json!(keys) }
}

fn port(scene: &Scene, drawing: &Drawing, k: usize, input: &Input) -> Value {
    let role = match input.role {
        InputRole::Position => "position",
        InputRole::Force => "force",
        InputRole::Device => "device",
    };
    let mut ports = scene.layout.enx.iter().chain(&scene.layout.tgr);
    let place = ports.find(|p| p.input as usize == k).map(|p| p.mat);
    let mass = place.and_then(|place| scene.symbols.places().iter().position(|p| *p == place));
    json!({"name": input.name, "role": role, "mass": mass.and_then(|m| drawing.drawn_mass(m)), "rest": input.rest})
}
