//! Prints the demands of a model on a device.

use crate::load::ticked;
use crate::outcome::Failure;
use ca_core::Unit;
use ca_lab::facts::border::quantity;
use ca_model::quantity::{short, show, six};
use ca_take::demands::{DeviceDemands, newton};
use serde_json::{Value as Json, json};
use std::io::Write;

pub(super) fn text(asked: &DeviceDemands, out: &mut impl Write) -> Result<(), Failure> {
    let p = asked.profile;
    writeln!(out, "\nOn {} (`{}`):", p.title, p.name)?;
    let metre = |v: f64| show(short(v).parse().unwrap_or(v), Unit::METRE);
    let own = p.stiffness.map_or("stiffness unknown".into(), |k| format!("stiffness {}", quantity(k)));
    writeln!(
        out,
        "  device     {} degrees of freedom, travel {}, force {}, {own}, friction {} N s/m",
        p.dof,
        metre(p.range[1] - p.range[0]),
        newton(p.force),
        short(p.body.friction)
    )?;
    writeln!(
        out,
        "  passive    up to {} with this friction if each force is applied a frame later; {} if it is applied at once",
        quantity(asked.held.passive),
        quantity(asked.held.at_once)
    )?;
    let (wants, has) = (show(six(asked.rate), Unit::HERTZ), show(six(p.rate), Unit::HERTZ));
    if asked.slow() {
        writeln!(
            out,
            "  rates      the model needs {wants}, the device has {has}: a frame without a new position repeats the last one"
        )?;
    } else {
        writeln!(out, "  rates      the model needs {wants}, the device has {has}")?;
    }
    if asked.devices.is_empty() {
        writeln!(out, "  keys       none: the model has no TGR with a `device`")?;
        return Ok(());
    }
    let missing = asked.missing();
    if !missing.is_empty() {
        let names = ticked(missing.iter().map(|r| r.name));
        writeln!(
            out,
            "  keys       {names} need a degree of freedom beyond the {} of the device: they stay at rest",
            p.dof
        )?;
    }
    for r in asked.rows.iter().filter(|r| asked.outside(r)) {
        writeln!(
            out,
            "  travel     `{}` needs {} to {}, the device has {} to {}",
            r.name,
            metre(r.required_range[0]),
            metre(r.required_range[1]),
            metre(p.range[0]),
            metre(p.range[1])
        )?;
    }
    if asked.rows.iter().any(|r| asked.outside(r)) {
        writeln!(
            out,
            "             scale the model (`ca equiv MODEL --set position=REAL:SIM`), or use a device with more travel"
        )?;
    }
    if !asked.feedback {
        writeln!(out, "  forces     none reach the hand: `feedback` is false")?;
        return Ok(());
    }
    writeln!(
        out,
        "\n  {:<12} {:>4} {:>11} {:>11} {:>11} {:>11}  result",
        "key", "dof", "stiffness", "of device", "passive", "force"
    )?;
    for r in &asked.rows {
        let limit = p.stiffness.map_or("?".into(), |k| format!("{} %", short(100.0 * r.k() / k)));
        let passive = format!("{} %", short(100.0 * r.k() / asked.held.passive));
        writeln!(
            out,
            "  {:<12} {:>4} {:>11} {limit:>11} {passive:>11} {:>11}  {}",
            r.name,
            r.dof,
            quantity(r.k()),
            newton(r.force),
            asked.verdict(r)
        )?;
        if asked.beyond(r).contains(&true) {
            let steeper = r.presented.steepest > r.presented.certified * (1.0 + 1e-6);
            let all: Vec<String> = r.links.iter().take(4).map(|(n, k)| format!("`{n}` {}", quantity(*k))).collect();
            let more = steeper.then(|| "it stiffens within the travel".to_owned());
            let said: Vec<String> = Some(all.join(", ")).filter(|s| !s.is_empty()).into_iter().chain(more).collect();
            writeln!(out, "  {:<17} {}", "", said.join("; "))?;
        }
        if let Some(x) = r.saturates {
            writeln!(
                out,
                "  {:<17} the force reaches {} at {} from rest and is limited to it",
                "",
                newton(p.force),
                metre(x)
            )?;
        }
    }
    if asked.rows.iter().any(|r| r.stiffness.is_some() || asked.beyond(r).contains(&true)) {
        writeln!(
            out,
            "\n  A softened key acts on the hand through a virtual coupling; the model and its sound do not change. A key above \
             0.9 of the\n  passive stiffness is softened to half of it, because a profile may be wrong. To soften a key less, lower \
             the stiffness of\n  its links, make the model lighter in the hand (`ca equiv MODEL --set stiffness=REAL:SIM`), or raise \
             `rate.gesture`, which\n  raises the passive stiffness. A key beyond a limit that is not softened can vibrate in the hand."
        )?;
    }
    Ok(())
}

pub(super) fn json(asked: &DeviceDemands) -> Json {
    let p = asked.profile;
    let keys: Vec<Json> = asked
        .rows
        .iter()
        .map(|r| {
            let [stiff, active] = asked.beyond(r);
            let links: Vec<Json> = r.links.iter().map(|(n, k)| json!({"name": n, "k": k})).collect();
            json!({
                "name": r.name, "dof": r.dof, "there": r.has_dof, "k": r.k(), "certified": r.presented.certified,
                "steepest": r.presented.steepest, "viscosity": r.presented.viscosity, "sticks": r.presented.sticks,
                "felt": r.stiffness, "too_stiff": r.too_stiff, "force": r.force, "saturates": r.saturates, "links": links,
                "alpha": r.gains.alpha, "beta": r.gains.beta,
                "beyond_stiffness": stiff, "beyond_passive": active,
                "asks": r.required_range, "beyond_travel": asked.outside(r),
            })
        })
        .collect();
    json!({
        "profile": p.name, "dof": p.dof, "range": p.range, "force": p.force, "stiffness": p.stiffness,
        "friction": p.body.friction, "rate": p.rate, "gesture_rate": asked.rate, "slow": asked.slow(),
        "passive": asked.held.passive, "passive_at_once": asked.held.at_once, "devices": asked.devices, "keys": keys,
        "too_much": asked.too_much(),
    })
}
