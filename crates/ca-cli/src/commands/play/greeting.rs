//! What a page is sent first: what there is to see and to touch.

use super::energy::KineticEnergy;
use crate::commands::render::stability;
use crate::commands::serve::param;
use ca_core::Scene;
use ca_core::io::midi::MidiSource;
use ca_core::scene::{Input, InputRole};
use ca_view::Drawing;
use serde_json::{Value, json};

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

/// The keys that some port listens to: from … to, or none.
fn notes(scene: &Scene) -> Value {
    let range = |i: &Input| match i.midi?.source {
        MidiSource::Note { low, high } => Some((low, high)),
        _ => None,
    };
    let all = scene.inputs.iter().filter_map(range).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    all.map_or(Value::Null, |(low, high)| json!([low, high]))
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
