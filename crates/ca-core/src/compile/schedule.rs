//! Schedule: flat arrays and the list of passes. What a scene does not have makes no entry here.

use super::certify::Certificate;
use super::net::{Coordinate, Ear, End, LiaNode, MatRole, Net};
use super::{KernelClass, Options};
use crate::border::{self, Border};
use crate::energy::{self, Ledger, LedgerPlan};
use crate::generate::Arg;
use crate::io::PortRole;
use crate::kind::Role;
use crate::live::{self, LiveItem, LiveModule, LivePlan, Loader, Ramps, Source};
use crate::model::Model;
use crate::model::diag::{Diag, Diags};
use crate::op::{Form, Op, pass};
use crate::phi::Law;
use crate::scene::{Enf, Enx, Heard, Output, Place, Proxy, Scene, Stands, Symbol};
use crate::state::{Cell, State};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::ToString;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// Chains shorter than this are gathered: a run has two loops to set up.
const SHORTEST_RUN: usize = 4;

struct Plan<'a> {
    net: &'a Net,
    /// document number → place in the state; `u32::MAX` for what is left out
    place: Vec<u32>,
    /// moving point → place in the state
    point: Vec<u32>,
    /// coefficients so far
    coef: Vec<f64>,
    /// places of live coefficients
    live: Vec<u32>,
    /// modules with live coefficients, by item
    modules: BTreeMap<u32, Vec<LiveModule>>,
}

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

/// Tables that laws bring with them, in order of first use, after those of the model.
fn own_tables(net: &Net) -> Vec<(&'static Law, crate::table::Table)> {
    let mut own: Vec<(&'static Law, crate::table::Table)> = Vec::new();
    for l in &net.lias {
        if let Some(table) = l.law.table {
            if !own.iter().any(|(law, _)| core::ptr::eq(*law, l.law)) {
                own.push((l.law, table()));
            }
        }
    }
    own
}

/// The second-order start (numerics 1.1): d₀ = v T − ½ (T²/m) F(x₀).
fn start(scene: &Scene, mut s: State) -> State {
    let n = scene.n_mat;
    let memory = |s: &mut State| {
        for op in &scene.forces {
            let Some(law) = op.law.filter(|l| l.mem > 0) else { continue };
            for i in 0..op.n {
                let [a, b] = scene.ends[op.first + i].map(|m| m as usize);
                let e = s.x[b] - s.x[a] + scene.e0[op.first + i];
                let c: Vec<f64> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n + i]).collect();
                (law.start)(&c, e, &mut s.mem[op.mem + i * law.mem..][..law.mem]);
            }
        }
    };
    for (k, p) in scene.proxies.iter().enumerate() {
        s.cells[k] = pass::cell(scene, &s, p);
    }
    let project = Op::pass("points", pass::project, scene.proxies.len());
    pass::project(&project, scene, &mut s);
    memory(&mut s);
    let mut trial = s.clone();
    for op in scene.forces.iter().filter(|op| op.name != "TGR out" && op.name != "ENF") {
        (op.kernel)(op, scene, &mut trial);
    }
    for i in 0..n {
        let (p, q, c) = (s.coef[i], s.coef[n + i], s.coef[2 * n + i]);
        if c == 0.0 {
            s.d[i] = 0.0;
        } else {
            s.d[i] -= 0.5 * (c * trial.f[i] + q * s.x[i] - (1.0 - p) * s.d[i]);
        }
    }
    pass::project(&project, scene, &mut s);
    s
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

struct Links {
    forces: Vec<Op>,
    ends: Vec<[u32; 2]>,
    e0: Vec<f64>,
    mem: usize,
    tap: usize,
    /// for each link of the net, its op and position in it
    where_is: Vec<(u32, u32)>,
    /// for each op, its first link in the ledger
    first: Vec<usize>,
}

impl Plan<'_> {
    fn at(&self, e: End) -> u32 {
        match e {
            End::Mat(m) => self.place[m as usize],
            End::Point(p) => self.point[p as usize],
        }
    }

    fn alive(&self, e: End) -> Option<u32> {
        Some(self.at(e)).filter(|m| *m != u32::MAX)
    }

    /// Computes coefficients into `to`; remembers how, where they may change.
    fn load(&mut self, loader: Loader, item: u32, values: &[Source], to: &[usize]) {
        let mut out = [0.0; 8];
        let n = loader.load(&self.net.values(item, values), self.net.te, &mut out);
        for (k, t) in to[..n].iter().enumerate() {
            self.coef[*t] = out[k];
        }
        if self.net.is_live(item) && values.iter().any(|s| matches!(s, Source::Slot(_))) {
            let places = to[..n].iter().map(|t| self.live_place(*t)).collect();
            let module = LiveModule { loader, values: Arc::from(values), to: places };
            self.modules.entry(item).or_default().push(module);
        }
    }

    fn live_place(&mut self, coef: usize) -> u32 {
        self.live.push(coef as u32);
        self.live.len() as u32 - 1
    }

    fn coordinate(&mut self, v: f64, param: Option<u32>) -> Place {
        self.coef.push(v);
        let at = self.coef.len() - 1;
        if let Some(p) = param {
            let to = alloc::vec![self.live_place(at)];
            let module = LiveModule { loader: Loader::Plain, values: Arc::from([Source::Slot(0)]), to };
            // points have no item: they are numbered after the items, one per parameter
            self.modules.entry(self.net.items.len() as u32 + p).or_default().push(module);
        }
        Place::Coef(at as u32)
    }

    fn live_plan(&mut self) -> LivePlan {
        let items = core::mem::take(&mut self.modules)
            .into_iter()
            .map(|(id, modules)| {
                if let Some(item) = self.net.items.get(id as usize) {
                    LiveItem {
                        kind: item.kind,
                        args: item.args.clone(),
                        follows: item.follows.clone(),
                        generator: if let Role::Generator(g) = item.kind.role { Some(g) } else { None },
                        modules,
                    }
                } else {
                    let p = id as usize - self.net.items.len();
                    LiveItem {
                        kind: &crate::io::ENX,
                        args: alloc::vec![Arg::Num(self.net.params[p].value)],
                        follows: alloc::vec![(0, p, 1.0)],
                        generator: None,
                        modules,
                    }
                }
            })
            .collect();
        LivePlan { params: self.net.params.clone(), coefs: self.live.clone(), items }
    }

    /// Batches of links: in document order, or by law with chains as runs.
    fn batches(&self, class: KernelClass) -> Vec<(Vec<u32>, bool)> {
        let same = |a: u32, b: u32| core::ptr::eq(self.law(a), self.law(b));
        let all: Vec<u32> = (0..self.net.lias.len() as u32).collect();
        if class == KernelClass::Reference {
            return all.chunk_by(|a, b| same(*a, *b)).map(|c| (c.to_vec(), false)).collect();
        }
        let mut by_law: Vec<Vec<u32>> = Vec::new();
        for l in all {
            match by_law.iter_mut().find(|g| same(g[0], l)) {
                Some(g) => g.push(l),
                None => by_law.push(alloc::vec![l]),
            }
        }
        let mut out = Vec::new();
        for group in by_law {
            let mut loose = Vec::new();
            let follows = |a: &u32, b: &u32| {
                let (a, b) = (self.ends(*a), self.ends(*b));
                a[1] == a[0].wrapping_add(1) && b[0] == a[1] && b[1] == b[0].wrapping_add(1)
            };
            for chain in group.chunk_by(follows) {
                if chain.len() >= SHORTEST_RUN {
                    out.push((chain.to_vec(), true));
                } else {
                    loose.extend_from_slice(chain);
                }
            }
            if !loose.is_empty() {
                out.push((loose, false));
            }
        }
        out
    }

    fn law(&self, l: u32) -> &'static Law {
        self.net.lias[l as usize].law
    }

    fn ends(&self, l: u32) -> [u32; 2] {
        self.net.lias[l as usize].ends.map(|e| self.at(e))
    }

    /// Constant part of the elongation: laws with a rest length are slack at rest, contacts count from position.
    fn offset(&self, l: &LiaNode) -> f64 {
        let distance = self.net.rest(l.ends[1]) - self.net.rest(l.ends[0]);
        let slack = if l.kind.param("l0").is_some() { l.l0.unwrap_or(distance) } else { 0.0 };
        let generated = matches!(l.kind.role, Role::Lia(_)) && self.net.items[l.item as usize].kind.code != l.kind.code;
        if generated { 0.0 } else { distance - slack }
    }

    fn links(&mut self, options: &Options, diags: &mut Diags, model: &Model) -> Links {
        let net = self.net;
        let own = own_tables(net);
        let heard: Vec<u32> =
            net.outs.iter().filter_map(|o| if let Ear::ForceOf(l) = o.ear { Some(l) } else { None }).collect();
        let batches = self.batches(options.kernel);
        let scratch = batches.iter().filter(|b| b.1).map(|b| b.0.len()).max().unwrap_or(0);
        let mut k = Links {
            forces: Vec::new(),
            ends: Vec::with_capacity(net.lias.len()),
            e0: Vec::with_capacity(net.lias.len()),
            mem: 0,
            tap: scratch,
            where_is: alloc::vec![(0, 0); net.lias.len()],
            first: Vec::new(),
        };
        for (batch, run) in batches {
            let law = self.law(batch[0]);
            let n = batch.len();
            let (first, coef) = (k.ends.len(), self.coef.len());
            self.coef.resize(coef + n * law.coefs, 0.0);
            for (i, id) in batch.iter().enumerate() {
                let l = &net.lias[*id as usize];
                k.ends.push(self.ends(*id));
                k.e0.push(self.offset(l));
                k.where_is[*id as usize] = (k.forces.len() as u32, i as u32);
                let mut values = l.values.to_vec();
                if let Some(t) = own.iter().position(|(o, _)| core::ptr::eq(*o, law)) {
                    values.push(Source::Const((net.tables.len() + t) as f64));
                }
                let mut to = [0usize; 8];
                for (s, t) in to[..law.coefs].iter_mut().enumerate() {
                    *t = coef + s * n + i;
                }
                self.load(Loader::Lia(law), l.item, &values, &to);
                contact_at_load(net, l, k.e0[first + i], model, diags);
            }
            let tap = options.energy || batch.iter().any(|l| heard.contains(l));
            let form = Form { run, offset: k.e0[first..].iter().any(|e| *e != 0.0), tap };
            let mut op = Op::pass(law.code, (law.kernel)(form), n);
            op = Op { law: Some(law), form, first, coef, mem: k.mem, mat: k.ends[first][0] as usize, ..op };
            if tap {
                op.tap = k.tap;
                k.tap += n;
            }
            k.mem += n * law.mem;
            k.first.push(first);
            k.forces.push(op);
        }
        k
    }

    /// Advance passes: stretches of MATs with and without coefficients of their own; nothing for what is fixed.
    fn moves(&self, order: &[u32], n_mat: usize) -> Vec<Op> {
        #[derive(PartialEq, Clone, Copy)]
        enum Class {
            Free,
            Full,
            Held,
        }
        let live: alloc::collections::BTreeSet<u32> = self.live.iter().copied().collect();
        let class = |at: usize| {
            let m = &self.net.mats[order[at] as usize];
            let (p, q) = (self.coef[at], self.coef[n_mat + at]);
            match m.role {
                // a fixed point inside a chain moves with C = 0: cheaper than two stretches
                MatRole::Mat(s) if s.fixed => Class::Free,
                MatRole::Mat(_) => {
                    let own = p != 1.0 || q != 0.0 || (live.contains(&(at as u32)) && m.code == "CEL");
                    if own { Class::Full } else { Class::Free }
                }
                MatRole::Port(..) => Class::Held,
            }
        };
        let places: Vec<usize> = (0..order.len()).collect();
        let mut ops = Vec::new();
        for stretch in places.chunk_by(|a, b| class(*a) == class(*b)) {
            let (name, kernel): (_, crate::op::Kernel) = match class(stretch[0]) {
                Class::Free => ("advance MAS", pass::advance_free),
                Class::Full => ("advance CEL", pass::advance_full),
                Class::Held => continue,
            };
            ops.push(Op { mat: stretch[0], ..Op::pass(name, kernel, stretch.len()) });
        }
        if !order.is_empty() {
            ops.push(Op::pass("flush", pass::flush, n_mat));
        }
        ops
    }
}

/// Warns of a contact that is pressed together before anything has moved.
fn contact_at_load(net: &Net, l: &LiaNode, e0: f64, model: &Model, diags: &mut Diags) {
    if !matches!(l.kind.code, "BUT" | "HRZ") {
        return;
    }
    let at = |e: End| if let End::Mat(m) = e { net.mats[m as usize].dx0 } else { 0.0 };
    let e = e0 + at(l.ends[1]) - at(l.ends[0]);
    let mut c = [0.0; 8];
    (l.law.load)(&net.values(l.item, &l.values), net.te, &mut c[..l.law.coefs]);
    let f = (l.law.force)(&c[..l.law.coefs], &mut [], &net.tables, e, 0.0);
    let item = &model.items[net.items[l.item as usize].model];
    let known = |d: &Diag| d.code == "W102" && d.span() == item.name_span && item.name_span.is_some();
    if f != 0.0 && !diags.list.iter().any(known) {
        let (a, b) = (net.end_name(l.ends[0]), net.end_name(l.ends[1]));
        let d = Diag::warning(
            "W102",
            format!(
                "`{}` presses at load, with {}",
                l.name,
                crate::model::quantity::show(f.abs(), crate::kind::Unit::NEWTON)
            ),
        );
        let help =
            format!("it keeps `{b}` above `{a}`; swap the ends of `between`, or move one of them by `x` or `dx0`");
        diags.push(d.at(item.name_span, format!("`{b}` is {e:.3e} m above `{a}`")).help(help));
    }
}
