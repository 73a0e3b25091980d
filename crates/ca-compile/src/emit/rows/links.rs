//! Links: the arrays of all batches, and the position of each link.

use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::penetration;
use crate::emit::rows::batch::{Batch, JOINT};
use crate::net::{End, Measure, Pruned, elongation};
use crate::options::Options;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use ca_core::Law;
use ca_core::internal::live::{Loader, Source};
use ca_core::internal::op::layout::{OutputLink, PairSet};
use ca_core::internal::op::{Band, Form, Integrate, MeasureKind, Op, Ports, SolveStage};
use ca_core::internal::state::Fold;
use ca_model::Model;
use ca_model::diag::Diags;

/// The links, laid out.
pub struct Links {
    /// Passes.
    pub forces: Vec<Op>,
    /// Index of the first pass that is solved with the coming motion.
    pub late: usize,
    /// Number of contacts that are solved together.
    pub touch: usize,
    /// First and second slot of each link.
    pub ends: Vec<[u32; 2]>,
    /// Slots of second ports.
    pub onto: Vec<[u32; 2]>,
    /// Geometry of ports in space.
    pub reach: Vec<[f64; 4]>,
    /// Sets whose pairs are all linked.
    pub pair_sets: Vec<PairSet>,
    /// Constant part of the elongation of each link.
    pub e0: Vec<f64>,
    /// Number of memory values.
    pub mem: usize,
    /// Number of stored forces.
    pub tap: usize,
    /// Links of fused rows whose force is an output, by their number in the network.
    pub outputs: Vec<(u32, OutputLink)>,
    /// Pass and position of each link of the network.
    pub where_is: Vec<(u32, u32)>,
}

/// Returns the tables built into laws, in order of first use. They follow the tables of the model.
pub fn own_tables(net: &Pruned) -> Vec<(&'static Law, ca_core::Table)> {
    let mut own: Vec<(&'static Law, ca_core::Table)> = Vec::new();
    for l in &net.lias {
        if let Some(table) = l.law.table {
            if !own.iter().any(|(law, _)| core::ptr::eq(*law, l.law)) {
                own.push((l.law, table()));
            }
        }
    }
    own
}

impl LayoutBuilder<'_> {
    /// Returns the first slots of the ends of a link.
    pub fn ends(&self, l: u32) -> [u32; 2] {
        let l = &self.net.lias[l as usize];
        self.port(l.ends, l.measure)
    }

    /// Returns the first slots of two ends; on a line, the slots of the axes that are measured.
    fn port(&self, ends: [End; 2], measure: Measure) -> [u32; 2] {
        let axes = if let Measure::Line(axes) = measure { axes } else { [0, 0] };
        [0, 1].map(|k| self.at(ends[k]) + u32::from(axes[k]))
    }

    /// Returns the geometry of a port in space, besides its ends; `None` on a line.
    fn reach(&self, ends: [End; 2], measure: Measure, soften: f64) -> Option<[f64; 4]> {
        match measure {
            Measure::Line(_) => None,
            Measure::Along(n) => Some([n[0], n[1], n[2], 0.0]),
            Measure::Radial => {
                let [x, y, z] = self.net.rest_vector(ends);
                Some([x, y, z, soften * soften])
            }
        }
    }

    /// Lays out all links.
    pub fn links(&mut self, batches: Vec<Batch>, options: &Options, diags: &mut Diags, model: &Model) -> Links {
        let net = self.net;
        let own = own_tables(net);
        let read = self.output_links();
        // With a 0 on either side, for rows that integrate.
        let passing = |b: &&Batch| b.stride > 0 || b.band == Band::Across;
        let scratch = batches.iter().filter(passing).map(|b| b.links.len() + 2).max().unwrap_or(0);
        let mut k = Links {
            forces: Vec::new(),
            late: batches.iter().filter(|b| b.law.stage.is_explicit()).count(),
            touch: 0,
            ends: Vec::with_capacity(net.lias.len()),
            onto: Vec::new(),
            reach: Vec::new(),
            pair_sets: Vec::new(),
            e0: Vec::with_capacity(net.lias.len()),
            mem: 0,
            tap: scratch,
            outputs: Vec::new(),
            where_is: alloc::vec![(0, 0); net.lias.len()],
        };
        let mut to = Vec::new();
        for row in batches {
            let (n, any, mat) = (row.links.len(), row.some(), row.slot(self));
            let Batch { links: batch, law, stride, hub, integrate, folded, band, .. } = row;
            if folded {
                self.coef.resize(self.coef.len().next_multiple_of(Fold::LANES), 0.0);
            }
            let (first, coef) = (k.ends.len(), self.coef.len());
            let shape = self.shape(any, law);
            let mut ports = Ports { measure: shape.measure, reach: k.reach.len(), onto: None, pair_set: None };
            let nodes = || batch.iter().filter(|id| **id != JOINT).map(|id| &net.lias[*id as usize]);
            k.reach.extend(nodes().filter_map(|l| self.reach(l.ends, l.measure, l.soften)));
            if let Some(g) = shape.onto {
                ports.onto = Some((g, k.onto.len(), k.reach.len()));
                k.onto.extend(nodes().filter_map(|l| l.onto.as_ref()).map(|o| self.port(o.ends, o.measure)));
                k.reach.extend(nodes().filter_map(|l| {
                    let o = l.onto.as_ref()?;
                    self.reach(o.ends, o.measure, l.soften)
                }));
            }
            let sets = net.lias[any as usize].sets.as_ref();
            if let Some(sets) = sets {
                let places = |set: &[u32]| set.iter().map(|m| self.slot[*m as usize]).collect::<Vec<u32>>();
                ports.pair_set = Some(k.pair_sets.len());
                k.pair_sets.push(PairSet::new([&places(&sets[0]), &places(&sets[1])]));
            }
            self.coef.resize(coef + n * law.coefs, 0.0);
            for (i, id) in batch.iter().enumerate() {
                if *id == JOINT {
                    k.ends.push([self.ends(any)[0]; 2]);
                    k.e0.push(0.0);
                    continue;
                }
                let l = &net.lias[*id as usize];
                k.ends.push(self.ends(*id));
                k.e0.push(elongation::offset(self.net, l));
                k.where_is[*id as usize] = (k.forces.len() as u32, i as u32);
                let mut values = Cow::Borrowed(&l.values[..]);
                if law.implicit && !l.law.implicit {
                    values = alloc::vec![values.get(1).copied().unwrap_or(Source::Absent)].into();
                }
                if let Some(t) = own.iter().position(|(o, _)| core::ptr::eq(*o, law)) {
                    values.to_mut().push(Source::Const((net.tables.len() + t) as f64));
                }
                to.clear();
                to.extend((0..law.coefs).map(|s| coef + s * n + i));
                self.load(Loader::Lia(law), l.item, &values, &to);
                let onto = l.onto.as_ref().map(|o| self.reach(o.ends, o.measure, l.soften).unwrap_or_default());
                let reach = [self.reach(l.ends, l.measure, l.soften).unwrap_or_default(), onto.unwrap_or_default()];
                if l.law.contact {
                    penetration::warn(net, l, k.e0[first + i], &reach, model, diags);
                }
            }
            let some_read = batch.iter().any(|l| read.contains(l));
            // The ledger needs the work of a link if that differs from what it stores and loses.
            let radial = [Some(shape.measure), shape.onto].contains(&Some(MeasureKind::Radial));
            let audited = options.energy && (!law.linear || law.implicit || radial);
            let tap = audited || some_read && integrate == Integrate::No;
            if some_read && !tap {
                let coefs = law.coefs as u32;
                for (i, l) in batch.iter().enumerate().filter(|(_, l)| read.contains(l)) {
                    let (ends, e0, coef, tap) = (self.ends(*l), k.e0[first + i], (coef + i) as u32, k.tap as u32);
                    k.outputs.push((
                        *l,
                        OutputLink { law, force: law.fns.force, ends, e0, coef, step: n as u32, coefs, tap },
                    ));
                    k.tap += 1;
                }
            }
            let offset = k.e0[first..].iter().any(|e| *e != 0.0);
            let (measure, onto, set) = (shape.measure, shape.onto, sets.is_some());
            let soften = measure == MeasureKind::Radial && k.reach[ports.reach..].iter().any(|r| r[3] != 0.0);
            let form = Form { stride, hub, offset, tap, measure, onto, set, soften, ..Form::default() };
            // Only the pass that integrates treats a folded batch as a row.
            let mut op = Op::links(law, law.fns, form, n);
            let form = Form { integrate, folded, band, ..form };
            op = Op { form, ports, first, coef, mem: k.mem, mat: mat as usize, ..op };
            if tap {
                op.tap = k.tap;
                // A set stores the force on each axis of each member.
                k.tap += ports.pair_set.map_or(n, |c| 3 * k.pair_sets[c].members.len());
            }
            k.mem += n * law.mem;
            k.touch += if matches!(law.stage, SolveStage::Coupled(_)) { n } else { 0 };
            k.forces.push(op);
        }
        k
    }
}
