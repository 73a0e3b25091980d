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
    let own = p.stiffness.map_or("stiffness not known".into(), |k| format!("stiffness {}", quantity(k)));
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
        "  passive    up to {} with that friction, each force a frame later; {} were it taken at once",
        quantity(asked.held.passive),
        quantity(asked.held.at_once)
    )?;
    let (wants, has) = (show(six(asked.rate), Unit::HERTZ), show(six(p.rate), Unit::HERTZ));
    if asked.slow() {
        writeln!(
            out,
            "  rates      the model wants {wants} and the device gives {has}: a frame without a new position repeats the last"
        )?;
    } else {
        writeln!(out, "  rates      {wants} wanted, {has} given")?;
    }
    if asked.devices.is_empty() {
        writeln!(out, "  keys       none: the model has no TGR with a `device`")?;
        return Ok(());
    }
    let missing = asked.missing();
    if !missing.is_empty() {
        let names = ticked(missing.iter().map(|r| r.name));
        writeln!(out, "  keys       {names} want degrees of freedom beyond the {} it has: they stay at rest", p.dof)?;
    }
    for r in asked.rows.iter().filter(|r| asked.outside(r)) {
        writeln!(
            out,
            "  travel     `{}` is to go from {} to {}, the device goes from {} to {}",
            r.name,
            metre(r.asks[0]),
            metre(r.asks[1]),
            metre(p.range[0]),
            metre(p.range[1])
        )?;
    }
    if asked.rows.iter().any(|r| asked.outside(r)) {
        writeln!(
            out,
            "             scale it for the hand (`ca equiv --set position=…`), or take a device with more travel"
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
            writeln!(out, "  {:<17} the force passes {} {} from rest and stays there", "", newton(p.force), metre(x))?;
        }
    }
    if asked.rows.iter().any(|r| r.felt.is_some() || asked.beyond(r).contains(&true)) {
        writeln!(
            out,
            "\n  A softened key is felt through a virtual coupling: the model and its sound stay as they are. A key above 0.9 of \
             the passive\n  stiffness is softened to half of it, for a profile may be wrong. To feel more of it, lower the stiffness of \
             its links, make the\n  model lighter in the hand (`ca equiv --set stiffness=…`), or raise `rate.gesture`: passive \
             stiffness grows with it. A key\n  beyond a limit that is not softened can shake in the hand."
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
                "name": r.name, "dof": r.dof, "there": r.there, "k": r.k(), "certified": r.presented.certified,
                "steepest": r.presented.steepest, "viscosity": r.presented.viscosity, "sticks": r.presented.sticks,
                "felt": r.felt, "too_stiff": r.too_stiff, "force": r.force, "saturates": r.saturates, "links": links,
                "alpha": r.gains.alpha, "beta": r.gains.beta,
                "beyond_stiffness": stiff, "beyond_passive": active,
                "asks": r.asks, "beyond_travel": asked.outside(r),
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
