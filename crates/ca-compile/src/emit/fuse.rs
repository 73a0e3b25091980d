//! Fuse: rows of linear links go into the pass that integrates their masses, where nothing tells the difference.
//!
//! The fused pass sums (Fᵢ − Fᵢ₋₁) + f, where f is what others gave ([`Integrate`]). Decides that the bits of a scene are
//! those of its list of passes: a row is fused only where no other pass adds to its masses before it, and at most one
//! number is added behind it, since then both sums are the same. And only where nobody reads the whole force on one of its
//! masses, which is then known nowhere: the ledger, an output of force, a link that is solved behind the others.

use crate::net::Pruned;
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::layout::{Layout, MeasureKind, Tap};
use ca_core::op::{Form, Integrate, Kernel, Op, pass};
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
    let staged = passes.forces.iter().any(|op| op.law.is_some_and(|l| l.implicit || l.is_staged()));
    let whole = layout.ledger.is_some() || staged || net.as_milib || net.is_composed();
    if options.kernel != KernelClass::Fast || whole {
        return 0;
    }
    let added = added(layout, passes.forces);
    let fits = |(i, op): &(usize, Op)| {
        let row = op.form.stride == 1 && !op.form.tap && op.law.is_some_and(|l| l.linear && l.mem == 0);
        row && added[op.mat..=op.mat + op.n].iter().all(|a| a.lets(*i))
    };
    let mut rows: Vec<(usize, Op)> = passes.forces.iter().copied().enumerate().filter(fits).collect();
    rows.sort_by_key(|(_, op)| op.mat);
    let mut rows = rows.into_iter().peekable();
    let mut fused = alloc::vec![false; passes.forces.len()];
    let mut moves = Vec::with_capacity(passes.moves.len());
    // both stand in the order of their masses
    for stretch in passes.moves.drain(..) {
        let integrate = integrate(stretch.kernel);
        let (mut at, end) = (stretch.mat, stretch.mat + stretch.n);
        let part = |from: usize, to: usize| (to > from).then(|| Op { mat: from, n: to - from, ..stretch });
        if integrate == Integrate::No {
            moves.push(stretch);
            continue;
        }
        while let Some((i, op)) = rows.next_if(|(_, op)| op.mat < end) {
            let Some(law) = op.law.filter(|_| op.mat >= at && op.mat + op.n < end) else { continue };
            let form = Form { integrate, ..op.form };
            moves.extend(part(at, op.mat));
            moves.push(Op { kernel: (law.kernel)(form), form, tap: 1, ..op });
            at = op.mat + op.n + 1;
            fused[i] = true;
        }
        moves.extend(part(at, end));
    }
    *passes.moves = moves;
    let mut order: Vec<usize> = (0..fused.len()).collect();
    order.sort_by_key(|i| fused[*i]);
    *passes.forces = order.iter().map(|i| passes.forces[*i]).collect();
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

/// What masses a pass integrates.
fn integrate(kernel: Kernel) -> Integrate {
    let is = |k: Kernel| core::ptr::fn_addr_eq(kernel, k);
    match () {
        () if is(pass::integrate_free) => Integrate::Mas,
        () if is(pass::integrate_full) => Integrate::Cel,
        () => Integrate::No,
    }
}

/// What is added to the force on a slot.
#[derive(Clone, Copy, Default)]
struct Added {
    /// the pass of links that adds first
    first: Option<usize>,
    /// numbers that others add behind it
    behind: usize,
    /// somebody reads the sum, or adds before links or in a way of its own
    whole: bool,
}

impl Added {
    /// One number more, by pass `op`.
    fn add(&mut self, op: usize) {
        self.behind += usize::from(*self.first.get_or_insert(op) != op);
    }

    /// True where pass `op` sums first, and at most one number comes behind it.
    fn lets(&self, op: usize) -> bool {
        !self.whole && self.first == Some(op) && self.behind <= 1
    }
}

/// The same for each slot.
fn added(layout: &Layout, forces: &[Op]) -> Vec<Added> {
    let mut all = alloc::vec![Added::default(); layout.n_mat];
    for (i, op) in forces.iter().enumerate().filter(|(_, op)| op.law.is_some()) {
        let line = op.form.measure == MeasureKind::Line && op.form.onto.is_none() && !op.form.set;
        for end in layout.ends[op.first..][..op.n].iter().flatten().map(|m| *m as usize) {
            if line {
                all[end].add(i);
            } else {
                // along up to three axes
                all.iter_mut().skip(end).take(3).for_each(|a| a.whole = true);
            }
        }
    }
    for p in &layout.moving_points {
        // where nothing touches the point it gives nothing
        let touched = all[p.mat as usize].first.is_some() || all[p.mat as usize].whole;
        for m in &layout.nodes[p.first as usize..][..(p.size[0] * p.size[1]) as usize] {
            all[*m as usize].behind += usize::from(touched);
        }
    }
    let in_space = layout.onto.iter().flatten().chain(layout.pair_sets.iter().flat_map(|set| &set.members));
    let in_space = in_space.flat_map(|m| *m..*m + 3);
    let modes = layout.modal.iter().flat_map(|m| m.first..m.first + m.n);
    let ports = layout.enx.iter().chain(&layout.tgr).map(|p| p.mat).chain(layout.enf.iter().map(|p| p.mat));
    let junctions = layout.waves.junctions.iter().map(|j| j.mat);
    let read = layout.outputs.iter().filter_map(|o| if let Tap::ForceOn(m) = o.tap { Some(m) } else { None });
    for m in in_space.chain(modes).chain(ports).chain(junctions).chain(read).chain(layout.weighed.iter().copied()) {
        if let Some(a) = all.get_mut(m as usize) {
            a.whole = true;
        }
    }
    all
}
