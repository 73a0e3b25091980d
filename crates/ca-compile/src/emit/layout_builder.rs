//! LayoutBuilder: slots of modules, indices of their coefficients, and the recomputation of live ones.

use crate::net::{End, LiaNode, OutputTap, Pruned};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::Arg;
use ca_core::internal::live::{LiveImplicit, LiveItem, LiveModule, LiveTable, Loader, Source};
use ca_core::internal::method::implicit::Inertia;
use ca_core::internal::op::layout::{CoordinateSource, ImplicitLinks};
use ca_core::internal::tuning::Scheme;
use ca_core::{Identity, Role};

/// Arrays and slots of a scene being laid out.
pub struct LayoutBuilder<'a> {
    /// Network.
    pub net: &'a Pruned,
    /// First slot of each MAT, by document number; `u32::MAX` if it was left out.
    pub slot: Vec<u32>,
    /// Slot of each moving point.
    pub point: Vec<u32>,
    /// Coefficients so far.
    pub coef: Vec<f64>,
    /// Indices of live coefficients.
    pub live: Vec<u32>,
    /// Coefficients of the last module loaded.
    pub loaded: Vec<f64>,
    /// Numbers that these coefficients were loaded from.
    pub numbers: Vec<Option<f64>>,
    /// Modules with live coefficients, by item.
    pub modules: BTreeMap<u32, Vec<LiveModule>>,
}

impl<'n> LayoutBuilder<'n> {
    /// Assigns slots to MATs in `order`, then to the moving points in use.
    pub fn new(net: &'n Pruned, order: &[u32]) -> LayoutBuilder<'n> {
        let mut slot = alloc::vec![u32::MAX; net.mats.len()];
        let mut n_mat = 0;
        for m in order {
            slot[*m as usize] = n_mat;
            n_mat += net.mats[*m as usize].slots();
        }
        let mut point = alloc::vec![u32::MAX; net.points.len()];
        for (p, used) in point.iter_mut().zip(used_points(net)) {
            if used {
                *p = n_mat;
                n_mat += 1;
            }
        }
        let coef = alloc::vec![0.0; 3 * n_mat as usize];
        LayoutBuilder {
            net,
            slot,
            point,
            coef,
            live: Vec::new(),
            loaded: Vec::new(),
            numbers: Vec::new(),
            modules: BTreeMap::new(),
        }
    }
}

impl LayoutBuilder<'_> {
    /// Returns the links whose force is an output.
    pub fn output_links(&self) -> BTreeSet<u32> {
        let force = |tap: &OutputTap| if let OutputTap::ForceOf(l) = tap { Some(*l) } else { None };
        self.net.outs.iter().filter_map(|o| force(&o.tap)).collect()
    }

    /// Returns the number of slots of MATs and moving points, while `coef` contains only their coefficients.
    pub fn coef_slots(&self) -> usize {
        self.coef.len() / 3
    }

    /// Returns the slot of an end; `u32::MAX` if it was left out.
    pub fn at(&self, e: End) -> u32 {
        match e {
            End::Mat(m) => self.slot[m as usize],
            End::Point(p) => self.point[p as usize],
        }
    }

    /// Returns the slot of one axis of an end, if it stays.
    pub fn alive(&self, e: End, axis: u8) -> Option<u32> {
        Some(self.at(e)).filter(|m| *m != u32::MAX).map(|m| m + u32::from(axis))
    }

    /// Computes coefficients into `to`, and records how if they are live.
    pub fn load(&mut self, loader: Loader, item: u32, values: &[Source], to: &[usize]) {
        let slots = &self.net.items[item as usize].slots;
        self.numbers.clear();
        self.numbers.extend(values.iter().map(|s| s.get(slots)));
        loader.load(&self.numbers, self.net.tick_dt, &mut self.loaded);
        for (t, v) in to.iter().zip(&self.loaded) {
            self.coef[*t] = *v;
        }
        if self.net.is_live(item) && values.iter().any(|s| matches!(s, Source::Slot(_))) {
            let places = to.iter().map(|t| self.live_place(*t)).collect();
            let module = LiveModule { loader, values: Arc::from(values), to: places };
            self.modules.entry(item).or_default().push(module);
        }
    }

    fn live_place(&mut self, coef: usize) -> u32 {
        self.live.push(coef as u32);
        self.live.len() as u32 - 1
    }

    /// Adds a coefficient for a coordinate of a moving point, live if it follows a parameter.
    pub fn coordinate(&mut self, v: f64, param: Option<u32>) -> CoordinateSource {
        self.coef.push(v);
        let at = self.coef.len() - 1;
        if let Some(p) = param {
            let to = alloc::vec![self.live_place(at)];
            let module = LiveModule { loader: Loader::Times(1.0), values: Arc::from([Source::Slot(0)]), to };
            // Points are not items: they are numbered after the items, one per parameter.
            self.modules.entry(self.net.items.len() as u32 + p).or_default().push(module);
        }
        CoordinateSource::Coef(at as u32)
    }

    /// Returns the data for live changes.
    pub fn live_table(&mut self, implicit: Option<&(ImplicitLinks, Inertia)>) -> LiveTable {
        let implicit = implicit.and_then(|(a, made)| {
            let live: BTreeSet<u32> = self.live.iter().copied().collect();
            let inputs = made.inputs();
            if !inputs.iter().any(|c| live.contains(c)) {
                return None;
            }
            let first = self.live.len() as u32;
            self.live.extend((a.coef as u32..).take(made.numbers()));
            let known = inputs.into_iter().map(|c| (c, self.coef[c as usize])).collect();
            Some(LiveImplicit { made: made.clone(), first, known })
        });
        let items = core::mem::take(&mut self.modules)
            .into_iter()
            .map(|(id, modules)| {
                if let Some(item) = self.net.items.get(id as usize) {
                    LiveItem {
                        kind: item.kind,
                        dim: item.dim,
                        scheme: self.net.scheme(item.group),
                        args: item.args.clone(),
                        follows: item.follows.clone(),
                        generator: if let Role::Generator(g) = item.kind.role { Some(g) } else { None },
                        modules,
                    }
                } else {
                    let p = id as usize - self.net.items.len();
                    LiveItem {
                        kind: &ca_core::internal::io::ENX,
                        dim: 1,
                        scheme: Scheme::Explicit,
                        args: alloc::vec![Arg::Num(self.net.params[p].value)],
                        follows: alloc::vec![(0, p, 1.0)],
                        generator: None,
                        modules,
                    }
                }
            })
            .collect();
        // The identity is set when the scene is complete.
        let scene = Identity::default();
        LiveTable {
            scene,
            params: self.net.params.clone(),
            coefs: self.live.clone(),
            driven: Vec::new(),
            driven_coefs: Vec::new(),
            items,
            implicit,
        }
    }
}

fn used_points(net: &Pruned) -> Vec<bool> {
    let mut used = alloc::vec![false; net.points.len()];
    let ends = net.lias.iter().flat_map(LiaNode::all_ends);
    let read = net.outs.iter().filter_map(|o| match o.tap {
        OutputTap::Position(e) | OutputTap::ForceOn(e) => Some(e),
        OutputTap::ForceOf(_) => None,
    });
    for e in ends.chain(read).chain(net.pushes.iter().map(|p| p.end)) {
        if let End::Point(p) = e {
            used[p as usize] = net.under(e).iter().all(|m| net.alive[*m as usize]);
        }
    }
    used
}
