//! Binds a scene over `f64` to another number type.
//!
//! The compiler makes scenes over `f64`. Binding rounds each number once to `R`, and gives each pass its kernel and
//! each law its functions over `R`. In single precision the start is computed anew; over dual numbers its values have
//! the bits of `f64`. The scene must be compiled for the precision of `R`, since vector kernels and folded rows are for
//! `f64` alone.

use super::{Before, Scene, start};
use crate::numeric::{Precision, Real, Table, VerletList};
use crate::op::energy::empty_ledger;
use crate::op::layout::{
    Account, AccountFns, DcBlocker, Delay, Driven, Enx, ImplicitLinks, Junction, Layout, LedgerLayout, LinkArrays,
    LinkForce, OutputArrays, OutputLink, Places, PortArrays, Rates, SlowGroup, Substeps, Termination, Waves,
};
use crate::op::{Band, Form, Integrate, Laws, Op};
use crate::scene::{Passes, identify};
use crate::state::{ActiveContacts, Cell, Ledger, LinkState, PortState, Ramps, SlowState, State};
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;

/// Why a scene cannot be bound to another number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unbound {
    /// the functions of the law with this code over this number type were not given
    Law(&'static str),
    /// points of a table coincide, or are out of range of the number type
    Table,
    /// the scene was compiled for another precision
    Kernels,
}

impl fmt::Display for Unbound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unbound::Law(code) => write!(f, "the law `{code}` exists in double precision only"),
            Unbound::Table => f.write_str("a table has points that coincide or are out of range in this precision"),
            Unbound::Kernels => f.write_str("the scene was compiled for double precision"),
        }
    }
}

impl core::error::Error for Unbound {}

impl Scene {
    /// Returns the same scene over `R`; `laws` gives the functions of its laws.
    ///
    /// # Errors
    /// [`Unbound`].
    pub fn bind<R: Real>(&self, laws: &Laws<R>) -> Result<Scene<R>, Unbound> {
        let layout = layout(&self.layout, laws)?;
        let [reads, forces, writes] =
            [&self.passes.reads, &self.passes.forces, &self.passes.writes].map(|list| ops(list, laws, listed));
        let (reads, forces, writes) = (reads?, forces?, writes?);
        let moves = ops(&self.passes.moves, laws, |form| form)?;
        let before = match &self.before {
            Some(b) => {
                Some(Before { start: b.start, state: state(&b.state, &layout), forces: ops(&b.forces, laws, listed)? })
            }
            None => None,
        };
        let mut initial = match &before {
            Some(b) if R::PRECISION == Precision::Single => start(&layout, &b.forces, b.start, b.state.clone()),
            _ => state(&self.initial, &layout),
        };
        initial.scene = identify(&layout, [&reads, &forces, &writes, &moves], &initial);
        let mut live = self.live.clone();
        live.scene = initial.scene;
        Ok(Scene {
            rate: self.rate,
            layout,
            passes: Passes { reads, forces, fused: self.passes.fused, writes, moves, sorted: self.passes.sorted },
            inputs: self.inputs.clone(),
            names: self.names.clone(),
            live,
            about: self.about.clone(),
            symbols: self.symbols.clone(),
            certificate: self.certificate.clone(),
            hand: self.hand.clone(),
            initial,
            before,
        })
    }
}

/// Returns the form of links in the list of forces. Rows that a pass of `moves` integrates are only summed there.
pub(super) fn listed(form: Form) -> Form {
    Form { integrate: Integrate::No, folded: false, band: Band::None, ..form }
}

/// Converts passes to their kernels over `R`; `form` selects the form of their links.
fn ops<R: Real>(list: &[Op], laws: &Laws<R>, form: fn(Form) -> Form) -> Result<Vec<Op<R>>, Unbound> {
    let op = |op: &Op| {
        let &Op { kernel: _, pass, law, fns: _, form: of, ports, n, first, mat, coef, mem, tap } = op;
        if of.folded {
            return Err(Unbound::Kernels);
        }
        let fns = match law {
            Some(law) => Some(laws.get(law).ok_or(Unbound::Law(law.code))?),
            None => None,
        };
        let kernel = fns.map_or_else(|| pass.kernel(), |fns| (fns.kernel)(form(of)));
        Ok(Op { kernel, pass, law, fns, form: of, ports, n, first, mat, coef, mem, tap })
    };
    list.iter().map(op).collect()
}

fn reals<R: Real, All: FromIterator<R>>(all: &[f64]) -> All {
    all.iter().map(|v| R::of(*v)).collect()
}

fn layout<R: Real>(l: &Layout, laws: &Laws<R>) -> Result<Layout<R>, Unbound> {
    let enx = |p: &Enx| Enx { input: p.input, mat: p.mat, rest: R::Outer::of(p.rest), implicit: p.implicit };
    let output_link = |h: &OutputLink| {
        let fns = laws.get(h.law).ok_or(Unbound::Law(h.law.code))?;
        let &OutputLink { law, force: _, ends, e0, coef, step, coefs, tap } = h;
        Ok(OutputLink { law, force: fns.force, ends, e0: R::of(e0), coef, step, coefs, tap })
    };
    let account = |a: &Account| {
        let fns = laws.get(a.law).ok_or(Unbound::Law(a.law.code))?;
        let &Account {
            op,
            n,
            ports,
            first,
            coef,
            mem,
            tap,
            law,
            linear,
            live,
            fns: AccountFns { energies: _, idle: _ },
            rows,
        } = a;
        let (energies, idle) = (fns.energies, fns.idle);
        Ok(Account { op, n, ports, first, coef, mem, tap, law, linear, live, fns: AccountFns { energies, idle }, rows })
    };
    let ledger = match &l.ledger {
        Some(plan) => Some(LedgerLayout {
            accounts: plan.accounts.iter().map(account).collect::<Result<_, _>>()?,
            weight: plan.weight,
            live: plan.live,
        }),
        None => None,
    };
    let slow = match &l.rates.slow {
        Some(group) => Some(Arc::new(slow_group(group, laws)?)),
        None => None,
    };
    let substeps = match &l.rates.substeps {
        Some(s) => {
            Some(Substeps { times: s.times, tick: ops(&s.tick, laws, |form| form)?.into(), inputs: s.inputs.clone() })
        }
        None => None,
    };
    let driven = |d: &Driven| Driven {
        input: d.input,
        span: d.span,
        rows: d.rows,
        places: d.places.clone(),
        table: reals(&d.table),
    };
    Ok(Layout {
        rates: Rates { sample_dt: l.rates.sample_dt, ratio: l.rates.ratio, frame: l.rates.frame, slow, substeps },
        counts: l.counts,
        links: LinkArrays {
            ends: l.links.ends.clone(),
            onto: l.links.onto.clone(),
            reach: l.links.reach.iter().map(|r| r.map(R::of)).collect(),
            rows: l.links.rows.clone(),
            pair_sets: l.links.pair_sets.clone(),
            e0: reals(&l.links.e0),
            clusters: l.links.clusters.clone(),
        },
        places: Places {
            rest: reals(&l.places.rest),
            nodes: l.places.nodes.clone(),
            moving_points: l.places.moving_points.clone(),
            modal: l.places.modal.clone(),
            shares: reals(&l.places.shares),
            solved_modal: l.places.solved_modal.clone(),
            modal_couplings: l.places.modal_couplings.clone(),
            couplings: reals(&l.places.couplings),
        },
        tables: l.tables.iter().map(Table::rounded).collect::<Option<_>>().ok_or(Unbound::Table)?,
        ports: PortArrays {
            enx: l.ports.enx.iter().map(enx).collect(),
            enf: l.ports.enf.clone(),
            tgr: l.ports.tgr.iter().map(enx).collect(),
            ahead: l.ports.ahead.clone(),
            driven: l.ports.driven.iter().map(driven).collect(),
            crossing: l.ports.crossing,
        },
        waves: waves(&l.waves),
        weighed: l.weighed.clone(),
        out: OutputArrays {
            links: l.out.links.iter().map(output_link).collect::<Result<_, _>>()?,
            outputs: l.out.outputs.clone(),
            of_motion: l.out.of_motion,
            output_rows: l.out.output_rows.clone(),
            blockers: l.out.blockers.iter().map(|b| DcBlocker { r: R::of(b.r), g: R::of(b.g) }).collect(),
            lowpass: reals(&l.out.lowpass),
        },
        implicit: l.implicit.as_ref().map(implicit),
        ledger,
        vectors: l.vectors,
    })
}

fn waves<R: Real>(w: &Waves) -> Waves<R> {
    let junction = |j: &Junction| Junction { mat: j.mat, z: R::Outer::of(j.z), memory: j.memory };
    let end = |end: Termination| match end {
        Termination::Open => Termination::Open,
        Termination::Rigid => Termination::Rigid,
        Termination::Lossy { loss, memory } => Termination::Lossy { loss: loss.map(R::Outer::of), memory },
    };
    let delay = |d: &Delay| {
        let &Delay { junction, from, to, first, len, end: of } = d;
        Delay { junction, from, to, first, len, end: end(of) }
    };
    Waves {
        junctions: w.junctions.iter().map(junction).collect(),
        delays: w.delays.iter().map(delay).collect(),
        first: w.first,
        len: w.len,
    }
}

fn implicit<R: Real>(a: &ImplicitLinks) -> ImplicitLinks<R> {
    let weights = |all: &[(u32, f64)]| all.iter().map(|(i, w)| (*i, R::of(*w))).collect();
    let force =
        |f: &LinkForce| LinkForce { coef: f.coef, tap: f.tap, moving: weights(&f.moving), fixed: weights(&f.fixed) };
    ImplicitLinks {
        places: a.places.clone(),
        pattern: a.pattern.clone(),
        coef: a.coef,
        forces: a.forces.iter().map(force).collect(),
        pairs: a.pairs.clone(),
    }
}

fn slow_group<R: Real>(g: &SlowGroup, laws: &Laws<R>) -> Result<SlowGroup<R>, Unbound> {
    Ok(SlowGroup {
        layout: layout(&g.layout, laws)?,
        reads: ops(&g.reads, laws, listed)?,
        forces: ops(&g.forces, laws, listed)?,
        after: ops(&g.after, laws, listed)?,
        moves: ops(&g.moves, laws, |form| form)?,
        ports: g.ports.clone(),
        coupled: g.coupled,
        compensated: g.compensated,
        shown: g.shown.clone(),
        links: g.links,
        masses: g.masses,
        response: g.response.clone(),
    })
}

fn state<R: Real>(s: &State, layout: &Layout<R>) -> State<R> {
    let ledger =
        s.ledger.as_ref().map(|l| Box::new(Ledger { start_force: reals(&l.start_force), ..empty_ledger(layout) }));
    let slow = s.slow.as_ref().zip(layout.rates.slow.as_ref()).map(|(slow, group)| {
        let SlowState { state: own, ports, unknown, free } = &**slow;
        let own = state(own, &group.layout);
        Box::new(SlowState { state: own, ports: ports.clone(), unknown: unknown.clone(), free: free.clone() })
    });
    let Ramps { index, instant: whole, .. } = &s.ramps;
    State {
        scene: s.scene,
        x: reals(&s.x),
        d: reals(&s.d),
        f: reals(&s.f),
        coef: reals(&s.coef),
        links: LinkState {
            mem: reals(&s.links.mem),
            lengths: reals(&s.links.lengths),
            tap: reals(&s.links.tap),
            cells: s.links.cells.iter().map(|c| Cell { n: c.n, node: c.node, weight: c.weight.map(R::of) }).collect(),
            near: layout.links.pair_sets.iter().map(|c| VerletList::new(c.members.len(), c.rows, c.columns)).collect(),
            implicit: reals(&s.links.implicit),
            touches: ActiveContacts::in_clusters(&layout.links.clusters, layout.counts.n_touch, layout.counts.n_mat),
        },
        input: s.input.clone(),
        ports: PortState {
            last_input: s.ports.last_input.clone(),
            border: s.ports.border.clone(),
            late: s.ports.late.clone(),
            blocked: s.ports.blocked.iter().map(|b| b.map(R::of)).collect(),
            glide: s.ports.glide.clone(),
            under_way: s.ports.under_way.iter().map(|v| v.map(R::of)).collect(),
            turns: reals(&s.ports.turns),
            lowpass: reals(&s.ports.lowpass),
            refused: s.ports.refused,
        },
        output: reals(&s.output),
        slow,
        ramps: Ramps::new(index.clone(), *whole),
        written: s.written.clone(),
        ledger,
        tick: s.tick,
    }
}
