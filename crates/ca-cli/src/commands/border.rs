//! What a hand may expect of a scene: how late force and sound answer, and what its keys ask of a device.
//!
//! Decides to say it in the same words wherever it is said, and only of what the model settles: the loop of a device
//! and the buffers of a sound card come on top.

use crate::args::Source;
use crate::outcome::Failure;
use crate::term;
use crate::term::short;
use ca_core::equivalence::Scale;
use ca_core::internal::border::{Delays, delays};
use ca_core::internal::op::layout::{Enx, Shape};
use ca_core::internal::scene::certificate::Key;
use ca_core::internal::state::Exchange;
use ca_core::{Ledger, Scene, Unit};
use ca_model::quantity::{show, six};
use serde_json::{Value as Json, json};
use std::io::Write;

/// Keys that are reported one by one.
const KEYS: usize = 5;

fn ms(seconds: f64) -> String {
    format!("{} ms", short(seconds * 1e3))
}

/// One line on delays; nothing for a scene that has none.
pub(crate) fn latency(scene: &Scene) -> Option<String> {
    let d = delays(scene);
    let filter = (d.filter > 0.0).then(|| format!("{} of it the filter of the outputs", ms(d.filter)));
    if scene.ports.tgr.is_empty() {
        return filter.is_some().then(|| format!("sound {} late by the filter of the outputs", ms(d.filter)));
    }
    let force = if scene.ports.crossing.feedback { ms(d.force) } else { "never".into() };
    let mut notes: Vec<String> = Vec::new();
    if scene.ports.crossing.latency > 0 {
        let s = if scene.ports.crossing.latency == 1 { "" } else { "s" };
        notes.push(format!("{} frame{s} of it `latency`", scene.ports.crossing.latency));
    }
    notes.extend(filter);
    let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join(", ")) };
    Some(format!("gesture to force {force}, gesture to sound {}{notes}", ms(d.sound)))
}

/// Lines on the delays of a scene.
pub(crate) fn text(out: &mut impl Write, scene: &Scene) -> Result<(), Failure> {
    if let Some(line) = latency(scene) {
        writeln!(out, "  latency    {line}")?;
    }
    Ok(())
}

/// The two rates of a scene, and how many ticks a sample has where it has several.
pub(crate) fn rates(scene: &Scene) -> String {
    let hertz = |f: f64| show(six(f), Unit::HERTZ);
    let (sound, gesture) = (hertz(scene.rate), hertz(scene.rate / f64::from(scene.rates.ratio)));
    format!("sound {sound}{}, gesture {gesture}", ticks(scene.oversample()))
}

/// What is said behind a sound rate of a sample of so many ticks.
pub(crate) fn ticks(times: u32) -> String {
    if times > 1 { format!(" in {times} ticks a sample") } else { String::new() }
}

/// How the border works, for a scene that has one.
pub(crate) fn crossing(out: &mut impl Write, scene: &Scene) -> Result<(), Failure> {
    if scene.ports.tgr.is_empty() {
        return Ok(());
    }
    let how = match (scene.rates.frame, scene.ports.crossing.shape) {
        (1, _) => "one tick a frame, the force of the tick",
        (_, Shape::Linear) => "positions in a line through the frame, force its mean",
        (_, Shape::Hold) => "positions held over the frame, force the mean around their jump",
    };
    writeln!(out, "  border     {how}")?;
    Ok(())
}

/// Keys whose force reaches the hand, stiffest first.
fn rendered_keys(scene: &Scene) -> Vec<&Key> {
    let mut keys: Vec<&Key> =
        scene.certificate.keys.iter().filter(|k| scene.ports.crossing.feedback && k.k > 0.0).collect();
    keys.sort_by(|a, b| felt_as(scene, b).total_cmp(&felt_as(scene, a)));
    keys
}

/// What the keys ask of a device, stiffest first: name, stiffness in the hand \[N/m\], friction it needs \[N s/m\].
pub(crate) fn asked(scene: &Scene) -> Vec<(&str, f64, f64)> {
    let (d, keys) = (delays(scene), rendered_keys(scene));
    keys.into_iter().map(|k| (k.name.as_str(), felt_as(scene, k), d.friction(felt_as(scene, k)))).collect()
}

/// The same in words.
pub(crate) fn keys(out: &mut impl Write, scene: &Scene) -> Result<(), Failure> {
    let (d, keys) = (delays(scene), asked(scene));
    let mut lead = "keys       ";
    for (name, k, b) in keys.iter().take(KEYS) {
        let (k, b) = (quantity(*k), short(*b));
        writeln!(out, "  {lead}`{name}`: springs sum to {k}; to stay passive a device needs {b} N s/m of its own")?;
        lead = "           ";
    }
    if keys.len() > KEYS {
        writeln!(out, "  {lead}and {} that are no stiffer", keys.len() - KEYS)?;
    }
    if !keys.is_empty() {
        let later = Delays { spring: d.spring + d.frame, ..d };
        let [most, less] = [d, later].map(|d| quantity(d.stiffest(1.0)));
        writeln!(out, "             1 N s/m bears {most}, or {less} where the device takes each force a frame later")?;
    }
    Ok(())
}

/// How a key with a scale of its own differs from the others, for people.
pub(crate) fn scale_of(k: &Scale) -> String {
    let (g, h) = (short(k.position), short(k.force));
    if k.is_lever() {
        return format!("a lever of {g}: positions and forces × {g}, energy as everywhere");
    }
    let (gain, inverse) = (short(k.force / k.position), short(k.position / k.force));
    format!(
        "no lever but an amplifier of energy: positions × {g}, forces × {h}; a joule of the model is {gain} times what it \
         is at the other keys, so energy given here comes out there × {inverse}"
    )
}

/// What a spring of the model on this key is in the hand.
fn felt_as(scene: &Scene, key: &Key) -> f64 {
    key.k * scene.hand.equivalence.of(&key.name).stiffness()
}

/// Three digits of a stiffness.
pub(crate) fn quantity(k: f64) -> String {
    show(short(k).parse().unwrap_or(k), Unit::STIFFNESS)
}

/// All of it for programs.
pub(crate) fn json(scene: &Scene) -> Json {
    let d = delays(scene);
    let device = !scene.ports.tgr.is_empty();
    let keys: Vec<Json> =
        asked(scene).iter().map(|(name, k, b)| json!({"name": name, "k": k, "friction": b})).collect();
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

/// Name of each device key, what the scene received there and what the hand gave, in joules of the hand.
pub(crate) fn exchanged<'a>(scene: &'a Scene, ledger: &Ledger) -> Vec<(&'a str, f64, f64)> {
    let name = |input: u32| scene.inputs.get(input as usize).map_or("?", |i| i.name.as_str());
    let joules = |input: u32| scene.inputs.get(input as usize).map_or(1.0, |i| i.gains.energy());
    let row = |p: &Enx, e: &Exchange| (name(p.input), e.received * joules(p.input), e.given * joules(p.input));
    scene.ports.tgr.iter().zip(&ledger.hands).map(|(p, e)| row(p, e)).collect()
}

/// Says so where something was asked of a border that is not there.
pub(crate) fn idle(source: &Source, scene: &Scene) {
    if scene.ports.tgr.is_empty() && source.crossing().next().is_some() {
        term::note("the model has no device key (TGR): `--border`, `--latency` and `--no-feedback` change nothing");
    }
}
