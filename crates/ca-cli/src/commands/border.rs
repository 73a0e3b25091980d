//! Prints the rate boundary of a scene: delays of force and sound, and the demands of its keys on a device.

use crate::args::Source;
use crate::outcome::Failure;
use crate::term;
use ca_core::Scene;
use ca_core::internal::border::{Delays, delays};
use ca_core::internal::op::layout::Shape;
use ca_lab::facts::border::{key_demands, latency, quantity};
use ca_model::quantity::short;
use serde_json::{Value as Json, json};
use std::io::Write;

/// Limit on the keys printed one by one.
const KEYS: usize = 5;

pub(crate) fn text(out: &mut impl Write, scene: &Scene) -> Result<(), Failure> {
    if let Some(line) = latency(scene) {
        writeln!(out, "  latency    {line}")?;
    }
    Ok(())
}

pub(crate) fn keys(out: &mut impl Write, scene: &Scene) -> Result<(), Failure> {
    let (d, keys) = (delays(scene), key_demands(scene));
    let mut lead = "keys       ";
    for (name, k, b) in keys.iter().take(KEYS) {
        let (k, b) = (quantity(*k), short(*b));
        writeln!(
            out,
            "  {lead}`{name}`: sum of springs {k}; to stay passive, the device needs a friction of {b} N s/m"
        )?;
        lead = "           ";
    }
    if keys.len() > KEYS {
        writeln!(out, "  {lead}and {} more, none of them stiffer", keys.len() - KEYS)?;
    }
    if !keys.is_empty() {
        let later = Delays { spring: d.spring + d.frame, ..d };
        let [most, less] = [d, later].map(|d| quantity(d.stiffest(1.0)));
        writeln!(
            out,
            "             a friction of 1 N s/m allows {most}, or {less} if the device applies each force a frame later"
        )?;
    }
    Ok(())
}

pub(crate) fn json(scene: &Scene) -> Json {
    let d = delays(scene);
    let device = !scene.ports.tgr.is_empty();
    let keys: Vec<Json> =
        key_demands(scene).iter().map(|(name, k, b)| json!({"name": name, "k": k, "friction": b})).collect();
    let border = device.then(|| {
        json!({
            "shape": if scene.rates.frame == 1 { "synchronous" } else { shape(scene) }, "latency": scene.ports.crossing.latency,
            "feedback": scene.ports.crossing.feedback, "spring_delay_ms": d.spring * 1e3,
            "stiffest_per_friction": d.stiffest(1.0), "keys": keys,
        })
    });
    json!({
        "gesture_to_force_ms": (device && scene.ports.crossing.feedback).then_some(d.force * 1e3),
        "gesture_to_sound_ms": device.then_some(d.sound * 1e3), "filter_ms": d.filter * 1e3, "border": border,
    })
}

fn shape(scene: &Scene) -> &'static str {
    match scene.ports.crossing.shape {
        Shape::Linear => "linear",
        Shape::Hold => "hold",
    }
}

/// Prints a note if options set the rate boundary of a scene without device keys.
pub(crate) fn idle(source: &Source, scene: &Scene) {
    if scene.ports.tgr.is_empty() && source.crossing().next().is_some() {
        term::note("`--border`, `--latency` and `--no-feedback` have no effect: the model has no device key (TGR)");
    }
}
