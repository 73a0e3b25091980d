//! Parts: what a tick of a scene is made of, as derivatives by its own passes and reverse mode take it.
//!
//! Decides for three kinds of links. Linear ones on a line make of derivatives what they make of places, and have transposes that
//! are themselves, so that the passes of the scene run them forwards and backwards, whatever their layout. All others are run one by one
//! over dual numbers, each by the kernel of its law alone. Those whose force depends on the sum of others come last in a tick, and first
//! on the way back; of these, such as are solved together are run as one. What is neither is refused, by the name of its pass; forward
//! mode over dual numbers has no such bounds.

pub mod alone;
pub mod numbers;
pub mod outputs;
pub mod placed;
pub mod record;
pub mod rows;
pub mod small;

use crate::error::Error;
use alone::slots;
use ca_core::internal::op::layout::{MeasureKind, Tap};
use ca_core::internal::op::{Integrate, Op, SolveStage};
use ca_core::{Law, Scene};

/// The parts of a tick.
pub struct Parts {
    /// linear links whose forces are summed, as indices into [`Passes::forces`], each with what its law is made of
    pub linear: Vec<(usize, Basis)>,
    /// linear links that are solved for with the motion to come, as indices into [`Passes::forces`], and the passes that do
    pub implicit: Vec<usize>,
    pub solves: Vec<usize>,
    /// linear links of rows that integrate, as indices into [`Passes::moves`]
    pub rows: Vec<(usize, Basis)>,
    /// links one by one
    pub links: Vec<Link>,
    /// links between all pairs of two sets, as indices into [`Passes::forces`]
    pub sets: Vec<usize>,
    /// those that go by the sum of the forces
    pub last: Vec<Link>,
    /// slots that a port moves, that stand between others or go by modes
    pub held: Vec<usize>,
    /// outputs that hear forces, by their taps
    pub hears: Vec<Tap>,
    /// coefficients that ports drive, rising: indices into [`State::coef`](ca_core::State::coef)
    pub driven: Vec<usize>,
    /// passes of weight, as indices into [`Passes::forces`]
    pub weights: Vec<usize>,
    /// those that give to modes and take from them, as indices into [`Passes::reads`] and [`Passes::forces`]
    pub modal: Option<[usize; 2]>,
    /// slots of which the sum of the forces is heard, or a link of `last` goes by it
    pub summed: Vec<usize>,
}

/// A link that is run alone, or some that are solved together.
pub struct Link {
    /// index into [`Passes::forces`], and which one of it; of those that are solved together each, in the order of the tick
    pub members: Vec<(usize, usize)>,
    /// slots of its ends, port by port, first ends first; of those that are solved together all, rising
    pub slots: Vec<usize>,
    /// it is solved with others, or would be
    pub together: bool,
}

impl Link {
    /// The pass that is the first to run it, as an index into [`Passes::forces`].
    pub fn op(&self) -> usize {
        self.members[0].0
    }
}

/// A linear law F = Σ c (α e + β w): α and β of each coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis(pub Vec<[f64; 2]>);

impl Basis {
    /// That of a law, if it is linear in its coefficients too.
    fn of(law: &Law) -> Option<Basis> {
        let force = |c: &[f64], e: f64, w: f64| (law.fns.force)(c, &mut [], &[], e, w);
        let one = |k: usize| {
            let mut c = vec![0.0; law.coefs];
            c[k] = 1.0;
            [force(&c, 1.0, 0.0), force(&c, 0.0, 1.0)]
        };
        let basis = Basis((0..law.coefs).map(one).collect());
        let c: Vec<f64> = (0..law.coefs).map(|k| 0.75 + 0.5 * k as f64).collect();
        let [by_e, by_w] = basis.slopes(|k| c[k]);
        (force(&c, 0.625, -0.375) == 0.625 * by_e - 0.375 * by_w).then_some(basis)
    }

    /// That of what an implicit link has at the tick; its third coefficient counts with the motion to come.
    pub fn implicit() -> Basis {
        Basis(vec![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    }

    /// The slopes of a link against elongation and its change, from its coefficients.
    pub fn slopes(&self, coef: impl Fn(usize) -> f64) -> [f64; 2] {
        let sum = |which: usize| self.0.iter().enumerate().map(|(k, of)| coef(k) * of[which]).sum();
        [sum(0), sum(1)]
    }
}

/// What the law of a batch of links on a line is made of, if it is linear.
fn basis(op: &Op) -> Option<Basis> {
    let law = op.law.filter(|law| law.linear && law.mem == 0 && matches!(law.stage, SolveStage::Explicit))?;
    (op.form.onto.is_none() && op.form.measure == MeasureKind::Line && !law.implicit).then(|| Basis::of(law))?
}

/// Why a scene has no reverse mode.
pub fn no(what: &str) -> Error {
    Error::refused(format!("no reverse mode of this scene: {what}; ask for forward mode"))
}

/// That it has a pass which reverse mode does not know.
pub fn unknown(op: &Op) -> Error {
    no(&format!("it has the pass `{}`", op.name()))
}

/// The coefficients of a pass of links; of a set one row.
fn coefficients(op: &Op) -> Option<std::ops::Range<usize>> {
    let n = if op.form.set { 1 } else { op.n };
    op.law.map(|law| op.coef..op.coef + law.coefs * n)
}

impl Parts {
    /// The parts of a scene, or the pass that reverse mode does not know.
    pub fn of(scene: &Scene) -> Result<Parts, Error> {
        let pass = unknown;
        if scene.oversample() > 1 {
            return Err(no("its samples have several ticks"));
        }
        if scene.rates.slow.is_some() {
            return Err(no("it has groups at the gesture rate"));
        }
        let known = |list: &[Op], names: &[&str]| {
            list.iter().find(|op| !names.contains(&op.name())).map_or(Ok(()), |op| Err(pass(op)))
        };
        known(&scene.passes.reads, &["ENX", "TGR in", "modal ports", "driven", "changes", "aim", "points"])?;
        let writes = ["heard links", "outputs", "outputs of motion", "high pass", "high pass of motion", "low pass"];
        known(&scene.passes.writes, &writes)?;
        let ports = scene.layout.ports.enx.iter().chain(&scene.layout.ports.tgr);
        let mut parts = Parts {
            linear: Vec::new(),
            rows: Vec::new(),
            links: Vec::new(),
            last: Vec::new(),
            held: ports
                .map(|p| p.mat)
                .chain(scene.layout.places.moving_points.iter().map(|p| p.mat))
                .chain(scene.layout.places.modal.iter().map(|p| p.mat))
                .map(|m| m as usize)
                .collect(),
            weights: Vec::new(),
            modal: None,
            implicit: Vec::new(),
            solves: Vec::new(),
            sets: Vec::new(),
            driven: Vec::new(),
            hears: scene.layout.out.outputs.iter().map(|o| o.tap).filter(|t| !matches!(t, Tap::Position(_))).collect(),
            summed: Vec::new(),
        };
        let driven = scene.layout.ports.driven.iter().flat_map(|d| &d.places);
        parts.driven = driven.map(|place| scene.live.coefs[*place as usize] as usize).collect();
        parts.driven.sort_unstable();
        parts.driven.dedup();
        let of_links: Vec<std::ops::Range<usize>> = scene.passes.summed().iter().filter_map(coefficients).collect();
        if parts.driven.iter().any(|c| !of_links.iter().any(|r| r.contains(c))) {
            return Err(no("a port drives a number of it that is of no link"));
        }
        let points: Vec<usize> = scene.layout.places.moving_points.iter().map(|p| p.mat as usize).collect();
        let mut together = Vec::new();
        for (k, op) in scene.passes.summed().iter().enumerate() {
            let Some(law) = op.law else {
                match op.name() {
                    "ENF" | "TGR out" | "points back" | "contacts" => {}
                    "weight" => parts.weights.push(k),
                    "modes" => {
                        parts.modal =
                            scene.passes.reads.iter().position(|op| op.name() == "modal ports").map(|read| [read, k]);
                    }
                    "implicit" | "implicit pairs" => parts.solves.push(k),
                    _ => return Err(pass(op)),
                }
                continue;
            };
            if op.form.set && op.form.tap {
                return Err(pass(op));
            }
            if op.form.set {
                if coefficients(op).is_some_and(|r| parts.driven.iter().any(|c| r.contains(c))) {
                    return Err(pass(op));
                }
                parts.sets.push(k);
                continue;
            }
            // of what stands between others the weights may change from tick to tick
            let between = |m: &usize| points.contains(m);
            let at_points = (0..op.n).any(|i| slots(scene, op, i).iter().any(between));
            // and what is linear is its own transpose only while it does not change
            let changes = coefficients(op).is_some_and(|r| parts.driven.iter().any(|c| r.contains(c)));
            if law.implicit {
                // what holds a port, or is heard, is completed behind the solution
                let known = scene.layout.implicit.as_ref().is_some_and(|i| i.forces.is_empty());
                if !known || changes || at_points || op.form.tap || op.form.measure != MeasureKind::Line {
                    return Err(pass(op));
                }
                parts.implicit.push(k);
                continue;
            }
            if let Some(basis) = basis(op).filter(|_| !at_points && !changes) {
                parts.linear.push((k, basis));
                continue;
            }
            let to = match law.stage {
                SolveStage::Explicit => &mut parts.links,
                SolveStage::Single(_) => &mut parts.last,
                SolveStage::Coupled(_) => &mut together,
            };
            // a place in a row that no link takes has one end
            let takes =
                |i: &usize| scene.layout.links.ends[op.first + i][0] != scene.layout.links.ends[op.first + i][1];
            let (late, coupled) = match law.stage {
                SolveStage::Explicit => (false, false),
                SolveStage::Single(_) => (true, false),
                SolveStage::Coupled(_) => (true, true),
            };
            let link = |i: usize| Link { members: vec![(k, i)], slots: slots(scene, op, i), together: coupled };
            to.extend((0..op.n).filter(takes).map(link));
            if late && (at_points || !scene.layout.places.modal_couplings.is_empty()) {
                return Err(pass(op));
            }
        }
        parts.last.extend(that_touch(together, &scene.initial.coef[2 * scene.layout.counts.n_mat..]));
        // each has what it reads kept before the first of them runs
        parts.last.sort_by_key(Link::op);
        for (k, op) in scene.passes.moves.iter().enumerate() {
            match (op.law, op.name()) {
                (Some(_), _) => parts.rows.push((k, basis(op).ok_or_else(|| pass(op))?)),
                (None, "integrate MAS" | "integrate CEL" | "flush") => {}
                (None, _) => return Err(pass(op)),
            }
        }
        let sums = scene
            .layout
            .out
            .outputs
            .iter()
            .filter_map(|o| if let Tap::ForceOn(m) = o.tap { Some(m as usize) } else { None });
        parts.summed = sums.chain(parts.last.iter().flat_map(|l| l.slots.iter().copied())).collect();
        parts.summed.sort_unstable();
        parts.summed.dedup();
        if let (Some(k), false) =
            (parts.implicit.first(), parts.summed.is_empty() && scene.layout.places.modal.is_empty())
        {
            return Err(pass(&scene.passes.forces[*k]));
        }
        // of rows that integrate, no such sum is there to be heard
        for (k, _) in &parts.rows {
            let op = &scene.passes.moves[*k];
            let masses = op.mat..op.mat + op.n + usize::from(!op.form.folded);
            debug_assert!(op.form.integrate != Integrate::No);
            if parts.summed.iter().any(|m| masses.contains(m)) {
                return Err(pass(op));
            }
        }
        Ok(parts)
    }
}

/// Links that are solved together, as one where they have places in common that `moves` says a force moves.
fn that_touch(links: Vec<Link>, moves: &[f64]) -> Vec<Link> {
    let mut all: Vec<Link> = Vec::new();
    for mut link in links {
        let touches = |other: &Link| other.slots.iter().any(|m| moves[*m] != 0.0 && link.slots.contains(m));
        let (with, apart): (Vec<Link>, Vec<Link>) = all.into_iter().partition(touches);
        for other in with {
            link.members.extend(other.members);
            link.slots.extend(other.slots);
        }
        link.members.sort_unstable();
        link.slots.sort_unstable();
        link.slots.dedup();
        all = apart;
        all.push(link);
    }
    all
}

/// The number that a place of an array has, in a scene whose numbers are replaced by their places among them.
pub fn number(v: f64) -> usize {
    v as usize
}
