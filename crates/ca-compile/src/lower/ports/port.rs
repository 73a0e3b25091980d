//! Makes the inputs of a port and, if it moves, its MAT.

use crate::findings::type_name;
use crate::lower::space;
use crate::lower::values::Values;
use crate::net::{MatNode, MatRole, NetItem, Resolved};
use alloc::format;
use alloc::string::ToString;
use ca_core::equivalence::Gains;
use ca_core::internal::kind::PortRole;
use ca_core::internal::kind::builder::Arg;
use ca_core::{Input, InputRole, Name, Unit};
use ca_model::diag::Diag;
use ca_model::{Item, Value};

/// Makes the inputs of a port; `connect` adds outputs later.
pub(in crate::lower) fn port(
    role: PortRole,
    item: &NetItem,
    source: &Item,
    id: u32,
    (dim, rest): (u8, [f64; 3]),
    net: &mut Resolved,
    v: &mut Values<'_>,
) {
    if matches!(role, PortRole::Sox | PortRole::Sof) {
        return;
    }
    let (input_role, unit) = match role {
        PortRole::Enf => (InputRole::Force, Unit::NEWTON),
        PortRole::Tgr => (InputRole::Device, Unit::METRE),
        _ => (InputRole::Position, Unit::METRE),
    };
    let entry = |key: &str| source.args.iter().find(|e| e.key == key);
    let midi = entry("midi").and_then(|e| v.midi(e, unit, &item.name));
    let device = entry("device").and_then(|e| match &e.value {
        Value::Text(t) => Some(t.clone()),
        other => {
            let title = format!("`device` of `{}` must be a text, not {}", item.name, type_name(other));
            let d = Diag::error("E006", title).at(e.span, "not a text");
            v.diags.push(d.help("write the name of the device, e.g. `\"tgr12\"`"));
            None
        }
    });
    // A force has one axis, along which it acts.
    let dim = if role == PortRole::Enf { 1 } else { dim };
    let dofs = match item.kind.param("dof").map(|i| &item.args[i]) {
        Some(Arg::List(l)) => l.clone(),
        Some(Arg::Num(v)) if dim == 1 || entry("dof").is_some() => alloc::vec![*v],
        _ => (0..dim).map(f64::from).collect(),
    };
    if dofs.len() > dim as usize || dofs.is_empty() {
        let span = entry("dof").map_or(source.name_span, |e| e.span);
        let title = format!("`dof` of `{}` has {} degrees of freedom for {dim} axes", item.name, dofs.len());
        let help = "give one number for each axis that moves, or put the port into a group with `dim = 3`";
        v.diags.push(Diag::error("E006", title).at(span, "does not fit").help(help));
        return;
    }
    if let (true, Some(e)) = (dofs.len() > 1, entry("midi")) {
        let d = Diag::error("E026", format!("`{}`: `midi` moves one axis, not {}", item.name, dofs.len()));
        v.diags.push(
            d.at(e.span, "in space").help("use `midi` for an ENX on a line, and link it to this port with `along`"),
        );
    }
    let mut inputs = [None; 3];
    for (k, dof) in dofs.iter().enumerate() {
        inputs[k] = Some(net.inputs.len() as u32);
        let name = if dim == 1 { item.name.to_string() } else { format!("{}.{}", item.name, space::AXES[k]) };
        let device = device.as_ref().map(|d| (d.clone(), *dof as u32));
        let rest = if role == PortRole::Enf { 0.0 } else { rest[k] };
        net.inputs.push(Input { name, role: input_role, rest, midi, device, gains: Gains::default() });
    }
    if role != PortRole::Enf {
        let node = MatNode {
            name: Name::from(&item.name),
            code: item.kind.code,
            role: MatRole::Port(role, inputs),
            values: [].into(),
            axes: dim,
            rest,
            dx0: [0.0; 3],
            v: [0.0; 3],
            group: item.group,
            item: id,
        };
        net.add(node);
    }
}
