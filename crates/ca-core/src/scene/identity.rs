//! The identity of a scene, to which a state or a patch belongs, as one number.
//!
//! It is a hash of what the tick reads (arrays, passes and the state at load), not a counter of compilations. The same
//! model compiled twice is the same scene: a snapshot remains valid after its scene is gone, two such states are equal,
//! and `compile` stores nothing between calls. Names, findings and the certificate are not included, since the tick
//! does not read them. The identity is computed once, at load. [`tick`](crate::tick()) and
//! [`State::apply`](crate::State::apply) compare it. It detects mistakes, not attacks.

use crate::numeric::Real;
use crate::numeric::word_hash::word;
use crate::op::layout::{
    Counts, Delay, Layout, LinkArrays, MeasureKind, OutputArrays, Places, PortArrays, Rates, Termination,
};
use crate::op::{Op, Pass, SolveStage};
use crate::scene::Scene;
use crate::state::{Identity, State};
use core::fmt::{self, Write as _};
use core::hash::Hasher as _;

/// Number of the arithmetic of a tick. Another arithmetic may differ in last bits, in the scenes given by
/// [`same_since`].
///
/// - 0: distances of the tick before were computed from motion, and the outputs of a channel summed one by one.
/// - 1: distances are stored, and many outputs of a channel are summed in lanes.
/// - 2: forces of force ports on a line are added after the forces of links instead of before.
/// - 3: links written one by one are summed in the order of rows, linear ones on a line first.
/// - 4: contacts that are solved together drop stored energy below 1e-200 J.
/// - 5: set-valued friction sticks from the first tick on if nothing moves at load.
/// - 6: ports at links solved with the coming motion run a tick late; shared `stable` contacts use discrete gradients.
/// - 7: links that share masses are first solved one by one, in sweeps, if one of them is a discrete gradient.
/// - 8: links that share masses are solved cluster by cluster; `t60_high` of a waveguide is the decay of a partial.
///
/// Takes from before 5, 6, 7 and 8 are compiled as they were then, and so play the same bits.
pub const ARITHMETIC: u32 = 8;

/// Returns the oldest arithmetic that plays a scene with the same bits as [`ARITHMETIC`].
pub fn same_since<R: Real>(scene: &Scene<R>) -> u32 {
    let measures = |op: &Op<R>| {
        let second = op.ports.onto.map(|onto| onto.0);
        op.law.is_some() && (op.ports.measure == MeasureKind::Radial || second == Some(MeasureKind::Radial))
    };
    let curved = |op: &Op<R>| op.law.is_some_and(|law| matches!(law.stage, SolveStage::Coupled(c) if c.curve));
    let coupled = |op: &Op<R>| op.law.is_some_and(|law| matches!(law.stage, SolveStage::Coupled(_)));
    let taps = |d: &Delay<R>| matches!(&d.end, Termination::Lossy { loss, .. } if loss.b != R::Outer::of(0.0));
    if !scene.layout.links.clusters.is_empty() || scene.layout.waves.delays.iter().any(taps) {
        return 8;
    }
    let forces = &scene.passes.forces;
    if forces.iter().any(|op| op.pass == Pass::Contacts { modes: false, sweeps: true }) {
        return 7;
    }
    if !scene.layout.ports.ahead.is_empty() || forces.iter().any(curved) {
        return 6;
    }
    if forces.iter().any(coupled) {
        return 4;
    }
    if scene.passes.sorted {
        return 3;
    }
    if !scene.layout.ports.enf.is_empty() {
        return 2;
    }
    u32::from(scene.passes.forces.iter().any(measures) || !scene.layout.out.output_rows.is_empty())
}

/// Computes the identity of a scene from its arrays, passes and state at load.
pub fn identify<R: Real>(layout: &Layout<R>, passes: [&[Op<R>]; 4], initial: &State<R>) -> Identity {
    let mut h = Words(fnv::FnvHasher::default());
    h.layout(layout);
    for list in passes {
        h.all(
            list.iter()
                .map(|o| (o.name(), o.law.map(|l| l.code), o.form, o.ports, o.n, o.first, o.mat, o.coef, o.mem, o.tap)),
        );
    }
    h.word(initial.bits());
    h.debug(&initial.input);
    h.debug(&initial.ramps);
    Identity(h.0.finish().max(1))
}

/// A hash of words. Long arrays enter as bits, short records as their debug text, which omits no field.
struct Words(fnv::FnvHasher);

impl fmt::Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}

impl Words {
    fn word(&mut self, v: u64) {
        word(&mut self.0, v);
    }

    fn numbers<'n, R: Real>(&mut self, all: impl ExactSizeIterator<Item = &'n R>) {
        self.word(all.len() as u64);
        all.for_each(|v| self.word(v.wide().to_bits()));
    }

    fn places<'n>(&mut self, all: impl ExactSizeIterator<Item = &'n u32>) {
        self.word(all.len() as u64);
        all.for_each(|v| self.word(u64::from(*v)));
    }

    fn debug(&mut self, value: &impl fmt::Debug) {
        // writing to a hash cannot fail
        let _ = write!(self, "{value:?};");
    }

    fn all(&mut self, values: impl Iterator<Item = impl fmt::Debug>) {
        values.for_each(|v| self.debug(&v));
        self.word(u64::MAX);
    }

    /// Adds a layout. It names each field, so that adding one requires a decision here.
    fn layout<R: Real>(&mut self, layout: &Layout<R>) {
        let Layout {
            rates: Rates { sample_dt, ratio, frame, slow, substeps },
            counts: Counts { n_mat, n_lia, n_coef, n_mem, n_touch, n_tap, channels, n_out },
            // rows follow from ends, reach and rest
            links: LinkArrays { ends, onto, reach, pair_sets, e0, clusters, rows: _ },
            places: Places { rest, nodes, moving_points, modal, shares, solved_modal, modal_couplings, couplings },
            tables,
            ports: PortArrays { enx, enf, tgr, ahead, driven, crossing },
            waves,
            weighed,
            // output_rows follow from outputs
            out: OutputArrays { links: output_links, outputs, of_motion, blockers, lowpass, output_rows: _ },
            implicit,
            ledger,
            vectors: _,
        } = layout;
        self.debug(&(sample_dt, ratio, frame, n_mat, n_lia, n_coef, n_mem, n_touch, n_tap, channels, n_out));
        self.places(ends.as_flattened().iter());
        self.places(onto.as_flattened().iter());
        self.numbers(reach.as_flattened().iter());
        self.numbers(e0.iter());
        self.numbers(rest.iter());
        self.places(nodes.iter());
        self.numbers(shares.iter());
        self.places(weighed.iter());
        self.all(output_links.iter().map(|h| (h.ends, h.e0, h.coef, h.step, h.coefs, h.tap)));
        self.debug(&(pair_sets, moving_points, modal, tables));
        self.debug(&(enx, enf, tgr, crossing, waves));
        if !clusters.is_empty() {
            self.places(clusters.iter());
        }
        if !ahead.is_empty() {
            self.places(ahead.iter());
        }
        if !solved_modal.is_empty() {
            self.debug(&(solved_modal, modal_couplings));
            self.numbers(couplings.iter());
        }
        if !driven.is_empty() {
            self.debug(driven);
        }
        if *of_motion != [0; 2] {
            self.debug(of_motion);
        }
        self.debug(&(outputs, blockers, lowpass, implicit));
        let accounts = ledger.iter().flat_map(|l| &l.accounts);
        self.debug(&ledger.as_ref().map(|l| (l.weight, l.live)));
        self.all(
            accounts.map(|a| {
                (a.op, a.n, a.ports, a.first, a.coef, a.mem, a.tap, a.law.coefs, a.law.mem, (a.linear, a.live))
            }),
        );
        if let Some(group) = slow {
            self.layout(&group.layout);
            self.debug(&(&group.ports, group.coupled, &group.shown, &group.response));
        }
        self.debug(&substeps.as_ref().map(|f| (f.times, &f.inputs)));
    }
}
