//! The matrix of implicit links: its slots and its first factor (docs/numerics.md §1.3).
//!
//! Links that share masses have one common factorisation; a link that shares none is solved in closed form. A pattern
//! with too much fill-in is refused, since it is solved in every tick.

use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::links::Links;
use crate::net::{End, LiaNode, MatRole, Measure, OutputTap};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::vec::Vec;
use ca_core::Precision;
use ca_core::internal::method::implicit::Inertia;
use ca_core::internal::numeric::ldl::Pattern;
use ca_core::internal::op::Op;
use ca_core::internal::op::layout::{ImplicitLinks, LinkForce, Pair};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, Span};

/// Largest number of entries of a factor; more cannot be solved within a tick on any machine.
const LARGEST: usize = 1_000_000;

impl LayoutBuilder<'_> {
    /// Returns the slots that a link acts on, end by end.
    fn pulls(&self, l: &LiaNode, read: &BTreeSet<u32>) -> Vec<Pull> {
        let mut all = Vec::new();
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let End::Mat(m) = l.ends[side] else { continue };
            let mat = &self.net.mats[m as usize];
            let read = matches!(mat.role, MatRole::Port(..) | MatRole::Slow) || read.contains(&m);
            all.extend(directions(l, side, mat.slots()).into_iter().map(|(axis, w)| Pull {
                place: self.slot[m as usize] + axis,
                weight: sign * w,
                moves: !mat.is_fixed() && axis < u32::from(mat.axes),
                read,
            }));
        }
        all
    }

    /// Returns the factorised matrix of the implicit links, and what it is made from; `None` without such links.
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
        let read: BTreeSet<u32> = net
            .outs
            .iter()
            .filter_map(|o| if let OutputTap::ForceOn(End::Mat(m)) = o.tap { Some(m) } else { None })
            .collect();
        let pulls: Vec<Vec<Pull>> = solved.iter().map(|(_, l)| self.pulls(l, &read)).collect();
        let mut met: BTreeMap<u32, u32> = BTreeMap::new();
        for p in pulls.iter().flatten().filter(|p| p.moves) {
            *met.entry(p.place).or_default() += 1;
        }
        let mut made = Inertia::default();
        let mut pairs: Vec<Pair> = Vec::new();
        // All other links refer to the numbers of the slots they move.
        let mut number: BTreeMap<u32, u32> = BTreeMap::new();
        let mut rows: Vec<([u32; 3], LinkForce, bool)> = Vec::new();
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
            let mut force = LinkForce { coef, tap, ..LinkForce::default() };
            let mut needed = tap.is_some();
            for p in pulls {
                if p.moves {
                    let next = number.len() as u32;
                    force.moving.push((*number.entry(p.place).or_insert(next), p.weight));
                } else {
                    needed |= p.read;
                    force.fixed.push((p.place, p.weight));
                }
            }
            rows.push((coef, force, needed));
        }
        let n = number.len();
        let joined = rows.iter().flat_map(|(_, f, _)| {
            f.moving.iter().enumerate().flat_map(|(k, (i, _))| f.moving[..k].iter().map(move |(j, _)| (*i, *j)))
        });
        let Some(pattern) = Pattern::new(n, joined, LARGEST) else {
            let title = format!("`{}` and the other implicit links are too many to solve in a tick", item.name);
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
        let mut forces = Vec::new();
        for (coef, mut f, needed) in rows {
            f.moving.iter_mut().for_each(|(i, _)| *i = to[*i as usize]);
            let first = made.entries.len() as u32;
            // Weights in the precision of the tick.
            let kept = |w: f64| if net.precision == Precision::Single { f64::from(w as f32) } else { w };
            made.entries.extend(f.moving.iter().map(|(i, w)| (*i, kept(*w))));
            made.links.push((coef, [first, f.moving.len() as u32]));
            forces.extend(needed.then_some(f));
        }
        let mut factor = Vec::new();
        if !made.factor(|c| self.coef[c as usize], &mut factor, &mut Vec::new()) {
            diags.push(beyond(&item.name, item.name_span));
            return None;
        }
        let coef = self.coef.len();
        self.coef.extend(factor);
        Some((ImplicitLinks { places: at, pattern: made.pattern.clone(), coef, forces, pairs }, made))
    }
}

fn beyond(name: &str, span: Span) -> Diag {
    let d =
        Diag::error("E009", format!("the coefficients of `{name}` and the other implicit links cannot be computed"));
    d.at(span, "overflows").help("use a larger mass, or less stiffness and viscosity")
}

/// Action of a link on one slot of the state.
struct Pull {
    place: u32,
    weight: f64,
    /// True if forces move the slot.
    moves: bool,
    /// True if the force on the slot is read although forces do not move it.
    read: bool,
}

/// Returns the axes, with weights, by which a link measures one of its ends.
fn directions(l: &LiaNode, side: usize, places: u32) -> Vec<(u32, f64)> {
    match l.measure {
        Measure::Along(n) => (0..places).map(|k| (k, n[k as usize])).filter(|(_, w)| *w != 0.0).collect(),
        Measure::Line(axes) => alloc::vec![(u32::from(axes[side]), 1.0)],
        Measure::Radial => Vec::new(),
    }
}
