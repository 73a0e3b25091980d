//! Fuse: rows of linear links go into the pass that integrates their masses, where nothing tells the difference.
//!
//! The fused pass sums (Fᵢ − Fᵢ₋₁) + f, where f is what others gave ([`Integrate`]). Decides that the bits of a scene are
//! those of its list of passes: a row is fused only where no other pass adds to its masses before it, and at most one
//! number is added behind it, since then both sums are the same. And only where nobody reads the whole force on one of its
//! masses, which is then known nowhere: the ledger, an output of force, a link that is solved behind the others.

use crate::emit::batches::Batch;
use crate::emit::pass_list::Class;
use crate::emit::plan::Plan;
use crate::net::lines::LineNode;
use crate::net::{End, MatRole, OutputTap};
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::op::{Form, Integrate, MeasureKind, Op};
use ca_core::scene::{Location, Symbol};

/// Marks the rows that integrate their masses, which are of these `classes` slot by slot; what does not move among them
/// gets theirs.
pub fn mark(plan: &Plan, options: &Options, classes: &mut [Option<Class>], batches: &mut [Batch]) {
    let net = plan.net;
    let staged = batches.iter().any(|b| b.law.implicit || b.law.is_staged());
    if options.kernel != KernelClass::Fast || options.energy || staged || net.as_milib || net.is_composed() {
        return;
    }
    let heard = plan.heard();
    let added = added(plan, batches);
    for (i, row) in batches.iter_mut().enumerate() {
        let slot = plan.ends(row.links[0])[0] as usize;
        let fits = row.stride == 1 && row.law.linear && row.law.mem == 0;
        if !fits || !added[slot..=slot + row.links.len()].iter().all(|a| a.lets(i)) {
            continue;
        }
        if row.links.iter().any(|l| heard.contains(l)) {
            continue;
        }
        let classes = &mut classes[slot..=slot + row.links.len()];
        let class = classes.iter().flatten().next().copied().unwrap_or(Class::Free);
        if classes.iter().flatten().any(|c| *c != class) {
            continue;
        }
        row.integrate = match class {
            Class::Held => continue,
            Class::Full => Integrate::Cel,
            Class::Free => Integrate::Mas,
        };
        classes.fill(Some(class));
    }
}

/// What is changed: the list of forces, that of integration, and where links stand in the first.
pub struct Passes<'a> {
    /// forces; those of fused rows come to stand last
    pub forces: &'a mut Vec<Op>,
    /// integration
    pub moves: &'a mut Vec<Op>,
    /// modules by name
    pub symbols: &'a mut [Symbol],
}

/// Fuses what is marked; returns how many of the last forces no tick runs by themselves.
pub fn fuse(passes: &mut Passes) -> usize {
    let fused: Vec<bool> = passes.forces.iter().map(|op| op.form.integrate != Integrate::No).collect();
    let mut rows: Vec<Op> = passes.forces.iter().filter(|op| op.form.integrate != Integrate::No).copied().collect();
    rows.sort_by_key(|op| op.mat);
    let mut rows = rows.into_iter().peekable();
    let mut moves = Vec::with_capacity(passes.moves.len());
    // both stand in the order of their masses
    for stretch in passes.moves.drain(..) {
        let (mut at, end) = (stretch.mat, stretch.mat + stretch.n);
        let part = |from: usize, to: usize| (to > from).then(|| Op { mat: from, n: to - from, ..stretch });
        while let Some(op) = rows.next_if(|op| op.mat < end) {
            let Some(law) = op.law else { continue };
            let form = Form { stride: 1, ..op.form };
            moves.extend(part(at, op.mat));
            moves.push(Op { kernel: (law.kernel)(form), form, tap: 1, ..op });
            at = op.mat + op.n + 1;
        }
        moves.extend(part(at, end));
    }
    *passes.moves = moves;
    let mut order: Vec<usize> = (0..fused.len()).collect();
    order.sort_by_key(|i| fused[*i]);
    let as_listed = |op: Op| Op { form: Form { integrate: Integrate::No, folded: false, ..op.form }, ..op };
    *passes.forces = order.iter().map(|i| as_listed(passes.forces[*i])).collect();
    let mut place = alloc::vec![0; order.len()];
    for (now, was) in order.iter().enumerate() {
        place[*was] = now as u32;
    }
    for s in passes.symbols.iter_mut() {
        if let Location::Lia(op, _) = &mut s.location {
            *op = place[*op as usize];
        }
    }
    fused.iter().filter(|f| **f).count()
}

/// What is added to the force on a slot.
#[derive(Clone, Copy, Default)]
struct Added {
    /// the batch of links that adds first
    first: Option<usize>,
    /// numbers that others add behind it
    behind: usize,
    /// somebody reads the sum, or adds before links or in a way of its own
    whole: bool,
}

impl Added {
    /// One number more, by batch `of`.
    fn add(&mut self, of: usize) {
        self.behind += usize::from(*self.first.get_or_insert(of) != of);
    }

    /// True where batch `of` sums first, and at most one number comes behind it.
    fn lets(&self, of: usize) -> bool {
        !self.whole && self.first == Some(of) && self.behind <= 1
    }
}

/// The same for each slot.
fn added(plan: &Plan, batches: &[Batch]) -> Vec<Added> {
    let net = plan.net;
    let mut all = alloc::vec![Added::default(); plan.coef_slots()];
    let whole = |all: &mut Vec<Added>, slot: u32, axes: usize| {
        all.iter_mut().skip(slot as usize).take(axes).for_each(|a| a.whole = true);
    };
    for (i, batch) in batches.iter().enumerate() {
        let shape = plan.shape(batch.links[0], batch.law);
        for l in &batch.links {
            let node = &net.lias[*l as usize];
            if shape.measure == MeasureKind::Line && shape.onto.is_none() && node.sets.is_none() {
                plan.ends(*l).into_iter().for_each(|slot| all[slot as usize].add(i));
            } else {
                node.all_ends().for_each(|end| whole(&mut all, plan.at(end), 3));
            }
        }
    }
    for (p, slot) in net.points.iter().zip(&plan.point).filter(|(_, slot)| **slot != u32::MAX) {
        let family = &net.families[&p.family];
        // where nothing touches the point it gives nothing
        let touched = all[*slot as usize].first.is_some() || all[*slot as usize].whole;
        for m in &family.nodes {
            let node = &mut all[plan.slot[*m as usize] as usize];
            node.whole |= p.shape.is_some();
            node.behind += usize::from(touched);
        }
    }
    let mats = net.mats.iter().zip(&plan.slot).filter(|(_, slot)| **slot != u32::MAX);
    for (m, slot) in mats {
        let weighed = !m.is_fixed() && net.medium(m).gravity.iter().any(|g| *g != 0.0);
        if weighed || matches!(m.role, MatRole::Port(..)) {
            whole(&mut all, *slot, m.slots() as usize);
        }
    }
    let read = net.outs.iter().filter_map(|o| match o.tap {
        OutputTap::ForceOn(e) => plan.alive(e, o.axis),
        _ => None,
    });
    let pushed = net.pushes.iter().filter_map(|p| plan.alive(p.end, p.axis));
    let junctions = net.lines.iter().filter(|l| l.tuned.is_some()).flat_map(LineNode::junctions);
    let junctions = junctions.filter_map(|m| plan.alive(End::Mat(m), 0));
    let singles: Vec<u32> = read.chain(pushed).chain(junctions).collect();
    for slot in singles {
        whole(&mut all, slot, 1);
    }
    all
}
