//! Describes the border of a scene: delays of force and sound, and the demands of its keys on a device.
//!
//! The model alone determines these; the loop of a device and the buffers of a sound card add to the delays.

use ca_core::equivalence::Scale;
use ca_core::internal::border::delays;
use ca_core::internal::op::layout::{Enx, Shape};
use ca_core::internal::scene::certificate::Key;
use ca_core::internal::state::Exchange;
use ca_core::{Ledger, Scene, Unit};
use ca_model::quantity::{short, show, six};

fn ms(seconds: f64) -> String {
    format!("{} ms", short(seconds * 1e3))
}

/// Describes the delays in one line; `None` for a scene without any.
pub fn latency(scene: &Scene) -> Option<String> {
    let d = delays(scene);
    let filter = (d.filter > 0.0).then(|| format!("{} from the output filter", ms(d.filter)));
    if scene.ports.tgr.is_empty() {
        return filter.is_some().then(|| format!("the output filter delays the sound by {}", ms(d.filter)));
    }
    let feedback = scene.ports.crossing.feedback;
    let force = if feedback { format!("gesture to force {}", ms(d.force)) } else { "no force feedback".into() };
    let mut notes: Vec<String> = Vec::new();
    if scene.ports.crossing.latency > 0 {
        let s = if scene.ports.crossing.latency == 1 { "" } else { "s" };
        notes.push(format!("{} frame{s} from `latency`", scene.ports.crossing.latency));
    }
    notes.extend(filter);
    let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join(", ")) };
    Some(format!("{force}, gesture to sound {}{notes}", ms(d.sound)))
}

/// Describes the two rates of a scene, and the ticks per sample if there are several.
pub fn rates(scene: &Scene) -> String {
    let hertz = |f: f64| show(six(f), Unit::HERTZ);
    let (sound, gesture) = (hertz(scene.rate), hertz(scene.rate / f64::from(scene.rates.ratio)));
    format!("sound {sound}{}, gesture {gesture}", ticks(scene.oversample()))
}

/// Describes the ticks per sample, as the end of a sentence; empty for one.
pub fn ticks(times: u32) -> String {
    if times > 1 { format!(" ({times} ticks per sample)") } else { String::new() }
}

/// Describes the rate boundary; `None` for a scene without one.
pub fn crossing(scene: &Scene) -> Option<&'static str> {
    (!scene.ports.tgr.is_empty()).then_some(match (scene.rates.frame, scene.ports.crossing.shape) {
        (1, _) => "one tick per frame, with the force of the tick",
        (_, Shape::Linear) => "positions interpolated linearly over the frame, mean force",
        (_, Shape::Hold) => "positions held over the frame, mean force around each jump",
    })
}

/// Returns the keys whose force reaches the hand, stiffest first.
fn rendered_keys(scene: &Scene) -> Vec<&Key> {
    let mut keys: Vec<&Key> =
        scene.certificate.keys.iter().filter(|k| scene.ports.crossing.feedback && k.k > 0.0).collect();
    keys.sort_by(|a, b| felt_as(scene, b).total_cmp(&felt_as(scene, a)));
    keys
}

/// Demands of keys on a device, stiffest first: name, stiffness in the hand \[N/m\], friction it needs \[N s/m\].
pub fn key_demands(scene: &Scene) -> Vec<(&str, f64, f64)> {
    let (d, keys) = (delays(scene), rendered_keys(scene));
    keys.into_iter().map(|k| (k.name.as_str(), felt_as(scene, k), d.friction(felt_as(scene, k)))).collect()
}

/// Describes how a key with another scale differs from the other keys.
pub fn scale_of(k: &Scale) -> String {
    let (g, h) = (short(k.position), short(k.force));
    if k.is_lever() {
        return format!("a lever of ratio {g}: positions and forces × {g}, energy as at the other keys");
    }
    let (gain, inverse) = (short(k.force / k.position), short(k.position / k.force));
    format!(
        "an energy amplifier, not a lever: positions × {g}, forces × {h}; a joule of the model is {gain} times as large \
         as at the other keys, so energy put in here comes out there × {inverse}"
    )
}

/// Stiffness in the hand of the springs on a key \[N/m\].
fn felt_as(scene: &Scene, key: &Key) -> f64 {
    key.k * scene.hand.equivalence.of(&key.name).stiffness()
}

/// Formats a stiffness with three digits.
pub fn quantity(k: f64) -> String {
    show(short(k).parse().unwrap_or(k), Unit::STIFFNESS)
}

/// Returns for each device key its name, the energy received by the scene and given by the hand, in joules of the hand.
pub fn exchanged<'a>(scene: &'a Scene, ledger: &Ledger) -> Vec<(&'a str, f64, f64)> {
    let name = |input: u32| scene.inputs.get(input as usize).map_or("?", |i| i.name.as_str());
    let joules = |input: u32| scene.inputs.get(input as usize).map_or(1.0, |i| i.gains.energy());
    let row = |p: &Enx, e: &Exchange| (name(p.input), e.received * joules(p.input), e.given * joules(p.input));
    scene.ports.tgr.iter().zip(&ledger.hands).map(|(p, e)| row(p, e)).collect()
}
