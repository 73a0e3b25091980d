//! Fuse: rows of linear links move into the pass that integrates their masses, if the bits stay the same.
//!
//! The fused pass sums (Fᵢ − Fᵢ₋₁) + f, where f is the sum of all other forces ([`Integrate`]). A row is therefore
//! fused only if no other pass adds to its masses before it, and at most one number is added after it. The total force
//! on its masses is then not stored, so nothing else may read it: no output of force, and no link that is solved after
//! the others. (The ledger reads it only at ports, which are not integrated.)

use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::pass_list::Class;
use crate::emit::rows::added::Added;
use crate::emit::rows::bands;
use crate::emit::rows::batch::Batch;
use crate::emit::rows::batch::can_fold;
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::internal::op::layout::Account;
use ca_core::internal::op::output_links::COEFS;
use ca_core::internal::op::{Band, Form, Integrate, Op};
use ca_core::internal::scene::symbols::SymbolsBuilder;

/// Marks the rows that integrate their masses. `classes` has the class of each slot; slots that do not move get the
/// class of the row.
pub fn mark(builder: &LayoutBuilder, options: &Options, classes: &mut [Option<Class>], batches: &mut [Batch]) {
    let net = builder.net;
    let staged = batches.iter().any(|b| b.law.implicit || !b.law.stage.is_explicit());
    if options.kernel != KernelClass::Fast || staged || net.as_milib || net.is_composed() {
        return;
    }
    let added = Added::new(builder, batches);
    let fits = |b: &Batch| b.stride > 0 && b.law.linear && b.law.mem == 0 && b.law.coefs <= COEFS;
    // A mesh is folded, which needs a law with vector kernels.
    let folds = |b: &Batch| b.law.wide && can_fold(net) && fits(b);
    let found = bands::meshes(builder, batches, &added, folds, |range| class_of(&classes[range]).is_some());
    for (mesh, of) in found {
        let classes = &mut classes[mesh.first as usize..][..mesh.slots as usize];
        let integrate = integrate(classes);
        for k in of {
            (batches[k].integrate, batches[k].mesh) = (integrate, Some(mesh));
        }
    }
    for (i, row) in batches.iter_mut().enumerate() {
        if row.mesh.is_some() || row.stride != 1 || !fits(row) {
            continue;
        }
        let slot = builder.ends(row.links[0])[0] as usize;
        let range = slot..slot + row.links.len() + 1;
        let begins = |slot: usize| added.begins(slot, |k| (k == i).then_some(0));
        // After the last MAT come moving points, which are not integrated.
        let Some(classes) = classes.get_mut(range.clone()) else { continue };
        if range.clone().all(begins) && class_of(classes).is_some() {
            row.integrate = integrate(classes);
        }
    }
}

/// Returns the common class of these masses, if there is one; slots that do not move fit any class.
fn class_of(classes: &[Option<Class>]) -> Option<Class> {
    let class = classes.iter().flatten().next().copied().unwrap_or(Class::Free);
    (class != Class::Held && classes.iter().flatten().all(|c| *c == class)).then_some(class)
}

/// Sets all slots to their common class, and returns the integration for it.
fn integrate(classes: &mut [Option<Class>]) -> Integrate {
    let class = class_of(classes);
    classes.fill(class);
    match class {
        Some(Class::Full) => Integrate::Cel,
        Some(Class::Free) => Integrate::Mas,
        Some(Class::Held) | None => Integrate::No,
    }
}

/// Lists changed by fusing.
pub struct Passes<'a> {
    /// Force passes; passes of fused rows move to the end.
    pub forces: &'a mut Vec<Op>,
    /// Integration passes.
    pub moves: &'a mut Vec<Op>,
    /// Modules by name.
    pub symbols: &'a mut SymbolsBuilder,
    /// Accounts of links in the ledger, if there is one.
    pub accounts: &'a mut [Account],
}

/// Fuses the marked rows. Returns how many of the last force passes the tick does not run separately.
pub fn fuse(passes: &mut Passes) -> usize {
    let fused: Vec<bool> = passes.forces.iter().map(|op| op.form.integrate != Integrate::No).collect();
    let mut rows: Vec<Op> = Vec::new();
    for op in passes.forces.iter().filter(|op| op.form.integrate != Integrate::No) {
        match rows.last_mut() {
            // Links across run in the pass of the links along.
            Some(along) if op.form.band == Band::Across => along.form.offset |= op.form.offset,
            _ => rows.push(*op),
        }
    }
    rows.sort_by_key(|op| op.mat);
    let mut rows = rows.into_iter().peekable();
    let mut moves = Vec::with_capacity(passes.moves.len());
    // Both are in the order of their masses.
    for stretch in passes.moves.drain(..) {
        let (mut at, end) = (stretch.mat, stretch.mat + stretch.n);
        let part = |from: usize, to: usize| (to > from).then(|| Op { mat: from, n: to - from, ..stretch });
        while let Some(op) = rows.next_if(|op| op.mat < end) {
            let Some(law) = op.law else { continue };
            let form = Form { stride: 1, ..op.form };
            moves.extend(part(at, op.mat));
            moves.push(Op { kernel: (law.fns.kernel)(form), form, tap: 1, ..op });
            // A folded row has as many links as masses.
            at = op.mat + op.n + usize::from(!form.folded);
        }
        moves.extend(part(at, end));
    }
    *passes.moves = moves;
    let mut order: Vec<usize> = (0..fused.len()).collect();
    order.sort_by_key(|i| fused[*i]);
    let as_listed =
        |op: Op| Op { form: Form { integrate: Integrate::No, folded: false, band: Band::None, ..op.form }, ..op };
    *passes.forces = order.iter().map(|i| as_listed(passes.forces[*i])).collect();
    let mut place = alloc::vec![0; order.len()];
    for (now, was) in order.iter().enumerate() {
        place[*was] = now as u32;
    }
    passes.symbols.renumber(&place);
    passes.accounts.iter_mut().for_each(|a| a.op = place[a.op] as usize);
    fused.iter().filter(|f| **f).count()
}
