//! Prune: drops modules that no output and no device depends on. Motion does not pass through a fixed point or a port,
//! so they do not connect the modules linked to them.

use crate::net::disjoint::Sets;
use crate::net::{End, MatRole, OutputTap, Pruned, Wired};
use crate::options::Options;
use alloc::format;
use alloc::vec::Vec;
use ca_core::Role;
use ca_core::internal::kind::PortRole;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Marks the MATs that stay and drops the links that do not.
pub fn prune(model: &Model, mut net: Wired, options: &Options, diags: &mut Diags) -> Pruned {
    let heard_at_all =
        !net.outs.is_empty() || net.mats.iter().any(|m| matches!(m.role, MatRole::Port(PortRole::Tgr, _)));
    if net.mats.is_empty() {
        let help = match model.parts.first() {
            Some(part) => {
                format!("it only defines parts: add `[use]` with `x = {{ part = \"{}\" }}`", part.name)
            }
            None => "add `[MAS]`, `[SOL]` and a link, or start from a model made by `ca new`".into(),
        };
        diags.push(Diag::error("E024", "the model has no modules").help(help));
        return whole(net);
    }
    if !heard_at_all {
        let d = Diag::warning("W108", "the model has no output, so it makes no sound");
        diags.push(d.help("add e.g. `[SOX]` with `out = { from = \"…\" }`"));
        return whole(net);
    }
    if options.whole {
        return whole(net);
    }
    let n = net.mats.len();
    let fixed: Vec<bool> = net.mats.iter().map(crate::net::MatNode::is_fixed).collect();
    let mut sets = Sets::new(n + net.points.len());
    // A moving point joins all moving nodes that it may touch.
    let place = |e: End| match e {
        End::Mat(m) => m as usize,
        End::Point(p) => n + p as usize,
    };
    for p in 0..net.points.len() {
        for m in net.under(End::Point(p as u32)) {
            if !fixed[m as usize] {
                sets.join(n + p, m as usize);
            }
        }
    }
    let moves = |e: End| match e {
        End::Mat(m) => !fixed[m as usize],
        End::Point(_) => true,
    };
    for l in &net.lias {
        let mut moving = l.all_ends().filter(|e| moves(*e)).map(place);
        if let Some(first) = moving.next() {
            moving.for_each(|e| sets.join(first, e));
        }
    }
    for l in &net.lines {
        l.junctions().for_each(|m| sets.join(l.first as usize, m as usize));
    }
    let mut heard = alloc::vec![false; n + net.points.len()];
    let mut hear = |sets: &mut Sets, e: End| heard[sets.root(place(e))] = true;
    let tgr = |e: End| matches!(e, End::Mat(m) if matches!(net.mats[m as usize].role, MatRole::Port(PortRole::Tgr, _)));
    for o in &net.outs {
        match o.tap {
            OutputTap::Position(e) | OutputTap::ForceOn(e) => hear(&mut sets, e),
            OutputTap::ForceOf(l) => net.lias[l as usize].all_ends().for_each(|e| hear(&mut sets, e)),
        }
    }
    let listened: Vec<End> =
        net.outs.iter().filter_map(|o| if let OutputTap::ForceOn(e) = o.tap { Some(e) } else { None }).collect();
    // Links at a device, or at a fixed point whose force is an output, are needed.
    for l in &net.lias {
        if l.all_ends().any(|e| tgr(e) || listened.contains(&e)) {
            l.all_ends().filter(|e| moves(*e)).for_each(|e| hear(&mut sets, e));
        }
    }
    let audible: Vec<bool> = (0..heard.len()).map(|i| heard[sets.root(i)]).collect();
    let mut alive: Vec<bool> = (0..n).map(|i| !fixed[i] && audible[i]).collect();
    let taps: Vec<u32> =
        net.outs.iter().filter_map(|o| if let OutputTap::ForceOf(l) = o.tap { Some(l) } else { None }).collect();
    let keep: Vec<bool> = net
        .lias
        .iter()
        .enumerate()
        .map(|(i, l)| {
            let moving = l.all_ends().any(moves);
            let is_read = || l.all_ends().any(|e| tgr(e) || listened.contains(&e)) || taps.contains(&(i as u32));
            if moving { l.all_ends().all(|e| !moves(e) || audible[place(e)]) } else { is_read() }
        })
        .collect();
    // Fixed points and ports stay if a link that stays refers to them.
    let hold = |alive: &mut Vec<bool>, e: End| net.under(e).iter().for_each(|m| alive[*m as usize] = true);
    for (l, k) in net.lias.iter().zip(&keep) {
        if *k {
            l.all_ends().for_each(|e| hold(&mut alive, e));
        }
    }
    for o in &net.outs {
        if let OutputTap::Position(e) | OutputTap::ForceOn(e) = o.tap {
            hold(&mut alive, e);
        }
    }
    for p in &net.points {
        for c in &p.at {
            if let crate::net::Coordinate::Port(m) = c {
                alive[*m as usize] = true;
            }
        }
    }
    for (i, m) in net.mats.iter().enumerate() {
        let MatRole::Port(role, inputs) = m.role else { continue };
        let drives = |input: Option<u32>| net.driven.iter().any(|d| Some(d.input) == input);
        alive[i] |= role == PortRole::Tgr || inputs.into_iter().any(drives);
    }
    report(model, &mut net, &alive, &keep, diags);
    let without_output = (0..n as u32).filter(|m| !alive[*m as usize] && !fixed[*m as usize]).collect();
    if keep.iter().any(|k| !k) {
        let lias = core::mem::take(&mut net.lias);
        net.drop_links(lias, &keep);
    }
    Pruned { wired: net, alive, without_output, from_lpr: Vec::new() }
}

fn whole(net: Wired) -> Pruned {
    Pruned { alive: alloc::vec![true; net.mats.len()], wired: net, ..Pruned::default() }
}

/// Reports items without any remaining module.
fn report(model: &Model, net: &mut Wired, alive: &[bool], keep: &[bool], diags: &mut Diags) {
    let mut all = alloc::vec![(0usize, 0usize); net.items.len()];
    let modules = net.mats.iter().map(|m| m.item).zip(alive).chain(net.lias.iter().map(|l| l.item).zip(keep));
    for (item, stays) in modules {
        let a = &mut all[item as usize];
        a.0 += 1;
        a.1 += usize::from(*stays);
    }
    let lost = |f: &dyn Fn(usize) -> bool| (0..all.len()).filter(|i| f(*i)).map(|i| all[i].0 - all[i].1).sum::<usize>();
    let n = lost(&|_| true);
    if n > 0 {
        net.left_out.push(format!("{n} modules that no output depends on"));
    }
    // A fixed point without links is not reported if W106 reported its link.
    let zero = diags.list.iter().any(|d| d.code == "W106");
    let fixed = |i: usize| matches!(net.items[i].kind.role, Role::Mat(s) if s.fixed);
    let gone = |i: &usize| all[*i].0 > 0 && all[*i].1 == 0 && !(zero && fixed(*i));
    let silent: Vec<usize> = (0..all.len()).filter(gone).collect();
    if let Some(first) = silent.first() {
        let mut d = Diag::warning(
            "W101",
            if silent.len() == 1 {
                format!("no output depends on `{}`", net.items[*first].name)
            } else {
                format!("no output depends on `{}` and {} more", net.items[*first].name, silent.len() - 1)
            },
        );
        for i in silent.iter().take(6) {
            d = d.at(model.items[net.items[*i].model].name_span, "left out");
        }
        diags.push(d.help("connect it to a module that an output reads, or remove it"));
    }
}
