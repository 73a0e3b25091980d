//! One link over dual numbers, by the kernel of its law; and the derivatives of a loss by its ends, memory and numbers.
//!
//! The link is a scene of its ends and its pass, whose state is written anew for each evaluation. So the laws, measures
//! and methods of the tick serve here too, and none needs a derivative written by hand. Links that are solved together
//! are one scene, whose solver runs over dual numbers too; a separate system for its derivatives would have to follow
//! every change of that solver.

use ca_core::internal::op::layout::{Counts, LinkArrays, Places};
use ca_core::internal::op::{Form, MeasureKind, Op, Pass, Ports, SolveStage};
use ca_core::internal::state::LinkState;
use ca_core::{Scene, State};

use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::layout::Layout;
use ca_core::internal::state::ActiveContacts;
use ca_core::{Dual, TANGENTS};
use std::ops::Range;

#[derive(Clone, Copy)]
pub struct Port {
    /// Coordinates of a point: 1, or 3 in space.
    pub axes: usize,
    /// The distance of the last tick is stored.
    pub follows: bool,
    /// First slot of the first end; the second end follows.
    first: usize,
}

impl Port {
    pub fn second(&self) -> Range<usize> {
        self.first + self.axes..self.first + 2 * self.axes
    }

    pub fn slots(&self) -> Range<usize> {
        self.first..self.first + 2 * self.axes
    }
}

/// Layout of what a link reads, as one list: positions of its ends, motions, forces on them, their P, Q and C,
/// coefficients, memory, last lengths, constant part of the elongation, numbers of ports in space.
pub struct Shape {
    /// One, or two for a quadripole.
    pub ports: Vec<Port>,
    /// Slots of all ends.
    pub slots: usize,
    pub coefs: usize,
    pub mem: usize,
    /// 1, or the number of links solved together.
    pub links: usize,
    /// The force depends on the sum of the forces.
    pub last: bool,
}

impl Shape {
    pub fn of(op: &Op) -> Option<Shape> {
        let law = op.law?;
        // contacts without memory are skipped while open, so their last distance is not stored
        let looked_at = law.contact && law.mem == 0 && op.form.onto.is_none();
        let last = !matches!(law.stage, SolveStage::Explicit);
        let (mut ports, mut first) = (Vec::new(), 0);
        for measure in [Some(op.form.measure), op.form.onto].into_iter().flatten() {
            let axes = if measure == MeasureKind::Line { 1 } else { 3 };
            ports.push(Port { axes, follows: measure == MeasureKind::Radial && !looked_at && !last, first });
            first += 2 * axes;
        }
        Some(Shape { ports, slots: first, coefs: law.coefs, mem: law.mem, links: 1, last })
    }

    /// Shape of links solved together, one of each of these passes, with `slots` slots at their ends.
    pub fn together(ops: &[&Op], slots: usize) -> Option<Shape> {
        let mut all = Shape { ports: Vec::new(), slots, coefs: 0, mem: 0, links: ops.len(), last: true };
        for op in ops {
            let of = Shape::of(op).filter(|of| of.ports.len() == 1)?;
            all.ports.extend(of.ports.iter().map(|p| Port { follows: false, ..*p }));
            all.coefs += of.coefs;
            all.mem += of.mem;
        }
        Some(all)
    }

    /// Offset of the motions; positions are at 0.
    pub fn d(&self) -> usize {
        self.slots
    }
    pub fn f(&self) -> usize {
        2 * self.slots
    }
    /// Offset of P, followed by Q and C.
    pub fn own(&self) -> usize {
        3 * self.slots
    }
    pub fn coef(&self) -> usize {
        6 * self.slots
    }
    pub fn memory(&self) -> usize {
        self.coef() + self.coefs
    }
    /// Offset of the last lengths, one per port.
    pub fn length(&self) -> usize {
        self.memory() + self.mem
    }
    /// Offset of the constant elongations, one per link.
    pub fn e0(&self) -> usize {
        self.length() + self.ports.len()
    }
    /// Offset of the numbers of ports in space, four per port.
    pub fn reach(&self) -> usize {
        self.e0() + self.links
    }
    fn len(&self) -> usize {
        self.reach() + 4 * self.ports.len()
    }

    /// Returns which values have an adjoint in each tick: one of two ends where the force depends only on their
    /// difference. With `motions`, last lengths are not stored and follow from the motion.
    pub fn carried(&self, motions: bool) -> Vec<usize> {
        let mut all = Vec::new();
        if self.last {
            all.extend(0..self.own());
        } else {
            for p in &self.ports {
                all.extend(p.second());
                all.extend(p.second().filter(|_| motions || !p.follows).map(|k| self.d() + k));
            }
        }
        all.extend(self.memory()..self.length());
        all.extend(self.ports.iter().enumerate().filter(|(_, p)| p.follows).map(|(k, _)| self.length() + k));
        all
    }
}

/// Link evaluated alone, or several of one pass one after the other; or several solved together.
pub struct SingleLink {
    pub shape: Shape,
    /// Its pass; of links solved together one pass each, then the one that solves.
    ops: Vec<Op<Dual>>,
    /// A dipole on a line: the law returns its force.
    direct: bool,
    layout: Layout<Dual>,
    s: State<Dual>,
    /// Values read by the current link, laid out as `shape`.
    pub given: Vec<f64>,
    /// Derivatives of each value read.
    pub moving: Vec<[f64; TANGENTS]>,
    /// Adjoint of each value read.
    pub adjoint: Vec<f64>,
    /// Derivatives of the results: forces on the ends, memory, lengths, and the force of each link.
    pub done: Vec<[f64; TANGENTS]>,
}

pub struct LinkAdjoints<'a> {
    /// Of the forces on its ends (slots).
    pub force: &'a [f64],
    /// Of its own force (links).
    pub tap: &'a [f64],
    /// Of its memory after the tick.
    pub memory: &'a [f64],
    /// Of its lengths after the tick (ports).
    pub lengths: [f64; 2],
}

impl SingleLink {
    /// Makes the links of a pass; `None` where the `dual` scene does not have their law.
    pub fn new(op: &Op, dual: &Scene<Dual>) -> Option<SingleLink> {
        let shape = Shape::of(op)?;
        let ends = |p: &Port| [p.first as u32, (p.first + p.axes) as u32];
        let (own, onto) = (vec![ends(&shape.ports[0])], shape.ports[1..].iter().map(ends).collect());
        SingleLink::of(shape, &[op], own, onto, dual)
    }

    /// Makes links solved together, one of each of these passes; `ends` holds the first slots of their ends.
    pub fn together(ops: &[&Op], ends: Vec<[u32; 2]>, slots: usize, dual: &Scene<Dual>) -> Option<SingleLink> {
        SingleLink::of(Shape::together(ops, slots)?, ops, ends, Vec::new(), dual)
    }

    fn of(
        shape: Shape,
        ops: &[&Op],
        ends: Vec<[u32; 2]>,
        onto: Vec<[u32; 2]>,
        dual: &Scene<Dual>,
    ) -> Option<SingleLink> {
        let (slots, links) = (shape.slots, shape.links);
        let (mut coef, mut mem, mut passes) = (3 * slots, 0, Vec::new());
        for (k, op) in ops.iter().enumerate() {
            let pass = pass(op, dual)?;
            let (coefs, memory) = pass.law.map(|law| (law.coefs, law.mem))?;
            let ports = Ports { reach: k, ..pass.ports };
            passes.push(Op { ports, first: k, coef, mem, tap: k, ..pass });
            (coef, mem) = (coef + coefs, mem + memory);
        }
        let law = passes.first()?.law?;
        let mut s = State::default();
        if let SolveStage::Coupled(_) = law.stage {
            let pass = Pass::Contacts { modes: false, sweeps: false };
            passes.push(Op::new(pass, pass.kernel(), links));
            s.links.touches = ActiveContacts::new(links, slots);
        }
        let layout = Layout {
            counts: Counts { n_mat: slots, ..Counts::default() },
            links: LinkArrays {
                ends,
                onto,
                e0: vec![Dual::default(); links],
                reach: vec![[Dual::default(); 4]; shape.ports.len()],
                ..LinkArrays::default()
            },
            places: Places { rest: vec![Dual::default(); slots], ..Places::default() },
            tables: dual.layout.tables.clone(),
            vectors: dual.layout.vectors,
            ..Layout::default()
        };
        (s.x, s.d, s.f) = (Aligned::zeros(slots), Aligned::zeros(slots), Aligned::zeros(slots));
        s.coef = Aligned::zeros(3 * slots + shape.coefs);
        s.links.mem = vec![Dual::default(); shape.mem];
        s.links.lengths = Aligned::zeros(shape.ports.len());
        s.links.tap = Aligned::zeros(links);
        Some(SingleLink {
            direct: slots == 2 && !shape.last,
            ops: passes,
            layout,
            s,
            given: vec![0.0; shape.len()],
            moving: vec![[0.0; TANGENTS]; shape.len()],
            done: vec![[0.0; TANGENTS]; slots + shape.mem + shape.ports.len() + links],
            adjoint: vec![0.0; shape.len()],
            shape,
        })
    }

    /// Returns the elongations without a force, for a contact on a line without memory.
    pub fn idle(&self, op: &Op) -> Option<(f64, f64)> {
        let sh = &self.shape;
        let line = sh.ports.len() == 1 && sh.slots == 2;
        let law = op.law.filter(|law| law.contact && law.mem == 0 && line && !sh.last)?;
        Some((law.fns.idle)(&self.given[sh.coef()..][..sh.coefs]))
    }

    /// Computes the derivatives of the results from the derivatives of the values read.
    pub fn carry(&mut self) {
        if let (true, Some(fns)) = (self.direct, self.ops[0].fns) {
            let number = |at: usize| {
                let mut v = Dual::constant(self.given[at]);
                v.tangents_mut().copy_from_slice(&self.moving[at]);
                v
            };
            let sh = &self.shape;
            let e = number(1) - number(0) + number(sh.e0());
            let w = number(sh.d() + 1) - number(sh.d());
            let (coefs, mem) = (&mut self.s.coef[3 * sh.slots..], &mut self.s.links.mem[..]);
            coefs.iter_mut().zip(sh.coef()..).for_each(|(to, at)| *to = number(at));
            mem.iter_mut().zip(sh.memory()..).for_each(|(to, at)| *to = number(at));
            let force = (fns.force)(coefs, mem, &self.layout.tables, e, w);
            self.s.f[0] = force;
            self.s.f[1] = -force;
            self.s.links.tap[0] = force;
        } else {
            let (given, moving) = (&self.given, &self.moving);
            each(&mut self.s, &mut self.layout, |at, to| {
                *to = Dual::constant(given[at]);
                to.tangents_mut().copy_from_slice(&moving[at]);
            });
            self.run();
        }
        let s = &self.s;
        let all = s.f.iter().chain(&s.links.mem).chain(s.links.lengths.iter()).chain(s.links.tap.iter());
        self.done.iter_mut().zip(all).for_each(|(to, v)| *to = *v.tangents());
    }

    /// Computes the adjoints of the values at `wanted` from the adjoints of the results.
    pub fn pull_back(&mut self, by: &LinkAdjoints, wanted: &[usize]) {
        for some in wanted.chunks(TANGENTS) {
            if self.direct {
                self.force(by, some);
                continue;
            }
            self.load(some);
            self.run();
            let s = &self.s;
            let mut sums = [0.0; TANGENTS];
            let mut add = |v: &Dual, by: f64| {
                for (sum, t) in sums.iter_mut().zip(v.tangents()) {
                    *sum += by * t;
                }
            };
            s.f.iter().zip(by.force).for_each(|(v, by)| add(v, *by));
            s.links.mem.iter().zip(by.memory).for_each(|(v, by)| add(v, *by));
            s.links.lengths.iter().zip(by.lengths).for_each(|(v, by)| add(v, by));
            s.links.tap.iter().zip(by.tap).for_each(|(v, by)| add(v, *by));
            for (at, sum) in some.iter().zip(sums) {
                self.adjoint[*at] = sum;
            }
        }
    }

    /// As `pull_back`, for a dipole on a line: calls the law without a kernel, in a third of the time.
    fn force(&mut self, by: &LinkAdjoints, some: &[usize]) {
        let (sh, given) = (&self.shape, &self.given);
        let [x, d] = [0, sh.d()].map(|at| given[at + 1] - given[at]);
        let (mut e, mut w) = (Dual::constant(x + given[sh.e0()]), Dual::constant(d));
        let coefs = &mut self.s.coef[3 * sh.slots..];
        for (to, v) in coefs.iter_mut().zip(&given[sh.coef()..]) {
            *to = Dual::constant(*v);
        }
        for (to, v) in self.s.links.mem.iter_mut().zip(&given[sh.memory()..]) {
            *to = Dual::constant(*v);
        }
        for (lane, at) in some.iter().enumerate() {
            let to = match *at {
                at if at == 1 || at == sh.e0() => &mut e,
                at if at == sh.d() + 1 => &mut w,
                at if at >= sh.memory() => &mut self.s.links.mem[at - sh.memory()],
                at => &mut coefs[at - sh.coef()],
            };
            to.tangents_mut()[lane] = 1.0;
        }
        let Some(fns) = self.ops[0].fns else { return };
        let force = (fns.force)(coefs, &mut self.s.links.mem, &self.layout.tables, e, w);
        let adjoint = by.force[0] - by.force[1] + by.tap[0];
        for (lane, at) in some.iter().enumerate() {
            let memory = self.s.links.mem.iter().zip(by.memory).map(|(v, by)| by * v.tangents()[lane]);
            self.adjoint[*at] = adjoint * force.tangents()[lane] + memory.sum::<f64>();
        }
    }

    fn run(&mut self) {
        for op in &self.ops {
            (op.kernel)(op, &self.layout, &mut self.s);
        }
    }

    /// Writes the values read, with a unit tangent for each of `some`.
    fn load(&mut self, some: &[usize]) {
        let given = &self.given;
        each(&mut self.s, &mut self.layout, |at, to| *to = Dual::constant(given[at]));
        for (lane, at) in some.iter().enumerate() {
            if let Some(v) = self.at(*at) {
                v.tangents_mut()[lane] = 1.0;
            }
        }
    }

    /// Number at an index of the list of [`Shape`].
    fn at(&mut self, at: usize) -> Option<&mut Dual> {
        let (sh, s) = (&self.shape, &mut self.s);
        let n = sh.slots;
        match at {
            _ if at < sh.d() => s.x.get_mut(at),
            _ if at < sh.f() => s.d.get_mut(at - n),
            _ if at < sh.own() => s.f.get_mut(at - 2 * n),
            _ if at < sh.memory() => s.coef.get_mut(at - 3 * n),
            _ if at < sh.length() => s.links.mem.get_mut(at - sh.memory()),
            _ if at < sh.e0() => s.links.lengths.get_mut(at - sh.length()),
            _ if at < sh.reach() => self.layout.links.e0.get_mut(at - sh.e0()),
            _ => self.layout.links.reach.as_flattened_mut().get_mut(at - sh.reach()),
        }
    }
}

/// Makes a pass of one link with the law of `op`, taken from the `dual` scene.
fn pass(op: &Op, dual: &Scene<Dual>) -> Option<Op<Dual>> {
    let code = op.law?.code;
    let (law, fns) = dual.passes.forces.iter().find_map(|o| o.law.zip(o.fns).filter(|(law, _)| law.code == code))?;
    let &Form { measure, onto, .. } = &op.form;
    let form = Form { measure, onto, offset: true, tap: true, ..Form::default() };
    let ports = Ports { measure, onto: onto.map(|m| (m, 0, 1)), ..Ports::default() };
    Some(Op { ports, ..Op::links(law, fns, form, 1) })
}

/// Visits the values that a link reads with their indices, in the order of [`Shape`].
fn each(s: &mut State<Dual>, layout: &mut Layout<Dual>, mut visit: impl FnMut(usize, &mut Dual)) {
    let State { x, d, f, coef, links: LinkState { mem, lengths, .. }, .. } = s;
    let state = [&mut x[..], d, f, coef, mem, lengths].into_iter().flatten();
    let all = state.chain(&mut layout.links.e0).chain(layout.links.reach.as_flattened_mut());
    all.enumerate().for_each(|(at, v)| visit(at, v));
}

/// Slots of link `i` of a pass: port by port, first ends first.
pub fn slots(scene: &Scene, op: &Op, i: usize) -> Vec<usize> {
    let Some(shape) = Shape::of(op) else { return Vec::new() };
    let l = &scene.layout;
    let ends = [Some(l.links.ends[op.first + i]), op.ports.onto.map(|o| l.links.onto[o.1 + i])];
    let port = |(p, ends): (&Port, [u32; 2])| {
        let axes = p.axes;
        ends.into_iter().flat_map(move |m| m as usize..m as usize + axes)
    };
    shape.ports.iter().zip(ends.into_iter().flatten()).flat_map(port).collect()
}
