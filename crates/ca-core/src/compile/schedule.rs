//! Schedule: flat arrays and the list of passes. What a scene does not have makes no entry here.

use super::Options;
use super::certify::Certificate;
use super::links::{Links, own_tables};
use super::net::{Coordinate, Ear, End, MatRole, Net};
use super::plan::Plan;
use super::start::start;
use crate::border::{self, Border};
use crate::energy::{self, Ledger, LedgerPlan};
use crate::io::PortRole;
use crate::live::{self, Loader, Ramps};
use crate::model::Model;
use crate::model::diag::Diags;
use crate::op::wide::wide;
use crate::op::{Op, pass};
use crate::scene::{Enf, Enx, Heard, Output, Place, Proxy, Scene, Stands, Symbol};
use crate::state::{Cell, State};
use alloc::collections::BTreeMap;
use alloc::string::ToString;
use alloc::vec::Vec;

/// Builds the scene. `None` where the findings hold an error.
pub fn schedule(
    model: &Model,
    net: Net,
    order: &[u32],
    options: &Options,
    certificate: Certificate,
    diags: &mut Diags,
) -> Option<Scene> {
    let used = used_points(&net);
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
        Plan { net: &net, place, point, coef: alloc::vec![0.0; 3 * n_mat], live: Vec::new(), modules: BTreeMap::new() };
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
    let Links { mut forces, ends, e0, mem, tap, mut where_is, first } = links;
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

    // passes
    let mut reads = Vec::new();
    let pass = |name, kernel, n: usize| Op::pass(name, kernel, n);
    if !enx.is_empty() {
        reads.push(pass("ENX", pass::enx, enx.len()));
    }
    if !tgr.is_empty() {
        reads.push(pass("TGR in", border::position, tgr.len()));
    }
    let live_any = !plan.live.is_empty();
    if options.energy {
        if !proxies.is_empty() {
            reads.push(pass("points", pass::project, proxies.len()));
        }
        reads.push(pass("ledger", energy::book, n_mat + net.lias.len()));
    }
    if live_any {
        reads.push(pass("changes", live::ramp, plan.live.len()));
    }
    if aimed {
        reads.push(pass("aim", pass::aim, proxies.len()));
    }
    if !proxies.is_empty() && (!options.energy || aimed) {
        reads.push(pass("points", pass::project, proxies.len()));
    }
    if options.energy && (live_any || aimed) {
        reads.push(pass("changes booked", energy::rebook, n_mat + net.lias.len()));
    }
    let mut before = Vec::new();
    if !enf.is_empty() {
        before.push(pass("ENF", pass::enf, enf.len()));
    }
    if !weighed.is_empty() {
        before.push(Op { coef: weight, ..pass("weight", pass::weight, weighed.len()) });
    }
    // link ops move back by what stands before them
    let shift = before.len() as u32;
    where_is.iter_mut().for_each(|w| w.0 += shift);
    symbols.iter_mut().for_each(|s| {
        if let Stands::Lia(op, _) = &mut s.place {
            *op += shift;
        }
    });
    let mut plan_first: Vec<usize> = alloc::vec![0; before.len()];
    plan_first.extend(first);
    before.append(&mut forces);
    let mut forces = before;
    if !proxies.is_empty() {
        forces.push(pass("points back", pass::spread, proxies.len()));
    }
    if !tgr.is_empty() {
        forces.push(pass("TGR out", border::collect, tgr.len()));
    }
    if options.energy {
        forces.push(pass("ledger keeps", energy::keep, n_mat));
    }
    plan_first.resize(forces.len(), 0);
    let writes = if outputs.is_empty() {
        Vec::new()
    } else {
        alloc::vec![Op { coef: gains, ..pass("outputs", pass::outputs, outputs.len()) }]
    };
    let moves = plan.moves(order, n_mat);

    let live_plan = plan.live_plan();
    let (coef, n_live) = (plan.coef, plan.live.len());
    let n_lia = ends.len();
    let input: Vec<f64> =
        net.inputs.iter().map(|i| if i.role == crate::scene::InputRole::Force { 0.0 } else { i.rest }).collect();
    let ledger = options.energy.then(|| Ledger::new(n_mat, n_lia, enx.len() + tgr.len() + enf.len()));
    let initial = State {
        x,
        d: v.iter().map(|v| v * net.te).collect(),
        f: alloc::vec![0.0; n_mat],
        mem: alloc::vec![0.0; mem],
        tap: alloc::vec![0.0; tap],
        held: input.clone(),
        input,
        output: alloc::vec![0.0; n_out],
        cells: alloc::vec![Cell::default(); proxies.len()],
        border: alloc::vec![Border::default(); tgr.len()],
        ramps: Ramps::new(n_live),
        ledger,
        tick: 0,
        refused: 0,
        coef,
    };
    let mut scene = Scene {
        rate: net.rate,
        te: net.te,
        ratio: net.ratio,
        n_mat,
        n_lia,
        n_coef: initial.coef.len(),
        n_mem: mem,
        n_tap: tap,
        channels: net.channels.len(),
        n_out,
        reads,
        forces,
        writes,
        moves,
        ends,
        e0,
        rest,
        nodes,
        proxies,
        tables: net.tables.clone(),
        enx,
        enf,
        tgr,
        weighed,
        outputs,
        inputs: net.inputs.clone(),
        probe_names: net.outs.iter().filter(|o| o.item.is_none()).map(|o| o.name.clone()).collect(),
        channel_names: net.channels.clone(),
        ledger: options.energy.then_some(LedgerPlan { first: plan_first, weight }),
        live: live_plan,
        gestures: net.gestures.clone(),
        symbols,
        certificate,
        left_out: net.left_out.clone(),
        diags: Diags::new(),
        title: model.title().to_string(),
        seconds: net.seconds,
        initial: State::default(),
    };
    scene.tables.extend(own_tables(&net).into_iter().map(|(_, t)| t));
    scene.initial = start(&scene, initial);
    Some(scene)
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

impl Plan<'_> {
    /// Advance passes: stretches of MATs with and without coefficients of their own; nothing for what is fixed.
    fn moves(&self, order: &[u32], n_mat: usize) -> Vec<Op> {
        #[derive(PartialEq, Clone, Copy)]
        enum Class {
            Free,
            Full,
            Held,
        }
        let live: alloc::collections::BTreeSet<u32> = self.live.iter().copied().collect();
        // what a fixed point has no use for costs less than two stretches, so it goes with its neighbour
        let class = |at: usize| match self.net.mats[order[at] as usize].role {
            MatRole::Port(..) => Some(Class::Held),
            MatRole::Mat(s) if s.fixed => None,
            MatRole::Mat(_) => {
                let own = self.coef[at] != 1.0 || self.coef[n_mat + at] != 0.0 || live.contains(&(at as u32));
                Some(if own { Class::Full } else { Class::Free })
            }
        };
        let mut classes: Vec<Option<Class>> = (0..order.len()).map(class).collect();
        for i in 1..classes.len() {
            classes[i] = classes[i].or(classes[i - 1].filter(|c| *c != Class::Held));
        }
        for i in (1..classes.len()).rev() {
            classes[i - 1] = classes[i - 1].or(classes[i].filter(|c| *c != Class::Held));
        }
        let mut ops = Vec::new();
        let mut at = 0;
        for stretch in classes.chunk_by(|a, b| a == b) {
            let first = at;
            at += stretch.len();
            let (name, kernel): (_, crate::op::Kernel) = match stretch[0] {
                Some(Class::Held) => continue,
                Some(Class::Full) => ("advance CEL", wide::<pass::AdvanceFull>),
                // a fixed point that stands alone does not move, but the force on it starts from nothing each tick
                Some(Class::Free) | None => ("advance MAS", wide::<pass::AdvanceFree>),
            };
            ops.push(Op { mat: first, ..Op::pass(name, kernel, stretch.len()) });
        }
        if !order.is_empty() {
            ops.push(Op::pass("flush", pass::flush, n_mat));
        }
        ops
    }
}
