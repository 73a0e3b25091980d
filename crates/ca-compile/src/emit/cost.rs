//! Cost model: instructions per pass, as `fixed + each × modules`.
//!
//! Costs are AVX2 instructions as counted by callgrind, not nanoseconds, so that tests can check them on any machine.
//! The model ignores vector remainders, whether a contact is closed, and memory latency. `benches/counts/run` compares
//! it with measured counts; `PASSES=1 benches/counts/run` prints both per pass and is how the table is made.
//!
//! The compiler uses it to choose between forms that give the same bits: folded rows (`folds`), joined rows (`joins`),
//! fans (`fans`), merged stretches (`merges`). It does not choose which rows become runs, because the state hash of
//! existing takes depends on that order. A test below shows what the table would choose.

use ca_core::Scene;
use ca_core::internal::op::links::pair_set;
use ca_core::internal::op::{Band, Hub, Integrate, MeasureKind, Op, Pass};
use ca_core::internal::state::Fold;

/// Cost of a pass: `fixed` plus `each` per module; for links, plus `fixed_coef` and `each_coef` per coefficient of the
/// law.
#[derive(Clone, Copy)]
struct Price {
    fixed: f64,
    each: f64,
    fixed_coef: f64,
    each_coef: f64,
}

impl Price {
    const fn of_links([fixed, fixed_coef]: [f64; 2], [each, each_coef]: [f64; 2]) -> Price {
        Price { fixed, each, fixed_coef, each_coef }
    }

    const fn of(fixed: f64, each: f64) -> Price {
        Price { fixed, each, fixed_coef: 0.0, each_coef: 0.0 }
    }

    /// Returns the cost per module for a law with `coefs` coefficients.
    fn each(self, coefs: usize) -> f64 {
        self.each + self.each_coef * coefs as f64
    }

    /// Returns the cost of a pass of `n` modules for a law with `coefs` coefficients.
    fn at(self, n: usize, coefs: usize) -> f64 {
        self.fixed + self.fixed_coef * coefs as f64 + n as f64 * self.each(coefs)
    }
}

/// Links on a line, looked up one by one.
const GATHER: Price = Price::of_links([63.0, 9.0], [14.0, 4.0]);
/// Links from one slot to consecutive slots.
const FAN: Price = Price::of_links([70.0, 12.0], [7.0, 0.6]);
/// A run.
const RUN: Price = Price::of_links([240.0, 50.0], [3.6, 0.5]);
/// A run that integrates its masses in their order.
const FUSED: Price = Price::of_links([280.0, 0.0], [7.0, 8.0]);
/// The same, folded into eight stretches.
const FOLDED: Price = Price::of_links([150.0, 20.0], [3.9, 1.0]);
/// The same, with the links across a mesh.
const BAND: Price = Price::of_links([380.0, 60.0], [7.9, 2.0]);
/// Extra cost of a mass with its own spring and damper in the last three forms.
const OWN: f64 = 0.9;
/// Distances, one by one.
const RADIAL: Price = Price::of_links([130.0, 9.0], [76.0, 4.0]);
/// Distances, in blocks of vectors.
const BLOCKS: Price = Price::of_links([580.0, 10.0], [65.0, 0.5]);
/// Saving per link in the rows of a cloth.
const IN_ROWS: f64 = 23.0;
/// Smallest number of links for blocks.
const FEWEST: usize = 16;
/// A quadripole with a distance and a line port.
const ONTO: Price = Price::of_links([120.0, 10.0], [121.0, 4.0]);
/// All pairs of a set: per point; per pair listed as near, some of them measured (`LISTED`); and per pair tested when
/// the list is rebuilt (`TESTED`), for grains that move by a thousandth of their diameter per tick.
const PAIRS: Price = Price::of(140.0, 82.0);
const LISTED: f64 = 42.0;
const TESTED: f64 = 0.2;

/// Laws that are not a sum of products: cost of the force besides the coefficients, looked up one by one and in a run.
/// It is negative if a contact that is apart ends before its coefficients are read.
const LAWS: [(&str, f64, f64); 12] = [
    ("ATT", 0.0, 2.0),
    ("BOW coulomb", 0.0, 0.0),
    ("BOW piecewise", -11.0, -11.0),
    ("BOW smooth", 56.0, 99.0),
    ("BOW table", 100.0, 100.0),
    ("BUT", -7.0, 2.0),
    ("CUB", 2.0, 0.0),
    ("HRZ", -4.0, 25.0),
    ("LNL friction", 124.0, 124.0),
    ("LNL spring", 100.0, 99.0),
    ("PLK", 37.0, 37.0),
    ("POW", 33.0, 33.0),
];

/// Contacts of the method `stable`, each solved alone, while they press.
const STABLE: [(&str, Price); 2] = [("BUT stable", Price::of(80.0, 250.0)), ("HRZ stable", Price::of(95.0, 800.0))];

/// Implicit links: per mass, and per number beside the diagonal of their factor.
const IMPLICIT: Price = Price::of(145.0, 86.0);
const BESIDE: f64 = 26.0;

/// Passes other than links, by name.
const PASSES: [(&str, Price); 18] = [
    ("ENF", Price::of(41.0, 25.0)),
    ("ENX", Price::of(74.0, 31.0)),
    ("TGR in", Price::of(154.0, 18.3)),
    ("TGR out", Price::of(48.0, 10.2)),
    ("aim", Price::of(20.0, 145.0)),
    ("changes", Price::of(21.0, 0.0)),
    ("flush", Price::of(14.0, 0.01)),
    ("heard links", Price::of(60.0, 71.0)),
    ("high pass", Price::of(89.0, 45.0)),
    ("high pass of motion", Price::of(89.0, 45.0)),
    ("outputs of motion", Price::of(30.0, 12.0)),
    ("integrate CEL", INTEGRATE_CEL),
    ("integrate MAS", INTEGRATE_MAS),
    ("points", Price::of(40.0, 70.0)),
    ("points back", Price::of(30.0, 45.0)),
    ("waves in", Price::of(20.0, 61.0)),
    ("waves out", Price::of(20.0, 40.0)),
    ("weight", Price::of(32.0, 12.0)),
];

const INTEGRATE_CEL: Price = Price::of(125.0, 3.75);
const INTEGRATE_MAS: Price = Price::of(118.0, 8.0);
/// Smallest stretch that is integrated in vectors as a whole.
const LONG: usize = 48;
const INTEGRATE_LONG: Price = Price::of(215.0, 2.0);

/// Outputs of one position each, outputs that are summed, and outputs that are summed in lanes.
const POSITIONS: Price = Price::of(41.0, 14.0);
const OUTPUTS: Price = Price::of(100.0, 17.0);
const MANY_OUTPUTS: Price = Price::of(190.0, 1.9);

/// Overhead of a tick, and of a pass.
const TICK: f64 = 25.0;
const CALL: f64 = 5.0;

/// Pass that runs all passes again, for each tick between two samples.
const BETWEEN: &str = "ticks between";

/// Returns whether a row that integrates its masses is cheaper folded, although `ends` of links of other rows at its
/// masses are then looked up instead of being in a row.
pub(crate) fn folds(masses: usize, coefs: usize, ends: usize) -> bool {
    // The folded kernel has at least two vectors.
    if masses <= Fold::LANES {
        return false;
    }
    let more = (GATHER.each(coefs) - RUN.each(coefs)) / 2.0 * ends as f64;
    FOLDED.at(masses.next_multiple_of(Fold::LANES), coefs) + more < FUSED.at(masses - 1, coefs)
}

/// Returns whether a mesh is cheaper as one pass, although `ends` of links of other rows at its masses are then looked
/// up.
pub(crate) fn bands(nodes: usize, coefs: usize, ends: usize) -> bool {
    let more = (GATHER.each(coefs) - RUN.each(coefs)) / 2.0 * ends as f64;
    let nodes = nodes.next_multiple_of(Fold::LANES);
    BAND.at(nodes, coefs) + more < FUSED.at(nodes - 1, coefs) + RUN.at(nodes, coefs)
}

/// Returns whether two rows of a law are cheaper as one, with `joints` links between them.
pub(crate) fn joins(joints: usize, coefs: usize) -> bool {
    joints as f64 * RUN.each(coefs) < CALL + RUN.at(0, coefs)
}

/// Returns whether `n` links from one slot to a row are cheaper as a separate pass than among links that are looked up.
/// `cuts` is true if they follow some of these, whose pass is then divided.
pub(crate) fn fans(n: usize, coefs: usize, cuts: bool) -> bool {
    let more = if cuts { CALL + GATHER.at(0, coefs) } else { 0.0 };
    CALL + FAN.at(n, coefs) + more < n as f64 * GATHER.each(coefs)
}

/// Returns whether `n` MAS are cheaper in the pass of the adjacent CELs.
pub(crate) fn merges(n: usize) -> bool {
    let alone = if n >= LONG { INTEGRATE_LONG } else { INTEGRATE_MAS };
    n as f64 * INTEGRATE_CEL.each < CALL + alone.at(n, 0)
}

/// Returns the instructions of one pass; `None` if the table does not contain it.
#[must_use]
pub fn of_pass(scene: &Scene, op: &Op) -> Option<f64> {
    if op.law.is_some() {
        return links(scene, op);
    }
    if op.name() == BETWEEN {
        return Some(op.n as f64 * passes(scene, |op| op.name() != BETWEEN));
    }
    if let ("implicit", Some(links)) = (op.name(), &scene.layout.implicit) {
        let beside = links.pattern.numbers() - links.pattern.size();
        return Some(IMPLICIT.at(op.n, 0) + BESIDE * beside as f64);
    }
    let price = match op.name() {
        "integrate MAS" if op.n >= LONG => INTEGRATE_LONG,
        "outputs" if op.pass == Pass::Positions => POSITIONS,
        "outputs" if op.pass == Pass::ManyOutputs => MANY_OUTPUTS,
        "outputs" => OUTPUTS,
        name => PASSES.iter().find(|p| p.0 == name)?.1,
    };
    Some(price.at(op.n, 0))
}

/// Returns the instructions of a tick, without passes that the table does not contain.
#[must_use]
pub fn of_tick(scene: &Scene) -> f64 {
    TICK + passes(scene, |_| true)
}

fn passes(scene: &Scene, asked: impl Fn(&Op) -> bool) -> f64 {
    let lists = [&scene.passes.reads[..], scene.passes.summed(), &scene.passes.writes, &scene.passes.moves];
    let asked = lists.into_iter().flatten().filter(|op| asked(op));
    asked.filter_map(|op| Some(CALL + of_pass(scene, op)?)).sum()
}

fn links(scene: &Scene, op: &Op) -> Option<f64> {
    let (law, form, n) = (op.law?, op.form, op.n);
    let code = law.code.strip_prefix("LPR_").unwrap_or(law.code);
    if let Some((_, price)) = STABLE.iter().find(|s| s.0 == law.code) {
        return Some(price.at(n, 0));
    }
    let (one_by_one, in_a_row) = match LAWS.iter().find(|l| l.0 == code) {
        Some(l) => (l.1, l.2),
        None if law.linear => (0.0, 0.0),
        None => return None,
    };
    if let Some(set) = op.ports.pair_set {
        let (set, start) = (&scene.links.pair_sets[set], &scene.initial);
        let idle = (law.fns.idle)(start.coef.get(op.coef..op.coef + law.coefs)?);
        let [listed, measured] = pair_set::neighbours(set, &scene.places.rest, &start.x, idle);
        let near = match listed {
            // Contacts with the sense `inside` measure all pairs.
            0 if idle.1 < f64::INFINITY => RADIAL.each(law.coefs) * measured as f64,
            listed => LISTED * listed as f64 + TESTED * set.pairs() as f64,
        };
        return Some(PAIRS.at(set.members.len(), 0) + near);
    }
    let own = if form.integrate == Integrate::Cel { OWN * n as f64 } else { 0.0 };
    let blocks = form.measure == MeasureKind::Radial && form.onto.is_none() && n >= FEWEST && !law.contact;
    let in_rows = || scene.links.rows[op.ports.reach..][..n].iter().filter(|row| **row > 0).count();
    let less = if blocks { IN_ROWS * in_rows() as f64 } else { 0.0 };
    let (price, extra) = match (form.measure, form.onto) {
        (MeasureKind::Radial, Some(MeasureKind::Line)) => (ONTO, one_by_one),
        (MeasureKind::Radial, None) if blocks => (BLOCKS, one_by_one),
        (MeasureKind::Radial, None) => (RADIAL, one_by_one),
        (MeasureKind::Line, None) if form.hub != Hub::None => (FAN, 0.0),
        (MeasureKind::Line, None) if form.integrate == Integrate::No && form.stride == 0 => (GATHER, one_by_one),
        (MeasureKind::Line, None) if form.integrate == Integrate::No => (RUN, in_a_row),
        (MeasureKind::Line, None) if !form.folded => (FUSED, in_a_row),
        (MeasureKind::Line, None) if form.band == Band::None => (FOLDED, 0.0),
        (MeasureKind::Line, None) => (BAND, 0.0),
        _ => return None,
    };
    Some(price.at(n, law.coefs) + n as f64 * extra + own - less)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emit::rows::batches;
    use ca_core::internal::op::pass::MANY;

    /// Coefficients of RES and of REF.
    const LINEAR: [usize; 2] = [1, 2];

    /// The smallest size at which each form is chosen, from the counts at the time of the table.
    #[test]
    fn forms_are_chosen_from_the_sizes_at_which_they_cost_less() {
        let from = |chosen: &dyn Fn(usize) -> bool| (1..200).find(|n| (*n..200).all(chosen));
        for (coefs, alone, behind_others) in [(1, 9, 16), (2, 8, 14)] {
            assert_eq!(from(&|n| fans(n, coefs, false)), Some(alone));
            assert_eq!(from(&|n| fans(n, coefs, true)), Some(behind_others));
        }
        for coefs in LINEAR {
            assert_eq!(from(&|masses| folds(masses, coefs, 0)), Some(Fold::LANES + 1));
            // With many links of other rows at its masses, folding costs more.
            assert!(folds(400, coefs, 100) && !folds(400, coefs, 900));
            assert!(bands(400, coefs, 74) && !bands(400, coefs, 1500));
        }
        let longest = |joined: &dyn Fn(usize) -> bool| (1..200).take_while(|n| joined(*n)).last();
        assert_eq!(LINEAR.map(|coefs| longest(&|joints| joins(joints, coefs))), [Some(71), Some(74)]);
        assert_eq!(longest(&merges), Some(125));
    }

    /// This choice is made where the outputs are computed.
    #[test]
    fn outputs_are_summed_in_lanes_where_that_costs_less() {
        assert!(MANY_OUTPUTS.at(MANY, 0) < OUTPUTS.at(MANY, 0));
    }

    /// Rows become runs from another size on, which the order of state hashes fixes. Instructions are not everything:
    /// eleven links are faster as a run in nanoseconds, with more instructions.
    #[test]
    fn a_run_has_fewer_instructions_only_from_some_links_on() {
        let fewer = |coefs| (1..100).find(|n| RUN.at(*n, coefs) < GATHER.at(*n, coefs));
        assert_eq!(LINEAR.map(fewer), [Some(16), Some(15)]);
        for (coefs, n) in LINEAR.map(|coefs| (coefs, batches::SHORTEST_RUN)) {
            assert!(RUN.at(n, coefs) > GATHER.at(n, coefs));
        }
    }
}
