//! Verifies the arrays of a layout whose entries are used as indices.

use super::{Verified, block, each, ensure, in_bounds, links};
use crate::numeric::ldl::Pattern;
use crate::op::layout::Counts;
use crate::op::layout::{
    CoordinateSource, Driven, ImplicitLinks, Layout, LedgerLayout, LinkForce, MovingPoint, OutputLink, SolvedModal,
    Tap, Termination, Waves,
};
use crate::op::output_links::COEFS;

/// Verifies a layout without its group and substeps. `inputs` and `live` count inputs and live coefficients.
pub(in super::super) fn layout(l: &Layout, inputs: usize, live: usize) -> Verified {
    let Counts { n_mat, n_lia, n_coef, n_mem, n_touch, n_tap, channels, n_out } = l.counts;
    ensure(l.rates.ratio > 0 && l.rates.frame > 0, "a gesture frame has 0 ticks")?;
    ensure(l.rates.sample_dt > 0.0 && l.rates.sample_dt.is_finite(), "the length of a sample is not above 0")?;
    ensure(block(0, 3, n_mat, n_coef), "masses use more coefficients than there are")?;
    ensure(l.places.rest.len() == n_mat, "masses and their rest positions differ in number")?;
    ensure([l.links.ends.len(), l.links.e0.len()] == [n_lia; 2], "links and their ends differ in number")?;
    ensure(l.links.rows.len() == l.links.reach.len(), "distances and their rows differ in number")?;
    let clusters = &l.links.clusters;
    ensure(clusters.is_empty() || clusters.len() == n_lia, "links and their clusters differ in number")?;
    let in_clusters = || clusters.iter().filter(|c| **c != u32::MAX);
    let all_in = clusters.is_empty() || in_clusters().count() == n_touch;
    ensure(all_in && in_clusters().all(|c| (*c as usize) < n_touch), "a cluster of links does not exist")?;
    ensure(n_touch <= n_lia, "more contacts than links are solved together")?;
    ensure(channels <= n_out, "there are more channels than outputs")?;
    for set in &l.links.pair_sets {
        let n = set.members.len();
        ensure(set.rows <= n && set.columns <= n, "a set of pairs has more rows or columns than members")?;
        ensure(
            set.members.iter().all(|m| in_bounds(*m as usize, 3, n_mat)),
            "a set of pairs has a member beyond the masses",
        )?;
    }
    ensure(each(&l.places.nodes, n_mat), "a node of a moving point is beyond the masses")?;
    ensure(
        l.places.moving_points.iter().all(|p| moving(p, l)),
        "a moving point is beyond the nodes, masses or coefficients",
    )?;
    let modal = l.places.modal.iter().all(|p| {
        let [mat, first, share, n] = [p.mat, p.first, p.share, p.n].map(|v| v as usize);
        mat < n_mat && in_bounds(first, n, n_mat) && in_bounds(share, n, l.places.shares.len())
    });
    ensure(modal, "a mass uses modes or shares that do not exist")?;
    let solved = l.places.solved_modal.iter().all(|h| {
        let [modal, mat, tap] = [h.modal, h.mat, h.tap].map(|v| v as usize);
        modal < l.places.modal.len() && mat < n_mat && in_bounds(tap, SolvedModal::TAPS, n_tap)
    });
    ensure(solved, "a mass that is solved by its modes does not exist")?;
    let coupled = l.places.modal_couplings.iter().all(|g| {
        let [first, n, numbers] = [g.first, g.n, g.numbers].map(|v| v as usize);
        n > 0 && in_bounds(first, n, l.places.solved_modal.len()) && block(numbers, n, n, l.places.couplings.len())
    });
    ensure(coupled, "masses are coupled by numbers that do not exist")?;
    let ports = l
        .ports
        .enx
        .iter()
        .chain(&l.ports.tgr)
        .map(|p| (p.input, p.mat))
        .chain(l.ports.enf.iter().map(|p| (p.input, p.mat)));
    let port = |(input, mat): (u32, u32)| (input as usize) < inputs && (mat as usize) < n_mat;
    ensure(ports.into_iter().all(port), "a port is beyond the inputs or masses")?;
    ensure(l.ports.driven.iter().all(|d| driven(d, inputs, live)), "a port drives coefficients that do not exist")?;
    waves(&l.waves, n_mat, n_mem)?;
    ensure(each(&l.weighed, n_mat), "a weight is beyond the masses")?;
    ensure(
        l.out.links.iter().all(|h| output_link(h, l)),
        "the link of an output is beyond the masses, coefficients or forces",
    )?;
    outputs(l)?;
    l.implicit.as_ref().map_or(Ok(()), |a| implicit(a, l))?;
    l.ledger.as_ref().map_or(Ok(()), |plan| ledger(plan, l))
}

fn moving(p: &MovingPoint, l: &Layout) -> bool {
    let [n, m] = p.size.map(|n| n as usize);
    let source = |at: &CoordinateSource| match at {
        CoordinateSource::Coef(c) => (*c as usize) < l.counts.n_coef,
        CoordinateSource::Mat(m) => (*m as usize) < l.counts.n_mat,
    };
    let cells = n >= 2 && m >= 1 && block(p.first as usize, n, m, l.places.nodes.len());
    cells && (p.mat as usize) < l.counts.n_mat && p.at.iter().all(source)
}

fn driven(d: &Driven, inputs: usize, live: usize) -> bool {
    let table = d.rows.checked_mul(d.places.len()) == Some(d.table.len());
    d.rows >= 2 && table && (d.input as usize) < inputs && each(&d.places, live)
}

fn waves(w: &Waves, n_mat: usize, n_mem: usize) -> Verified {
    ensure(in_bounds(w.first, w.len, n_mem), "waves are beyond the memory")?;
    let junctions = w.junctions.iter().all(|j| (j.mat as usize) < n_mat && in_bounds(j.memory, 3, n_mem));
    ensure(junctions, "a junction of a waveguide is beyond the masses or memory")?;
    let delays = w.delays.iter().all(|d| {
        // a ring is three longer if a loss follows, for the inputs of its taps
        let end = match d.end {
            Termination::Open | Termination::Rigid => d.len > 0,
            Termination::Lossy { memory, .. } => d.len > 3 && memory < n_mem,
        };
        let memory = d.from < n_mem && d.to < n_mem && in_bounds(d.first, d.len, n_mem);
        end && memory && d.junction < w.junctions.len()
    });
    ensure(delays, "a delay of a waveguide is beyond the memory or junctions, or too short")
}

fn output_link(h: &OutputLink, l: &Layout) -> bool {
    let [coef, step, coefs, tap] = [h.coef, h.step, h.coefs, h.tap].map(|v| v as usize);
    let last = coefs.saturating_sub(1).checked_mul(step).and_then(|more| more.checked_add(coef));
    let law = h.law.mem == 0 && coefs <= COEFS;
    law && last.is_some_and(|last| last < l.counts.n_coef) && tap < l.counts.n_tap && each(&h.ends, l.counts.n_mat)
}

fn outputs(l: &Layout) -> Verified {
    let tap = |tap: Tap| match tap {
        Tap::Position(m) | Tap::ForceOn(m) => (m as usize) < l.counts.n_mat,
        Tap::ForceOf(t) => (t as usize) < l.counts.n_tap,
    };
    let outputs = l.out.outputs.iter().all(|o| (o.channel as usize) < l.counts.n_out && tap(o.tap));
    ensure(outputs, "an output is beyond the channels, masses or forces")?;
    ensure(l.out.blockers.len() <= l.out.outputs.len(), "there are more high passes than outputs")?;
    let [motion, blocked] = l.out.of_motion;
    ensure(in_bounds(motion, blocked, l.out.outputs.len()), "more outputs measure motion than there are")?;
    let rows = l.out.output_rows.iter().all(|row| {
        let first = row.first.is_none_or(|first| in_bounds(first as usize, row.n as usize, l.counts.n_mat));
        (row.channel as usize) < l.counts.n_out && first
    });
    ensure(rows, "a row of outputs is beyond the channels or masses")
}

/// Returns true if the columns of a factor hold rising rows below their diagonal.
pub(super) fn pattern(p: &Pattern) -> bool {
    let n = p.size();
    let ends = p.columns.first() == Some(&0) && p.columns.last().is_some_and(|end| *end as usize == p.rows.len());
    let columns = p.columns.len() == n + 1 && p.columns.windows(2).all(|c| c[0] <= c[1]);
    let column = |j: usize| {
        let rows = &p.rows[p.columns[j] as usize..p.columns[j + 1] as usize];
        let first = rows.first().is_none_or(|row| *row as usize > j);
        first && rows.windows(2).all(|r| r[0] < r[1]) && rows.last().is_none_or(|row| (*row as usize) < n)
    };
    ends && columns && (0..n).all(column)
}

fn implicit(a: &ImplicitLinks, l: &Layout) -> Verified {
    ensure(pattern(&a.pattern), "the pattern of implicit links is not a factor")?;
    let places = a.places.len() == a.pattern.size() && each(&a.places, l.counts.n_mat);
    ensure(places, "an implicit link joins masses that do not exist")?;
    let numbers = a.pattern.numbers().checked_add(a.places.len());
    let numbers = numbers.is_some_and(|n| in_bounds(a.coef, n, l.counts.n_coef));
    ensure(numbers, "the factor of implicit links is beyond the coefficients")?;
    let tap = |tap: Option<u32>| tap.is_none_or(|tap| (tap as usize) < l.counts.n_tap);
    let force = |LinkForce { coef, tap: of, moving, fixed }: &LinkForce| {
        let moving = moving.iter().all(|(i, _)| (*i as usize) < a.places.len());
        let fixed = fixed.iter().all(|(i, _)| (*i as usize) < l.counts.n_mat);
        moving && fixed && each(coef, l.counts.n_coef) && tap(*of)
    };
    ensure(a.forces.iter().all(force), "the force of an implicit link uses numbers that do not exist")?;
    let pairs = a.pairs.iter().all(|pair| each(&pair.ends, l.counts.n_mat) && tap(pair.tap));
    ensure(pairs, "an implicit link joins masses that do not exist")
}

fn ledger(plan: &LedgerLayout, l: &Layout) -> Verified {
    ensure(
        in_bounds(plan.weight, l.weighed.len(), l.counts.n_coef),
        "a weight of the ledger is beyond the coefficients",
    )?;
    let mut work = links::Work::of(l);
    plan.accounts.iter().try_for_each(|account| links::account(account, l, &mut work))
}
