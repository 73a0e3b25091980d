//! Refuses models that lose too much in single precision, before they sound as noise, drift or silence.
//!
//! The limits were measured against double precision (tests/suite/compiler/single.rs). Strings, meshes, cells, modes,
//! friction and contacts by any method are accurate to 1e-3 or better over a second. Four things are not:
//! - a **distance in space** is accurate to 1e-7 of the positions of its ends, which is as much as the deformation by
//!   which a body sounds;
//! - an **implicit** link with a multiple of the inertia of its ends multiplies rounding by as much;
//! - **friction that sticks exactly** to something moved from outside: a step of the position is accurate to 1e-7 of
//!   the position, and m/T² times this error is more than friction can hold;
//! - a **number** of a module may be too large or too small, or so near to 1 that a long decay is lost.

use crate::net::{End, MatRole, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::vec::Vec;
use ca_core::Real;
use ca_core::internal::live::{Loader, Source};
use ca_core::internal::method::implicit::inertia;
use ca_core::internal::numeric::NONE;
use ca_core::internal::phi::bow::SET_VALUED;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Largest ratio of the inertia of an implicit link to the inertia of its ends.
const STIFFEST: f64 = 100.0;
/// Largest relative error of the decay of a mass.
const FADES: f64 = 0.01;

/// Returns whether a number underflows or overflows.
fn is_lost(v: f64, least: f32) -> bool {
    let kept = v as f32;
    v != 0.0 && v != NONE && !(kept.abs() >= least && kept.is_finite())
}

/// Reports each item at most once.
pub fn check(model: &Model, net: &Pruned, diags: &mut Diags) {
    let mut reported = BTreeSet::new();
    let mut tell = |id: u32, d: Diag, label: &str, help: &str| {
        if reported.insert(id) {
            let item = &model.items[net.items[id as usize].model];
            diags.push(d.at(item.name_span, label).help(help));
        }
    };
    let load = |loader: Loader, id: u32, values: &[Source]| {
        let mut out = Vec::new();
        loader.load(&net.values(id, values), net.tick_dt, &mut out);
        out
    };
    let beyond = |name: &dyn core::fmt::Display| {
        Diag::error("E009", format!("a coefficient of `{name}` is out of range for single precision"))
    };
    let (label, help) = ("outside 1e-38 to 3e38, per tick", "use values closer to 1, or double precision");
    let mut mobility: Vec<f64> = alloc::vec![0.0; net.mats.len()];
    for (i, m) in net.mats.iter().enumerate().filter(|(i, _)| net.alive[*i]) {
        if m.dx0.iter().chain(&m.v.map(|v| v * net.tick_dt)).any(|v| is_lost(*v, f32::TINY)) {
            tell(m.item, beyond(&m.name), "outside 1e-30 m to 3e38 m", help);
        }
        let MatRole::Mat(spec) = m.role else { continue };
        let friction = if spec.fixed { 0.0 } else { net.medium(m).friction };
        let c = load(Loader::Mat(spec, friction), m.item, &m.values);
        mobility[i] = c[2];
        if c.iter().any(|v| is_lost(*v, f32::MIN_POSITIVE)) {
            tell(m.item, beyond(&m.name), label, help);
        }
        let (asked, kept) = (1.0 - c[0], 1.0 - f64::from(c[0] as f32));
        if (kept - asked).abs() > FADES * asked.abs() {
            let d = Diag::warning("W114", format!("`{}` decays too slowly for single precision", m.name));
            tell(m.item, d, "its decay is off by more than 1 %", "use a lower rate, no damper, or double precision");
        }
    }
    for l in &net.lias {
        let c = load(Loader::Lia(l.law), l.item, &l.values);
        if c.iter().any(|v| is_lost(*v, f32::MIN_POSITIVE)) {
            tell(l.item, beyond(&l.name), label, help);
        } else if l.is_radial() {
            let d = Diag::error(
                "E028",
                format!("`{}` measures a distance in space, which single precision does not support", l.name),
            );
            tell(
                l.item,
                d,
                "rounding would be as large as the sound",
                "use double precision, or a direction with `along`",
            );
        }
        let moved = |e: &End| matches!(e, End::Mat(m) if matches!(net.mats[*m as usize].role, MatRole::Port(..)));
        if core::ptr::eq(l.law, &raw const SET_VALUED) && l.ends.iter().any(moved) {
            let d = Diag::error("E028", format!("`{}` cannot stick to a moving port in single precision", l.name));
            tell(l.item, d, "rounding of the motion tears it off", "use `method = \"newton\"`, or double precision");
        }
        let ends = l.ends.iter().map(|e| if let End::Mat(m) = e { mobility[*m as usize] } else { 0.0 });
        if l.law.implicit && inertia(&[c[0], c[1], c[2]]) * ends.sum::<f64>() > STIFFEST {
            let d = Diag::error("E028", format!("`{}` is too stiff for single precision", l.name));
            tell(
                l.item,
                d,
                "implicit, with over 100 times the inertia of its ends",
                "use less stiffness, or double precision",
            );
        }
    }
    for o in &net.outs {
        let Some(id) = o.item else { continue };
        if is_lost(load(Loader::Times(o.share), id, &[o.gain])[0], f32::MIN_POSITIVE) {
            tell(id, beyond(&o.name), label, help);
        }
    }
}
