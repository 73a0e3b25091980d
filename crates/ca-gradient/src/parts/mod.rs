//! Divides a tick of a scene into parts for reverse mode and for derivatives by the passes of the scene.
//!
//! There are three kinds of links:
//!
//! - Linear links on a line act on derivatives as on positions and are their own transposes. The passes of the scene
//!   run them forwards and backwards, in any layout.
//! - All other links are evaluated one by one over dual numbers, each by the kernel of its law.
//! - Links whose force depends on the sum of the others come last in a tick and first on the way back. Those that are
//!   solved together are evaluated as one.
//!
//! Any other pass is refused by name; forward mode over dual numbers does not divide a tick.

pub mod link_in_scene;
pub mod numbers;
pub mod outputs;
pub mod record;
pub mod rows;
pub mod single_link;
pub mod small_passes;

use crate::error::Error;
use ca_core::internal::op::layout::{MeasureKind, Tap};
use ca_core::internal::op::{Integrate, Op, SolveStage};
use ca_core::{Law, Scene};
use single_link::slots;

pub struct Parts {
    /// Linear links whose forces are summed: indices into [`Passes::forces`], with the basis of their law.
    pub linear: Vec<(usize, Basis)>,
    /// Linear implicit links, as indices into [`Passes::forces`], and the passes that solve for them.
    pub implicit: Vec<usize>,
    pub solves: Vec<usize>,
    /// Linear links of rows that integrate: indices into [`Passes::moves`], with the basis of their law.
    pub rows: Vec<(usize, Basis)>,
    /// Links evaluated one by one.
    pub links: Vec<Link>,
    /// Links between all pairs of two sets, as indices into [`Passes::forces`].
    pub sets: Vec<usize>,
    /// Links that depend on the sum of the forces.
    pub last: Vec<Link>,
    /// Slots moved by a port, moving points, and masses that go by their modes.
    pub held: Vec<usize>,
    /// Taps of outputs that read forces.
    pub force_taps: Vec<Tap>,
    /// Coefficients driven by ports, ascending: indices into [`State::coef`](ca_core::State::coef).
    pub driven: Vec<usize>,
    /// Passes of weight, as indices into [`Passes::forces`].
    pub weights: Vec<usize>,
    /// Passes that read from modes and give to them: indices into [`Passes::reads`] and [`Passes::forces`].
    pub modal: Option<[usize; 2]>,
    /// Slots whose sum of forces is read by an output or by a link of `last`.
    pub summed: Vec<usize>,
}

/// Link evaluated alone, or several links solved together.
pub struct Link {
    /// Index into [`Passes::forces`] and index in that pass, for each link in the order of the tick.
    pub members: Vec<(usize, usize)>,
    /// Slots of its ends: port by port, first ends first; ascending if several links are solved together.
    pub slots: Vec<usize>,
    /// The law is one of those solved together, even if this link is the only one.
    pub together: bool,
}

impl Link {
    /// Index into [`Passes::forces`] of its first pass.
    pub fn op(&self) -> usize {
        self.members[0].0
    }
}

/// Linear law F = Σ c (α e + β w): α and β of each coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis(pub Vec<[f64; 2]>);

impl Basis {
    /// Returns the basis of a law, if it is linear in its coefficients too.
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

    /// Basis of an implicit link at the current tick; its third coefficient acts on the motion to come.
    pub fn implicit() -> Basis {
        Basis(vec![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    }

    /// Returns the slopes of the force against elongation and its change.
    pub fn slopes(&self, coef: impl Fn(usize) -> f64) -> [f64; 2] {
        let sum = |which: usize| self.0.iter().enumerate().map(|(k, of)| coef(k) * of[which]).sum();
        [sum(0), sum(1)]
    }
}

/// Returns the basis of the law of a batch of links on a line, if it is linear.
fn basis(op: &Op) -> Option<Basis> {
    let law = op.law.filter(|law| law.linear && law.mem == 0 && matches!(law.stage, SolveStage::Explicit))?;
    (op.form.onto.is_none() && op.form.measure == MeasureKind::Line && !law.implicit).then(|| Basis::of(law))?
}

/// Error for a scene without reverse mode.
pub fn no(what: &str) -> Error {
    Error::refused(format!("no reverse mode for this scene: {what}; use forward mode"))
}

/// Error for a pass that reverse mode does not support.
pub fn unknown(op: &Op) -> Error {
    no(&format!("it has the pass `{}`", op.name()))
}

/// Range of the coefficients of a pass of links; a set has one row.
fn coefficients(op: &Op) -> Option<std::ops::Range<usize>> {
    let n = if op.form.set { 1 } else { op.n };
    op.law.map(|law| op.coef..op.coef + law.coefs * n)
}

impl Parts {
    /// Returns the parts of a scene, or an error that names an unsupported pass.
    pub fn of(scene: &Scene) -> Result<Parts, Error> {
        let pass = unknown;
        if scene.oversample() > 1 {
            return Err(no("it has several ticks per sample"));
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
            force_taps: scene
                .layout
                .out
                .outputs
                .iter()
                .map(|o| o.tap)
                .filter(|t| !matches!(t, Tap::Position(_)))
                .collect(),
            summed: Vec::new(),
        };
        let driven = scene.layout.ports.driven.iter().flat_map(|d| &d.places);
        parts.driven = driven.map(|place| scene.live.coefs[*place as usize] as usize).collect();
        parts.driven.sort_unstable();
        parts.driven.dedup();
        let of_links: Vec<std::ops::Range<usize>> = scene.passes.summed().iter().filter_map(coefficients).collect();
        if parts.driven.iter().any(|c| !of_links.iter().any(|r| r.contains(c))) {
            return Err(no("a port drives a number that does not belong to a link"));
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
            // the weights of a moving point may change from tick to tick
            let between = |m: &usize| points.contains(m);
            let at_points = (0..op.n).any(|i| slots(scene, op, i).iter().any(between));
            // a linear link is its own transpose only while it is constant
            let changes = coefficients(op).is_some_and(|r| parts.driven.iter().any(|c| r.contains(c)));
            if law.implicit {
                // implicit links that hold a port or are tapped are completed after the solution
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
            // an unused place in a row has both ends at one slot
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
        // sorted, since `Record::play` stores what they all read before the first of them runs
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
        // rows that integrate do not store the sum of forces
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

/// Joins links solved together that share a slot which forces can move (`moves` nonzero).
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

/// Index of a number, stored as its value in a scene whose numbers are replaced by their indices.
pub fn number(v: f64) -> usize {
    v as usize
}
