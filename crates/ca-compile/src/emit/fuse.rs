//! Fuse: rows of linear links go into the pass that integrates their masses, where nothing tells the difference.
//!
//! The fused pass sums (Fᵢ − Fᵢ₋₁) + f, where f is what others gave ([`ca_core::op::fused`]). Decides that the bits of a
//! scene are those of its list of passes: a row is fused only where no other pass adds to its masses before it, and at
//! most one number is added behind it, since then both sums are the same. And only where nobody reads the whole force on
//! one of its masses, which is then known nowhere: the ledger, an output of force, a link that is solved behind the others.

use crate::net::Pruned;
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::layout::{Layout, MeasureKind, Tap};
use ca_core::op::{Op, fused, pass};
use ca_core::scene::{Location, Symbol};

/// What is changed: the list of forces, that of integration, and where links stand in the first.
pub struct Passes<'a> {
    /// forces; those of fused rows come to stand last
    pub forces: &'a mut Vec<Op>,
    /// integration
    pub moves: &'a mut Vec<Op>,
    /// modules by name
    pub symbols: &'a mut [Symbol],
}

/// Fuses what can be; returns how many of the last forces no tick runs by themselves.
pub fn fuse(net: &Pruned, options: &Options, layout: &Layout, passes: &mut Passes) -> usize {
    let late = passes.forces.iter().any(|op| op.law.is_some_and(|l| l.implicit || l.is_staged()));
    let whole = layout.ledger.is_some() || layout.implicit.is_some() || late || net.as_milib;
    if options.kernel != KernelClass::Fast || whole || net.is_composed() {
        return 0;
    }
    let touched = touched(layout, passes.forces);
    let mut fused = alloc::vec![false; passes.forces.len()];
    let mut moves = Vec::with_capacity(passes.moves.len());
    for stretch in passes.moves.drain(..) {
        let Some(own) = own(&stretch) else {
            moves.push(stretch);
            continue;
        };
        let masses = stretch.mat..stretch.mat + stretch.n;
        let mut rows: Vec<(usize, Op)> = Vec::new();
        for (i, op) in passes.forces.iter().enumerate() {
            let inside = masses.contains(&op.mat) && op.mat + op.n < masses.end;
            let row = op.form.stride == 1 && !op.form.offset && !op.form.tap;
            let Some(law) = op.law.filter(|_| inside && row) else { continue };
            let alone = touched[op.mat..=op.mat + op.n].iter().all(|t| t.lets(i));
            let Some((name, kernel)) = fused::kernel(law, own).filter(|_| alone) else { continue };
            rows.push((
                i,
                Op { form: op.form, mat: op.mat, coef: op.coef, first: op.first, ..Op::pass(name, kernel, op.n) },
            ));
        }
        rows.sort_by_key(|(_, row)| row.mat);
        let mut at = masses.start;
        let part = |from: usize, to: usize| (to > from).then(|| Op { mat: from, n: to - from, ..stretch });
        for (i, row) in rows {
            moves.extend(part(at, row.mat));
            at = row.mat + row.n + 1;
            moves.push(row);
            fused[i] = true;
        }
        moves.extend(part(at, masses.end));
    }
    *passes.moves = moves;
    let mut order: Vec<usize> = (0..fused.len()).collect();
    order.sort_by_key(|i| fused[*i]);
    *passes.forces = order.iter().map(|i| passes.forces[*i]).collect();
    let mut place = alloc::vec![0; order.len()];
    order.iter().enumerate().for_each(|(now, was)| place[*was] = now as u32);
    for s in passes.symbols.iter_mut() {
        if let Location::Lia(op, _) = &mut s.location {
            *op = place[*op as usize];
        }
    }
    fused.iter().filter(|f| **f).count()
}

/// Whether the masses of a pass have springs and dampers of their own, if it integrates.
fn own(op: &Op) -> Option<bool> {
    let is = |kernel: ca_core::op::Kernel| core::ptr::fn_addr_eq(op.kernel, kernel);
    match () {
        () if is(pass::integrate_free) => Some(false),
        () if is(pass::integrate_full) => Some(true),
        () => None,
    }
}

/// Who adds to the force on a slot, or reads it.
#[derive(Clone, Copy, Default)]
struct Touched {
    /// the first pass that adds, and the last
    first: usize,
    last: usize,
    /// numbers that are added behind those of the first
    behind: usize,
    any: bool,
    /// somebody reads the sum, or adds in a way of its own
    read: bool,
}

impl Touched {
    /// One number more, by pass `op`.
    fn add(&mut self, op: usize) {
        if !self.any {
            (self.any, self.first) = (true, op);
        } else if op != self.first {
            self.behind += 1;
        }
        self.last = op;
    }

    /// True where pass `op` sums first, and at most one number comes behind it.
    fn lets(&self, op: usize) -> bool {
        !self.read && self.first == op && self.behind <= 1
    }
}

/// For each slot, who touches its force.
fn touched(layout: &Layout, forces: &[Op]) -> Vec<Touched> {
    let mut all = alloc::vec![Touched::default(); layout.n_mat];
    let read = |all: &mut [Touched], slots: core::ops::Range<usize>| {
        for t in all.iter_mut().take(slots.end).skip(slots.start) {
            t.read = true;
        }
    };
    for (i, op) in forces.iter().enumerate() {
        if op.law.is_some() {
            let line = op.form.measure == MeasureKind::Line && op.form.onto.is_none() && !op.form.set;
            let width = if line { 1 } else { 3 };
            for end in layout.ends[op.first..][..op.n].iter().flatten() {
                let at = *end as usize;
                if line { all[at].add(i) } else { read(&mut all, at..at + width) }
            }
            continue;
        }
        match op.name {
            "ENF" => layout.enf.iter().for_each(|p| all[p.mat as usize].add(i)),
            "weight" => layout.weighed.iter().for_each(|m| all[*m as usize].add(i)),
            "points back" => {
                for p in &layout.moving_points {
                    let nodes = &layout.nodes[p.first as usize..][..(p.size[0] * p.size[1]) as usize];
                    for m in nodes {
                        all[*m as usize].add(i);
                    }
                }
            }
            _ => {}
        }
    }
    layout.onto.iter().flatten().for_each(|m| read(&mut all, *m as usize..*m as usize + 3));
    for set in &layout.pair_sets {
        set.members.iter().for_each(|m| read(&mut all, *m as usize..*m as usize + 3));
    }
    layout.waves.junctions.iter().for_each(|j| read(&mut all, j.mat as usize..j.mat as usize + 1));
    for m in &layout.modal {
        read(&mut all, m.first as usize..(m.first + m.n) as usize);
    }
    let ports = layout.enx.iter().chain(&layout.tgr).map(|p| p.mat);
    let heard = layout.outputs.iter().filter_map(|o| if let Tap::ForceOn(m) = o.tap { Some(m) } else { None });
    ports.chain(heard).for_each(|m| all[m as usize].read = true);
    all
}
