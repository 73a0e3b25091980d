//! Links: batches of one law, rows as runs, and where each link ends up.

use super::net::{Ear, End, LiaNode, Net};
use super::options::{KernelClass, Options};
use super::plan::Plan;
use crate::kind::Role;
use crate::live::{Loader, Source};
use crate::model::Model;
use crate::model::diag::{Diag, Diags};
use crate::op::law::Law;
use crate::op::{Form, Op};
use alloc::format;
use alloc::vec::Vec;

/// Rows shorter than this are gathered: a run has two loops to set up.
const SHORTEST_RUN: usize = 4;

/// The links, laid out.
pub struct Links {
    /// their passes
    pub forces: Vec<Op>,
    /// first and second MAT of each
    pub ends: Vec<[u32; 2]>,
    /// constant part of the elongation of each
    pub e0: Vec<f64>,
    /// numbers of memory
    pub mem: usize,
    /// places for forces
    pub tap: usize,
    /// for each link of the net, its op and position in it
    pub where_is: Vec<(u32, u32)>,
}

/// Tables that laws bring with them, in order of first use, after those of the model.
pub fn own_tables(net: &Net) -> Vec<(&'static Law, crate::table::Table)> {
    let mut own: Vec<(&'static Law, crate::table::Table)> = Vec::new();
    for l in &net.lias {
        if let Some(table) = l.law.table {
            if !own.iter().any(|(law, _)| core::ptr::eq(*law, l.law)) {
                own.push((l.law, table()));
            }
        }
    }
    own
}

impl Plan<'_> {
    /// Batches of links: in document order, or by law with rows as runs; each with its stride, 0 where there is none.
    fn batches(&self, class: KernelClass) -> Vec<(Vec<u32>, usize)> {
        let same = |a: u32, b: u32| core::ptr::eq(self.law(a), self.law(b));
        let all: Vec<u32> = (0..self.net.lias.len() as u32).collect();
        if class == KernelClass::Reference {
            return all.chunk_by(|a, b| same(*a, *b)).map(|c| (c.to_vec(), 0)).collect();
        }
        let mut by_law: Vec<Vec<u32>> = Vec::new();
        for l in all {
            match by_law.iter_mut().find(|g| same(g[0], l)) {
                Some(g) => g.push(l),
                None => by_law.push(alloc::vec![l]),
            }
        }
        let mut out = Vec::new();
        for group in by_law {
            let mut loose = Vec::new();
            let stride = |l: u32| self.ends(l)[1].wrapping_sub(self.ends(l)[0]);
            let follows =
                |a: &u32, b: &u32| stride(*a) == stride(*b) && self.ends(*b)[0] == self.ends(*a)[0].wrapping_add(1);
            for row in group.chunk_by(follows) {
                if row.len() >= SHORTEST_RUN && stride(row[0]) < u32::MAX / 2 {
                    out.push((row.to_vec(), stride(row[0]) as usize));
                } else {
                    loose.extend_from_slice(row);
                }
            }
            if !loose.is_empty() {
                out.push((loose, 0));
            }
        }
        out
    }

    fn law(&self, l: u32) -> &'static Law {
        self.net.lias[l as usize].law
    }

    fn ends(&self, l: u32) -> [u32; 2] {
        self.net.lias[l as usize].ends.map(|e| self.at(e))
    }

    /// Constant part of the elongation: laws with a rest length are slack at rest, contacts count from position.
    fn offset(&self, l: &LiaNode) -> f64 {
        let distance = self.net.rest(l.ends[1]) - self.net.rest(l.ends[0]);
        let slack = if l.kind.param("l0").is_some() { l.l0.unwrap_or(distance) } else { 0.0 };
        let generated = matches!(l.kind.role, Role::Lia(_)) && self.net.items[l.item as usize].kind.code != l.kind.code;
        if generated { 0.0 } else { distance - slack }
    }

    /// Lays out all links.
    pub fn links(&mut self, options: &Options, diags: &mut Diags, model: &Model) -> Links {
        let net = self.net;
        let own = own_tables(net);
        let heard: Vec<u32> =
            net.outs.iter().filter_map(|o| if let Ear::ForceOf(l) = o.ear { Some(l) } else { None }).collect();
        let batches = self.batches(options.kernel);
        let scratch = batches.iter().filter(|b| b.1 > 0).map(|b| b.0.len()).max().unwrap_or(0);
        let mut k = Links {
            forces: Vec::new(),
            ends: Vec::with_capacity(net.lias.len()),
            e0: Vec::with_capacity(net.lias.len()),
            mem: 0,
            tap: scratch,
            where_is: alloc::vec![(0, 0); net.lias.len()],
        };
        for (batch, stride) in batches {
            let law = self.law(batch[0]);
            let n = batch.len();
            let (first, coef) = (k.ends.len(), self.coef.len());
            self.coef.resize(coef + n * law.coefs, 0.0);
            for (i, id) in batch.iter().enumerate() {
                let l = &net.lias[*id as usize];
                k.ends.push(self.ends(*id));
                k.e0.push(self.offset(l));
                k.where_is[*id as usize] = (k.forces.len() as u32, i as u32);
                let mut values = l.values.to_vec();
                if let Some(t) = own.iter().position(|(o, _)| core::ptr::eq(*o, law)) {
                    values.push(Source::Const((net.tables.len() + t) as f64));
                }
                let mut to = [0usize; 8];
                for (s, t) in to[..law.coefs].iter_mut().enumerate() {
                    *t = coef + s * n + i;
                }
                self.load(Loader::Lia(law), l.item, &values, &to);
                contact_at_load(net, l, k.e0[first + i], model, diags);
            }
            let tap = options.energy || batch.iter().any(|l| heard.contains(l));
            let form = Form { stride, offset: k.e0[first..].iter().any(|e| *e != 0.0), tap };
            let mut op = Op::pass(law.code, (law.kernel)(form), n);
            op = Op { law: Some(law), form, first, coef, mem: k.mem, mat: k.ends[first][0] as usize, ..op };
            if tap {
                op.tap = k.tap;
                k.tap += n;
            }
            k.mem += n * law.mem;
            k.forces.push(op);
        }
        k
    }
}

/// Warns of a contact that is pressed together before anything has moved.
fn contact_at_load(net: &Net, l: &LiaNode, e0: f64, model: &Model, diags: &mut Diags) {
    if !matches!(l.kind.code, "BUT" | "HRZ") {
        return;
    }
    let at = |e: End| if let End::Mat(m) = e { net.mats[m as usize].dx0 } else { 0.0 };
    let e = e0 + at(l.ends[1]) - at(l.ends[0]);
    let mut c = [0.0; 8];
    (l.law.load)(&net.values(l.item, &l.values), net.te, &mut c[..l.law.coefs]);
    let f = (l.law.force)(&c[..l.law.coefs], &mut [], &net.tables, e, 0.0);
    let item = &model.items[net.items[l.item as usize].model];
    let known = |d: &Diag| d.code == "W102" && d.span() == item.name_span && item.name_span.is_some();
    if f != 0.0 && !diags.list.iter().any(known) {
        let (a, b) = (net.end_name(l.ends[0]), net.end_name(l.ends[1]));
        let d = Diag::warning(
            "W102",
            format!(
                "`{}` presses at load, with {}",
                l.name,
                crate::model::quantity::show(f.abs(), crate::kind::Unit::NEWTON)
            ),
        );
        let help =
            format!("it keeps `{b}` above `{a}`; swap the ends of `between`, or move one of them by `x` or `dx0`");
        // three digits are enough to find the place
        let gap = format!("{:.2e}", e.abs()).parse().unwrap_or(e.abs());
        let gap = crate::model::quantity::show(gap, crate::kind::Unit::METRE);
        let side = if e < 0.0 { "below" } else { "above" };
        diags.push(d.at(item.name_span, format!("`{b}` is {gap} {side} `{a}`")).help(help));
    }
}
