//! `ca check`: reports everything known about a model before it plays.
//!
//! Findings go to stderr, as in every command. The summary is the requested result and goes to stdout.

mod args;
mod device;
mod levels;
mod schedule;
mod waveguides;

pub use args::CheckArgs;

use crate::commands::border;
use crate::commands::render::stability_json;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_core::{Level, Scene};
use ca_lab::facts::border::{crossing, rates};
use ca_lab::facts::certificate::{contacting, deepening, opened, rippling, stability};
use ca_lab::facts::{codes, inputs};
use ca_lab::watch::{LOOK, Watch};
use ca_model::quantity::Plain;
use ca_model::{quantity, render};
use ca_take::demands::DeviceDemands;
use serde_json::{Value as Json, json};
use std::io::Write as _;

/// Runs the command.
pub fn run(args: &CheckArgs) -> Outcome {
    if !args.watch {
        return once(args, &mut Vec::new());
    }
    let model = &args.source.model;
    let mut watch = Watch::of(model).ok_or_else(|| {
        Failure::Usage(format!(
            "--watch: `{model}` is a bundled model or standard input, which cannot change; give a model file"
        ))
    })?;
    loop {
        let mut files = Vec::new();
        let checked = once(args, &mut files);
        watch.also(&files);
        match checked {
            Err(Failure::Usage(text) | Failure::Failed(text)) => term::error(&text),
            Err(Failure::Reported) | Ok(_) => {}
            Err(other) => return Err(other),
        }
        term::note(&format!("waiting until `{model}` is saved; press Ctrl-C to stop"));
        while !watch.is_new() {
            std::thread::sleep(LOOK);
        }
        writeln!(std::io::stdout().lock())?;
    }
}

fn once(args: &CheckArgs, files: &mut Vec<String>) -> Outcome {
    let profile = args.device.as_deref().map(ca_device_tools::store::profile).transpose()?;
    let loaded = load::load(&args.source)?;
    *files = ca_lab::load::part_files(&loaded.model);
    let options = Options { rate: args.source.rate, exact: args.exact, ..Options::default() };
    let (scene, diags) = load::compiled(&loaded, &options);
    let rows = scene.as_ref().filter(|_| args.schedule).map(ca_accuracy::schedule::measure).transpose()?;
    let quiet = args.json || args.watch;
    let levels = scene.as_ref().filter(|_| args.levels).map(|s| levels::levels(s, !quiet)).transpose()?;
    let asked = scene.as_ref().zip(profile.as_ref()).map(|(s, p)| DeviceDemands::new(s, p));
    if args.json {
        let all = json!({
            "diagnostics": render::json(&diags, &loaded.model),
            "summary": scene.as_ref().map(|s| summary_json(&loaded, s)),
            "schedule": scene.as_ref().zip(rows.as_ref()).map(|(s, r)| schedule::json(s, r)),
            "levels": levels.as_deref().map(levels::json),
            "device": asked.as_ref().map(device::json),
        });
        writeln!(std::io::stdout().lock(), "{all:#}")?;
    } else {
        term::findings(&diags, &loaded.model);
        if let Some(scene) = &scene {
            border::idle(&args.source, scene);
            summary(&loaded, scene, args.exact)?;
        }
        if let Some((scene, rows)) = scene.as_ref().zip(rows.as_ref()) {
            schedule::text(scene, rows)?;
        }
        if let Some(levels) = &levels {
            levels::text(levels)?;
        }
        if let Some(asked) = &asked {
            device::text(asked, &mut std::io::stdout().lock())?;
        }
    }
    match scene {
        None => Err(Failure::Reported),
        Some(s) if s.certificate.level == Level::Unstable => Ok(Ended::Degraded),
        Some(_) if asked.is_some_and(|a| a.too_much()) => Ok(Ended::Degraded),
        Some(_) => Ok(Ended::Well),
    }
}

fn ops(scene: &Scene) -> usize {
    scene.passes.reads.len() + scene.passes.summed().len() + scene.passes.writes.len() + scene.passes.moves.len()
}

fn summary(loaded: &Loaded, scene: &Scene, exact: bool) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let title = if scene.about.title.is_empty() { &loaded.name } else { &scene.about.title };
    writeln!(out, "{title}")?;
    let by_code: Vec<String> = codes(scene).iter().map(|(c, n)| format!("{n} {c}")).collect();
    writeln!(out, "  modules    {} MAT, {} LIA: {}", scene.mats(), scene.lias(), by_code.join(", "))?;
    for (op, name) in
        scene.passes.forces.iter().enumerate().map(|(i, op)| (op, ca_core::internal::scene::lia_name(scene, i, 0)))
    {
        if let Some(set) = op.ports.pair_set {
            writeln!(out, "             `{name}` links all {} pairs", scene.links.pair_sets[set].pairs())?;
        }
    }
    writeln!(out, "  passes     {} per tick", ops(scene))?;
    let heard = if scene.names.channel_names.is_empty() { "none".into() } else { scene.names.channel_names.join(", ") };
    writeln!(out, "  outputs    {heard}")?;
    if !scene.inputs.is_empty() {
        for (n, line) in inputs::lines(scene).iter().enumerate() {
            writeln!(out, "  {:<10} {line}", if n == 0 { "inputs" } else { "" })?;
        }
    }
    if !scene.live.params.is_empty() {
        let names: Vec<&str> = scene.live.params.iter().map(|p| p.name.as_str()).collect();
        writeln!(out, "  live       {}", names.join(", "))?;
    }
    for d in &scene.live.driven {
        let p = &d.param;
        let [min, max] = [p.min, p.max].map(|v| quantity::show(v, p.unit));
        writeln!(out, "  driven     {} from {min} to {max} by {}", p.name, d.port)?;
    }
    writeln!(out, "  rates      {}, {} ticks per frame", rates(scene), scene.rates.frame)?;
    if let Some(group) = &scene.rates.slow {
        let how = if group.compensated {
            ", compensated: values not yet known in a frame are predicted from the frames before; stability is not proven"
        } else {
            ", exact"
        };
        writeln!(
            out,
            "  group      {} masses and {} links once per frame; links to the rest act on {} axes{how}",
            group.masses, group.links, group.coupled
        )?;
    }
    if let Some(how) = crossing(scene) {
        writeln!(out, "  border     {how}")?;
    }
    border::text(&mut out, scene)?;
    border::keys(&mut out, scene)?;
    let c = &scene.certificate;
    writeln!(out, "  stability  {}", stability(c))?;
    let decided = match (c.exact, c.level) {
        (false, _) => None,
        (true, Level::Linearised) => Some("decided by a factorisation at the initial positions"),
        (true, _) => Some("decided by a factorisation"),
    };
    if let Some(decided) = decided {
        writeln!(out, "             {decided}")?;
    }
    match c.largest {
        Some((_, to)) if to < 1e-200 => writeln!(out, "             largest eigenvalue 0: the model has no stiffness")?,
        Some((_, to)) => writeln!(
            out,
            "             largest eigenvalue {:.9}: all links could be {:.6} times stiffer",
            Plain(to),
            Plain(4.0 / to)
        )?,
        None if exact => {
            writeln!(
                out,
                "             largest eigenvalue unknown: nothing moves, or it depends on moving points or contacts"
            )?;
        }
        None => {}
    }
    if let Some(ripple) = c.ripple {
        writeln!(out, "             {}", rippling(ripple))?;
    }
    if let Some(contact) = contacting(c) {
        writeln!(out, "  contacts   {contact}")?;
    }
    if let Some(depth) = &c.rules.depth {
        writeln!(out, "  {:<10} {}", if c.rules.contact > 0.0 { "" } else { "contacts" }, deepening(depth))?;
    }
    if let Some(open) = opened(c) {
        writeln!(out, "  not judged {open}")?;
    }
    Ok(())
}

fn summary_json(loaded: &Loaded, scene: &Scene) -> Json {
    let codes: serde_json::Map<String, Json> = codes(scene).iter().map(|(c, n)| ((*c).to_owned(), json!(n))).collect();
    let inputs: Vec<&str> = scene.inputs.iter().map(|i| i.name.as_str()).collect();
    let live: Vec<&str> = scene.live.params.iter().map(|p| p.name.as_str()).collect();
    let driven: Vec<Json> = scene.live.driven.iter().map(|d| json!({"name": d.param.name, "port": d.port})).collect();
    json!({
        "name": loaded.name, "title": scene.about.title, "n_mat": scene.mats(), "n_lia": scene.lias(), "modules": codes,
        "passes": ops(scene), "rate": scene.rate, "gesture_rate": scene.rate / f64::from(scene.rates.ratio),
        "ratio": scene.rates.ratio, "oversample": scene.oversample(), "latency": border::json(scene),
        "outputs": scene.names.channel_names, "inputs": inputs,
        "slow": scene.rates.slow.as_ref().map(|g| json!({
            "masses": g.masses, "links": g.links, "coupled": g.coupled, "compensated": g.compensated,
        })),
        "live": live, "driven": driven, "seconds": scene.about.seconds, "stability": stability_json(&scene.certificate),
    })
}
