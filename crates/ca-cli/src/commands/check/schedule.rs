//! Prints the passes of one tick with the cost of each.

use super::waveguides;
use crate::outcome::Failure;
use ca_accuracy::schedule::{Schedule, absent, form, pairs};
use ca_core::Scene;
use ca_model::quantity::short;
use serde_json::{Value as Json, json};
use std::io::Write as _;

pub(super) fn text(scene: &Scene, m: &Schedule) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "\nOne tick, measured on this machine:")?;
    let forms: Vec<String> = m.rows.iter().map(|r| form(&r.op)).collect();
    let wide = forms.iter().map(String::len).fold(20, usize::max);
    writeln!(
        out,
        "  {:<7} {:<15} {:>8}  {:<wide$} {:>10} {:>10} {:>10}",
        "", "pass", "modules", "form", "ns/tick", "predicted", "ns/module"
    )?;
    let mut last = "";
    for (r, form) in m.rows.iter().zip(forms) {
        let stage = if r.stage == last { "" } else { r.stage };
        last = r.stage;
        let (n, name) = (r.modules, r.op.name());
        let each = r.ns / n.max(1) as f64;
        let predicted = r.instructions.map_or("-".into(), |n| format!("{:.1}", n * m.ns_per_instruction));
        let name = pairs(scene, &r.op).map_or(name.to_string(), |p| format!("{name} ({p} pairs)"));
        writeln!(out, "  {stage:<7} {name:<15} {n:>8}  {form:<wide$} {:>10.1} {predicted:>10} {each:>10.2}", r.ns)?;
    }
    let budget = 1e9 * scene.rates.sample_dt;
    writeln!(
        out,
        "  whole tick {:.1} ns of {budget:.0} ns: {} times real time on one core",
        m.tick,
        short(budget / m.tick.max(1e-3))
    )?;
    let without = if m.rows.iter().all(|r| r.instructions.is_some()) { "" } else { " without the passes marked -" };
    writeln!(
        out,
        "  predicted {:.1} ns{without}: {:.0} instructions of AVX2\n  from a table of costs, {:.4} ns each, measured here on \
         links that are looked up one by one; time spent waiting for memory, in large scenes, is not included",
        m.instructions * m.ns_per_instruction,
        m.instructions,
        m.ns_per_instruction
    )?;
    if let Some((group, step)) = scene.rates.slow.as_ref().zip(m.step) {
        writeln!(
            out,
            "  the group: {} masses and {} links take {step:.1} ns once in {} ticks; \
             at the sound rate, they would take it each tick",
            group.masses, group.links, scene.rates.frame
        )?;
    }
    waveguides::text(scene, &mut out)?;
    writeln!(out, "\nLeft out:")?;
    for what in &scene.about.left_out {
        writeln!(out, "  {what}")?;
    }
    writeln!(out, "  {}", absent(scene).join(", "))?;
    Ok(())
}

pub(super) fn json(scene: &Scene, m: &Schedule) -> Json {
    let rows: Vec<Json> = m
        .rows
        .iter()
        .map(|r| {
            let of_links = r.op.law.is_some();
            let n = r.modules;
            json!({
                "stage": r.stage, "pass": r.op.name(), "modules": n, "stride": of_links.then_some(r.op.form.stride),
                "offset": of_links.then_some(r.op.form.offset), "tap": of_links.then_some(r.op.form.tap),
                "pairs": pairs(scene, &r.op), "ns_per_tick": r.ns, "ns_per_module": r.ns / n.max(1) as f64,
                "instructions_predicted": r.instructions,
                "ns_predicted": r.instructions.map(|i| i * m.ns_per_instruction),
            })
        })
        .collect();
    json!({
        "passes": rows, "ns_per_tick": m.tick, "budget_ns": 1e9 * scene.rates.sample_dt, "measured": "here",
        "instructions_predicted": m.instructions, "ns_predicted": m.instructions * m.ns_per_instruction,
        "ns_per_instruction": m.ns_per_instruction,
        "ns_of_group_per_frame": m.step, "waveguide_filters": waveguides::json(scene), "left_out": scene.about.left_out, "absent": absent(scene),
    })
}
