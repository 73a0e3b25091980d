//! Implicit: which linear links and cells go by the methods `centred` and `implicit`, and the matrix the links make.
//!
//! Decides that a method is chosen before the laws are specialised, by a word of the link, of its group or of the model,
//! and that a cell needs no matrix: its own spring and damper only make it heavier ([`ca_core::mat::cel`]). Refused where
//! the matrix would change from tick to tick (distances in space, quadripoles, moving points), and where a contact that
//! counts on the motion to come shares a mass with such a link.

use super::lines::LineNode;
use super::links::Links;
use super::net::{Ear, End, LiaNode, MatRole, Measure, Net};
use super::plan::Plan;
use super::say::no_method;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::layout::{Felt, ImplicitLinks, Pair};
use ca_core::ldl::Pattern;
use ca_core::live::Source;
use ca_core::method::implicit::Inertia;
use ca_core::op::Op;
use ca_core::phi::implicit;
use ca_core::real::{real, wide};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, Span};

/// More entries of a factor than this are refused: no machine solves them in a tick.
const LARGEST: usize = 1_000_000;

/// Gives links and cells the method that they, their group or the model ask for.
pub fn choose(net: &mut Net) {
    let asked = |net: &Net, item: u32, kind: &ca_core::kind::Kind, values: &[Source]| {
        let at = |name: &str| {
            let i = kind.param(name)?;
            values.get(i)?.get(&net.items[item as usize].slots)
        };
        let medium = net.medium_of(net.items[item as usize].group);
        implicit::theta(at("method").unwrap_or(medium.method), at("theta").or(medium.theta))
    };
    // item, its values as written, and as the law takes them: most links of a generator share theirs
    let mut last: Option<(u32, [Arc<[Source]>; 2])> = None;
    for i in 0..net.lias.len() {
        let l = &net.lias[i];
        // the law before it is specialised; what has no method of this kind has no such parameters
        let (k, z) = match l.kind.code {
            "REF" => (Some(1), Some(2)),
            "RES" => (Some(1), None),
            "FRO" => (None, Some(1)),
            _ => continue,
        };
        let Some(theta) = asked(net, l.item, l.kind, &l.values) else { continue };
        // with neither viscosity nor θ there is nothing to be implicit for: it is the explicit link
        let z_of = z.and_then(|z| l.values.get(z)).copied().unwrap_or(Source::Absent);
        let live = matches!(z_of, Source::Slot(_)) && net.is_live(l.item);
        if theta == 0.0 && !live && z_of.get(&net.items[l.item as usize].slots).unwrap_or(0.0) == 0.0 {
            continue;
        }
        let known = last.as_ref().filter(|(item, [old, _])| *item == l.item && old[..] == l.values[..]);
        let values = known.map_or_else(
            || {
                let from = |p: Option<usize>| p.and_then(|p| l.values.get(p).copied()).unwrap_or(Source::Absent);
                Arc::from([from(k), from(z), Source::Const(theta)])
            },
            |(_, [_, new])| new.clone(),
        );
        last = Some((l.item, [l.values.clone(), values.clone()]));
        let l = &mut net.lias[i];
        (l.law, l.values) = (&implicit::LAW, values);
    }
    let cell = &ca_core::mat::CEL;
    let Some((method, theta)) = cell.param("method").zip(cell.param("theta")) else { return };
    // a junction of waves is exact as it is: what would be its damper is what waves take along
    let junctions: BTreeSet<u32> = net.lines.iter().flat_map(LineNode::junctions).collect();
    for i in (0..net.mats.len()).filter(|i| !junctions.contains(&(*i as u32))) {
        let m = &net.mats[i];
        let Some(share) = asked(net, m.item, cell, &m.values).filter(|_| m.code == cell.code) else { continue };
        let mut values = m.values.to_vec();
        // θ = 0 by the method `implicit` is the method `centred`
        (values[method], values[theta]) = (Source::Const(2.0), Source::Const(share));
        net.mats[i].values = Arc::from(values);
    }
}

/// True where some link or cell goes by θ = 1/12, whose tick is of the fourth order without viscosity.
pub fn is_fourth(net: &Net) -> bool {
    let twelfth = |theta: Option<f64>| theta.is_some_and(|t| (t - 1.0 / 12.0).abs() < 1e-6);
    let links = net.lias.iter().filter(|l| l.law.implicit).filter_map(|l| l.values.get(2).map(|v| (l.item, *v)));
    let cell = &ca_core::mat::CEL;
    let cells = net.mats.iter().filter(|m| m.code == cell.code && m.values.len() == cell.params.len());
    let theta = cell.param("theta").unwrap_or(0);
    let cells = cells.filter_map(|m| m.values.get(theta).map(|v| (m.item, *v)));
    links.chain(cells).any(|(item, theta)| twelfth(theta.get(&net.items[item as usize].slots)))
}

/// Refuses links whose matrix would not stay as it is.
pub fn check(model: &Model, net: &Net, diags: &mut Diags) {
    let mut reported = BTreeSet::new();
    let mut late: BTreeMap<u32, &LiaNode> = BTreeMap::new();
    for l in net.lias.iter().filter(|l| l.law.is_late()) {
        late.extend(l.all_ends().filter_map(|e| if let End::Mat(m) = e { Some((m, l)) } else { None }));
    }
    for l in net.lias.iter().filter(|l| l.law.implicit) {
        if reported.contains(&l.item) {
            continue;
        }
        let shared = l.all_ends().find_map(|e| match e {
            End::Mat(m) if !net.mats[m as usize].is_fixed() => late.get(&m).map(|late| (m, *late)),
            _ => None,
        });
        let point = l.all_ends().find(|e| matches!(e, End::Point(_)));
        let (title, label, help) = if l.is_radial() || l.onto.is_some() {
            let title = format!("`{}` is implicit along a distance in space", l.name);
            (title, "not between points in space", "give it a direction, `along`, or `method = \"ca\"`")
        } else if let Some(point) = point {
            let title = format!("`{}` is implicit at a moving point, `{}`", l.name, net.end_name(point));
            (title, "not at moving points", "use `method = \"ca\"`, or a mass such as `low[8]` in its place")
        } else if let Some((m, other)) = shared {
            let m = &net.mats[m as usize].name;
            let title = format!("`{}` is implicit, and so is `{}`, which touches `{m}` too", l.name, other.name);
            (title, "two kinds of implicit links at one mass", "use `method = \"ca\"` for one of them")
        } else {
            continue;
        };
        reported.insert(l.item);
        diags.push(no_method(&model.items[net.items[l.item as usize].model], title, label, help));
    }
}

impl Plan<'_> {
    /// The places a link pulls at, end by end.
    fn pulls(&self, l: &LiaNode, heard: &BTreeSet<u32>) -> Vec<Pull> {
        let mut all = Vec::new();
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let End::Mat(m) = l.ends[side] else { continue };
            let mat = &self.net.mats[m as usize];
            let heard = matches!(mat.role, MatRole::Port(..)) || heard.contains(&m);
            all.extend(directions(l, side, mat.places()).into_iter().map(|(axis, w)| Pull {
                place: self.place[m as usize] + axis,
                weight: sign * w,
                moves: !mat.is_fixed() && axis < u32::from(mat.axes),
                heard,
            }));
        }
        all
    }

    /// The matrix of the implicit links, factorised, and what it is made of; none where there are none.
    pub fn implicit(
        &mut self,
        n_mat: usize,
        links: &Links,
        model: &Model,
        diags: &mut Diags,
    ) -> Option<(ImplicitLinks, Inertia)> {
        let net = self.net;
        let solved: Vec<(usize, &LiaNode)> = net.lias.iter().enumerate().filter(|(_, l)| l.law.implicit).collect();
        let (_, first) = solved.first()?;
        let item = &model.items[net.items[first.item as usize].model];
        let heard: BTreeSet<u32> = net
            .outs
            .iter()
            .filter_map(|o| if let Ear::ForceOn(End::Mat(m)) = o.ear { Some(m) } else { None })
            .collect();
        let pulls: Vec<Vec<Pull>> = solved.iter().map(|(_, l)| self.pulls(l, &heard)).collect();
        let mut met: BTreeMap<u32, u32> = BTreeMap::new();
        for p in pulls.iter().flatten().filter(|p| p.moves) {
            *met.entry(p.place).or_default() += 1;
        }
        let mut made = Inertia::default();
        let mut pairs: Vec<Pair> = Vec::new();
        // the rest by numbers of the places they move
        let mut number: BTreeMap<u32, u32> = BTreeMap::new();
        let mut rows: Vec<([u32; 3], Felt, bool)> = Vec::new();
        for ((id, l), pulls) in solved.iter().zip(&pulls) {
            let (op, at) = links.where_is[*id];
            let op: &Op = &links.forces[op as usize];
            let coef = core::array::from_fn(|k| (op.coef + k * op.n + at as usize) as u32);
            let tap = op.form.tap.then_some((op.tap + at as usize) as u32);
            let apart = pulls.iter().all(|p| !p.moves || met[&p.place] == 1);
            if let (Measure::Line(_), [a, b], true) = (l.measure, &pulls[..], apart) {
                let ends = [a.place, b.place];
                made.pairs.push((coef, ends.map(|p| 2 * n_mat as u32 + p)));
                pairs.push(Pair { ends, tap });
                continue;
            }
            let mut felt = Felt { coef, tap, ..Felt::default() };
            let mut needed = tap.is_some();
            for p in pulls {
                if p.moves {
                    let next = number.len() as u32;
                    felt.moves.push((*number.entry(p.place).or_insert(next), real(p.weight)));
                } else {
                    needed |= p.heard;
                    felt.held.push((p.place, real(p.weight)));
                }
            }
            rows.push((coef, felt, needed));
        }
        let n = number.len();
        let joined = rows.iter().flat_map(|(_, f, _)| {
            f.moves.iter().enumerate().flat_map(|(k, (i, _))| f.moves[..k].iter().map(move |(j, _)| (*i, *j)))
        });
        let Some(pattern) = Pattern::new(n, joined, LARGEST) else {
            let title = format!("`{}` and what is implicit with it are too many to be solved in a tick", item.name);
            let help = "use `method = \"ca\"` where stiffness allows it, or a coarser mesh";
            diags.push(Diag::error("E027", title).at(item.name_span, "too many").help(help));
            return None;
        };
        let mut to = alloc::vec![0; n];
        pattern.order.iter().zip(0..).for_each(|(i, k)| to[*i as usize] = k);
        let mut at = alloc::vec![0; n];
        for (place, i) in &number {
            at[to[*i as usize] as usize] = *place;
        }
        (made.pattern, made.mobility) = (pattern, at.iter().map(|p| 2 * n_mat as u32 + p).collect());
        let mut felt = Vec::new();
        for (coef, mut f, needed) in rows {
            f.moves.iter_mut().for_each(|(i, _)| *i = to[*i as usize]);
            let first = made.entries.len() as u32;
            made.entries.extend(f.moves.iter().map(|(i, w)| (*i, wide(*w))));
            made.links.push((coef, [first, f.moves.len() as u32]));
            felt.extend(needed.then_some(f));
        }
        let mut factor = Vec::new();
        if !made.factor(|c| self.coef[c as usize], &mut factor, &mut Vec::new()) {
            diags.push(beyond(&item.name, item.name_span));
            return None;
        }
        let coef = self.coef.len();
        self.coef.extend(factor);
        Some((ImplicitLinks { places: at, pattern: made.pattern.clone(), coef, felt, pairs }, made))
    }
}

fn beyond(name: &str, span: Span) -> Diag {
    let d = Diag::error("E009", format!("the numbers of `{name}` and what is implicit with it are beyond computing"));
    d.at(span, "overflows").help("use a larger mass, or less stiffness and viscosity")
}

/// What a link does to one place in the state.
struct Pull {
    place: u32,
    weight: f64,
    /// forces move it
    moves: bool,
    /// somebody hears the force on it although it is not moved
    heard: bool,
}

/// Axes and weights by which a link feels one of its ends.
fn directions(l: &LiaNode, side: usize, places: u32) -> Vec<(u32, f64)> {
    match l.measure {
        Measure::Along(n) => (0..places).map(|k| (k, n[k as usize])).filter(|(_, w)| *w != 0.0).collect(),
        Measure::Line(axes) => alloc::vec![(u32::from(axes[side]), 1.0)],
        Measure::Radial => Vec::new(),
    }
}
