//! Verifies batches of links: the ranges of a pass or an account, and their ends.

use super::{Verified, block, each, ensure, in_bounds};
use crate::op::layout::{Account, Layout, MeasureKind, Ports, Row};
use crate::op::{Band, Form, Hub, Integrate, Law, Op};
use crate::state::Fold;

/// Maximum number of passes over each link in one tick: a sample of several ticks lists them again, a tick of `pefrl` four times.
const PASSES: usize = 64;

/// Number of links that passes may still process. It limits the time of a tick by the length of a scene.
pub(super) struct Work(usize);

impl Work {
    pub(super) fn of(l: &Layout) -> Work {
        Work(l.counts.n_lia.saturating_mul(PASSES))
    }

    fn take(&mut self, n: usize) -> Verified {
        self.0 = self.0.checked_sub(n).ok_or(super::Wrong("passes run over the same links too often"))?;
        Ok(())
    }
}

struct Batch<'a> {
    law: &'a Law,
    ports: Ports,
    n: usize,
    first: usize,
    coef: usize,
    mem: usize,
}

impl Batch<'_> {
    fn verify(&self, l: &Layout, work: &mut Work) -> Verified {
        let Batch { law, ports, n, first, coef, mem } = *self;
        work.take(n)?;
        ensure(in_bounds(first, n, l.counts.n_lia), "a pass runs over links that do not exist")?;
        ensure(block(coef, law.coefs, n, l.counts.n_coef), "links use coefficients that do not exist")?;
        ensure(block(mem, law.mem, n, l.counts.n_mem), "links use memory that does not exist")?;
        let ends = &l.links.ends[first..first + n];
        port(ports.measure, ends, ports.reach, l)?;
        if let Some((measure, first, reach)) = ports.onto {
            ensure(in_bounds(first, n, l.links.onto.len()), "the second port of a quadripole is missing")?;
            port(measure, &l.links.onto[first..first + n], reach, l)?;
        }
        ensure(
            ports.pair_set.is_none_or(|set| set < l.links.pair_sets.len()),
            "a batch joins a set that does not exist",
        )
    }
}

fn port(measure: MeasureKind, ends: &[[u32; 2]], reach: usize, l: &Layout) -> Verified {
    const BEYOND: &str = "a link has an end beyond the masses";
    if measure == MeasureKind::Line {
        return ensure(each(ends.as_flattened(), l.counts.n_mat), BEYOND);
    }
    let n = ends.len();
    ensure(in_bounds(reach, n, l.links.reach.len()), "the distance at rest of a link in space is missing")?;
    let rows = l.links.rows[reach..reach + n].iter().zip(ends).enumerate();
    // in a row, the numbers of all points are read from its first ends on
    let fits = |(i, (row, ends)): (usize, (&i32, &[u32; 2]))| {
        let links = usize::try_from(*row).unwrap_or(0).clamp(1, n - i);
        ends.iter().all(|end| block(*end as usize, 3, links, l.counts.n_mat))
    };
    ensure(rows.into_iter().all(fits), BEYOND)
}

fn members(ports: &Ports, l: &Layout) -> usize {
    ports.pair_set.and_then(|set| l.links.pair_sets.get(set)).map_or(0, |set| set.members.len())
}

/// Verifies a pass of links of `law`, whose kernel was chosen by `form`.
pub(super) fn pass(op: &Op, law: &Law, form: Form, l: &Layout, work: &mut Work) -> Verified {
    let &Op { ports, n, first, mat, coef, mem, tap, .. } = op;
    Batch { law, ports, n, first, coef, mem }.verify(l, work)?;
    let measured = form.measure == ports.measure && form.onto == ports.onto.map(|onto| onto.0);
    ensure(measured, "a pass of links measures in two ways")?;
    if form.set {
        let forces = 3usize.saturating_mul(members(&ports, l));
        ensure(n == 1 && law.mem == 0 && ports.pair_set.is_some(), "the set of a pass is missing")?;
        return ensure(!form.tap || in_bounds(tap, forces, l.counts.n_tap), "a set is beyond the forces");
    }
    ensure(ports.pair_set.is_none(), "a pass of links has a set")?;
    if form.hub != Hub::None {
        let [a, b] = l.links.ends.get(first).map_or([u32::MAX; 2], |ends| *ends).map(|m| m as usize);
        let row = if form.hub == Hub::First { b } else { a };
        ensure(n > 0 && in_bounds(row, n, l.counts.n_mat), "a fan of links is beyond the masses")?;
    }
    if form.integrate != Integrate::No {
        let fits = if form.folded { folded(op, law, form, l) } else { fused(op, l) };
        return ensure(fits, "a row that is integrated is beyond the masses, coefficients or forces");
    }
    if form.stride > 0 {
        let second = mat.checked_add(form.stride);
        let row = in_bounds(mat, n, l.counts.n_mat) && second.is_some_and(|b| in_bounds(b, n, l.counts.n_mat));
        ensure(row && in_bounds(tap, n, l.counts.n_tap), "a row of links is beyond the masses or forces")?;
    }
    ensure(!form.tap || in_bounds(tap, n, l.counts.n_tap), "links are beyond the forces")
}

/// Returns true if the forces and masses of an integrated row exist; it has one mass more than links.
fn fused(op: &Op, l: &Layout) -> bool {
    let masses = op.n.checked_add(1);
    let forces =
        op.n.checked_add(2).zip(op.tap.checked_sub(1)).is_some_and(|(n, first)| in_bounds(first, n, l.counts.n_tap));
    // each link joins a mass and the next
    op.form.stride == 1 && forces && masses.is_some_and(|n| in_bounds(op.mat, n, l.counts.n_mat))
}

/// Returns true if a folded row or mesh consists of whole vectors of masses, links and coefficients.
fn folded(op: &Op, law: &Law, form: Form, l: &Layout) -> bool {
    let (n, steps) = (op.n, op.n / Fold::LANES);
    let whole = steps >= 2 && n.is_multiple_of(Fold::LANES) && in_bounds(op.mat, n, l.counts.n_mat) && law.mem == 0;
    let forces = match form.band {
        // a law without a vector form runs as a row
        Band::None => return whole && (law.wide || fused(op, l)),
        Band::Across => return false,
        Band::Along(width) => {
            let across = block(op.coef, 2 * law.coefs, n, l.counts.n_coef) && block(op.first, 2, n, l.counts.n_lia);
            (2..steps).contains(&width) && across && n <= l.counts.n_tap
        }
    };
    whole && law.wide && forces
}

pub(super) fn account(a: &Account, l: &Layout, work: &mut Work) -> Verified {
    let &Account { law, ports, n, first, coef, mem, tap, .. } = a;
    Batch { law, ports, n, first, coef, mem }.verify(l, work)?;
    if ports.pair_set.is_some() {
        let forces = 3usize.saturating_mul(members(&ports, l));
        return ensure(n > 0 && in_bounds(tap, forces, l.counts.n_tap), "an account of a set is beyond the forces");
    }
    ensure(a.linear || in_bounds(tap, n, l.counts.n_tap), "an account is beyond the forces")?;
    let [one, two] = a.rows;
    let row = |row: Row| row.ends.iter().all(|end| in_bounds(*end, row.len, l.counts.n_mat));
    let rows = one.len.checked_add(two.len).is_some_and(|all| all <= n);
    ensure(rows && row(one) && row(two), "an account has rows beyond the masses")
}
