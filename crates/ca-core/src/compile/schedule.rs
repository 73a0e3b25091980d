//! Schedule: flat arrays and the list of passes. What a scene does not have makes no entry here.

use super::certify::Certificate;
use super::links::{Links, own_tables};
use super::net::{Coordinate, Ear, End, MatRole, Net};
use super::options::Options;
use super::passes;
use super::plan::Plan;
use super::start::start;
use crate::kind::PortRole;
use crate::layout::{Account, Enf, Enx, Heard, Layout, LedgerPlan, Output, Place, Proxy};
use crate::ledger::Ledger;
use crate::live::Loader;
use crate::model::Model;
use crate::model::diag::Diags;
use crate::op::Op;
use crate::scene::{InputRole, Scene, Stands, Symbol};
use crate::state::{Border, Cell, Ramps, State};
use alloc::collections::BTreeMap;
use alloc::string::ToString;
use alloc::vec::Vec;

/// Builds the scene. `None` where the findings hold an error.
pub fn schedule(
    model: &Model,
    net: &Net,
    order: &[u32],
    options: &Options,
    certificate: Certificate,
    diags: &mut Diags,
) -> Option<Scene> {
    let used = used_points(net);
    let mut place = alloc::vec![u32::MAX; net.mats.len()];
    for (i, m) in order.iter().enumerate() {
        place[*m as usize] = i as u32;
    }
    let mut point = alloc::vec![u32::MAX; net.points.len()];
    let mut n_mat = order.len() as u32;
    for (p, u) in point.iter_mut().zip(&used) {
        if *u {
            *p = n_mat;
            n_mat += 1;
        }
    }
    let n_mat = n_mat as usize;
    let mut plan =
        Plan { net, place, point, coef: alloc::vec![0.0; 3 * n_mat], live: Vec::new(), modules: BTreeMap::new() };
    let mut x = alloc::vec![0.0; n_mat];
    let mut v = alloc::vec![0.0; n_mat];
    let mut rest = alloc::vec![0.0; n_mat];
    let mut symbols = Vec::with_capacity(net.mats.len() + net.lias.len());
    for (i, m) in net.mats.iter().enumerate() {
        let at = plan.place[i] as usize;
        if at == u32::MAX as usize {
            continue;
        }
        (x[at], v[at], rest[at]) = (m.dx0, m.v, m.rest);
        symbols.push(Symbol { name: m.name.clone(), code: m.code, place: Stands::Mat(at as u32) });
        if let MatRole::Mat(spec) = m.role {
            let loader = Loader::Mat(spec, if spec.fixed { 0.0 } else { net.medium(m).friction });
            plan.load(loader, m.item, &m.values, &[at, n_mat + at, 2 * n_mat + at]);
        }
    }
    for (p, at) in plan.point.iter().enumerate() {
        if *at != u32::MAX {
            rest[*at as usize] = net.rest(End::Point(p as u32));
        }
    }

    let ports = |role: PortRole| -> Vec<Enx> {
        let all = net.mats.iter().zip(&plan.place).filter(|(_, at)| **at != u32::MAX);
        all.filter_map(|(m, at)| match m.role {
            MatRole::Port(r, input) if r == role => Some(Enx { input, mat: *at, rest: m.rest }),
            _ => None,
        })
        .collect()
    };
    let (enx, tgr) = (ports(PortRole::Enx), ports(PortRole::Tgr));
    let enf: Vec<Enf> =
        net.pushes.iter().filter_map(|(input, end)| Some(Enf { input: *input, mat: plan.alive(*end)? })).collect();

    // weight
    let mut weighed = Vec::new();
    let weight = plan.coef.len();
    for (i, m) in net.mats.iter().enumerate() {
        let g = net.medium(m).gravity;
        if g != 0.0 && !m.is_fixed() && plan.place[i] != u32::MAX {
            weighed.push(plan.place[i]);
            plan.coef.push(0.0);
            let to = plan.coef.len() - 1;
            plan.load(Loader::Weight(g), m.item, &m.values, &[to]);
        }
    }

    let links = plan.links(options, diags, model);
    let Links { forces, ends, e0, mem, tap, where_is } = links;
    symbols.extend(net.lias.iter().enumerate().map(|(i, l)| {
        let (op, k) = where_is[i];
        Symbol { name: l.name.clone(), code: l.law.code, place: Stands::Lia(op, k) }
    }));

    // moving points
    let mut nodes = Vec::new();
    let mut proxies = Vec::new();
    for (p, at) in net.points.iter().zip(&plan.point.clone()) {
        if *at == u32::MAX {
            continue;
        }
        let family = &net.families[&p.family];
        let first = nodes.len() as u32;
        nodes.extend(family.nodes.iter().map(|m| plan.place[*m as usize]));
        let mut places = [Place::Coef(0); 2];
        for (k, c) in p.at.iter().enumerate() {
            places[k] = match c {
                Coordinate::Port(m) => Place::Mat(plan.place[*m as usize]),
                Coordinate::At(v) => plan.coordinate(*v, None),
                Coordinate::Live(q) => plan.coordinate(net.params[*q as usize].value, Some(*q)),
            };
        }
        proxies.push(Proxy { mat: *at, first, size: family.size, at: places });
    }
    let aimed = net.points.iter().zip(&used).any(|(p, u)| *u && p.at.iter().any(|c| !matches!(c, Coordinate::At(_))));

    // outputs
    let gains = plan.coef.len();
    let mut outputs = Vec::new();
    for o in &net.outs {
        let heard = match o.ear {
            Ear::Position(e) => Heard::Position(plan.alive(e)?),
            Ear::ForceOn(e) => Heard::ForceOn(plan.alive(e)?),
            Ear::ForceOf(l) => {
                let (op, k) = where_is[l as usize];
                Heard::ForceOf((forces[op as usize].tap + k as usize) as u32)
            }
        };
        outputs.push(Output { channel: o.channel, heard });
        plan.coef.push(0.0);
        let to = plan.coef.len() - 1;
        match (o.item, o.gain) {
            (Some(item), gain) => plan.load(Loader::Plain, item, &[gain], &[to]),
            (None, gain) => plan.coef[to] = gain.get(&[]).unwrap_or(1.0),
        }
    }
    let n_out = net.outs.iter().map(|o| o.channel as usize + 1).max().unwrap_or(0).max(net.channels.len());

    // what stands before the links in the list of forces moves them back
    let lead = u32::from(!enf.is_empty()) + u32::from(!weighed.is_empty());
    for symbol in &mut symbols {
        if let Stands::Lia(op, _) = &mut symbol.place {
            *op += lead;
        }
    }
    let account = |(i, op): (usize, &Op)| {
        let law = op.law?;
        let op_number = i + lead as usize;
        let Op { n, first, coef, mem, tap, .. } = *op;
        let (coefs, mems, linear, stored, lost) = (law.coefs, law.mem, law.linear, law.stored, law.lost);
        Some(Account { op: op_number, n, first, coef, mem, tap, coefs, mems, linear, stored, lost })
    };
    let accounts = forces.iter().enumerate().filter_map(account).collect();
    let ledger = options.energy.then_some(LedgerPlan { accounts, weight });

    let moves = plan.moves(order, n_mat);
    let live = plan.live_plan();
    let (coef, live_places) = (plan.coef, plan.live);
    let mut tables = net.tables.clone();
    tables.extend(own_tables(net).into_iter().map(|(_, t)| t));
    let layout = Layout {
        te: net.te,
        ratio: net.ratio,
        n_mat,
        n_lia: ends.len(),
        n_coef: coef.len(),
        n_mem: mem,
        n_tap: tap,
        channels: net.channels.len(),
        n_out,
        ends,
        e0,
        rest,
        nodes,
        proxies,
        tables,
        enx,
        enf,
        tgr,
        weighed,
        outputs,
        ledger,
    };
    let reads = passes::reads(&layout, live_places.len(), aimed);
    let forces = passes::forces(&layout, forces, weight);
    let writes = passes::writes(&layout, gains);
    let input: Vec<f64> = net.inputs.iter().map(|i| if i.role == InputRole::Force { 0.0 } else { i.rest }).collect();
    let ports = layout.enx.len() + layout.tgr.len() + layout.enf.len();
    let initial = State {
        x,
        d: v.iter().map(|v| v * net.te).collect(),
        f: alloc::vec![0.0; n_mat],
        mem: alloc::vec![0.0; mem],
        tap: alloc::vec![0.0; tap],
        held: input.clone(),
        input,
        output: alloc::vec![0.0; n_out],
        cells: alloc::vec![Cell::default(); layout.proxies.len()],
        border: alloc::vec![Border::default(); layout.tgr.len()],
        ramps: Ramps::new(live_places),
        ledger: options.energy.then(|| Ledger::new(n_mat, layout.n_lia, ports)),
        tick: 0,
        refused: 0,
        coef,
    };
    let initial = start(&layout, &forces, initial);
    Some(Scene {
        rate: net.rate,
        layout,
        reads,
        forces,
        writes,
        moves,
        inputs: net.inputs.clone(),
        probe_names: net.outs.iter().filter(|o| o.item.is_none()).map(|o| o.name.clone()).collect(),
        channel_names: net.channels.clone(),
        live,
        gestures: net.gestures.clone(),
        symbols,
        certificate,
        left_out: net.left_out.clone(),
        diags: Diags::new(),
        title: model.title().to_string(),
        seconds: net.seconds,
        initial,
    })
}

fn used_points(net: &Net) -> Vec<bool> {
    let mut used = alloc::vec![false; net.points.len()];
    let ends = net.lias.iter().flat_map(|l| l.ends);
    let heard = net.outs.iter().filter_map(|o| match o.ear {
        Ear::Position(e) | Ear::ForceOn(e) => Some(e),
        Ear::ForceOf(_) => None,
    });
    for e in ends.chain(heard).chain(net.pushes.iter().map(|p| p.1)) {
        if let End::Point(p) = e {
            used[p as usize] = net.under(e).iter().all(|m| net.alive[*m as usize]);
        }
    }
    used
}
