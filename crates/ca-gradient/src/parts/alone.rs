//! Alone: one link over dual numbers, by the kernel of its law, and the derivatives of a loss by its ends, memory and numbers.
//!
//! Decides for a scene of the ends and this link, whose state is written anew for each: so laws, measures and methods are
//! those of the tick, and none has a derivative written by hand. Links that are solved together are one scene, whose solver runs over
//! dual numbers too; a system of its derivatives would have to be kept in step with that of the tick.

use ca_core::internal::op::layout::{Counts, LinkArrays, Places};
use ca_core::internal::op::{Form, MeasureKind, Op, Pass, Ports, SolveStage};
use ca_core::internal::state::LinkState;
use ca_core::{Scene, State};

use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::layout::Layout;
use ca_core::internal::state::ActiveContacts;
use ca_core::{Dual, TANGENTS};
use std::ops::Range;

/// A port of a link.
#[derive(Clone, Copy)]
pub struct Port {
    /// numbers of a point: 1, or 3 in space
    pub axes: usize,
    /// its distance of the last tick is kept
    pub follows: bool,
    /// its first slot; those of the second end follow those of the first
    first: usize,
}

impl Port {
    /// The slots of its second end.
    pub fn second(&self) -> Range<usize> {
        self.first + self.axes..self.first + 2 * self.axes
    }

    /// The slots of both ends.
    pub fn slots(&self) -> Range<usize> {
        self.first..self.first + 2 * self.axes
    }
}

/// What a link reads, in one list: places of its ends, motions, forces on them, P, Q and C of these, coefficients, memory,
/// last lengths, the constant part of the elongation, and what ports in space need.
pub struct Shape {
    /// one, or two of a quadripole
    pub ports: Vec<Port>,
    /// numbers of all ends
    pub slots: usize,
    /// coefficients
    pub coefs: usize,
    /// numbers of memory
    pub mem: usize,
    /// one, or as many as are solved together
    pub links: usize,
    /// it goes by the sum of the forces
    pub last: bool,
}

impl Shape {
    /// That of the links of a pass.
    pub fn of(op: &Op) -> Option<Shape> {
        let law = op.law?;
        // what is not looked at before it is measured has the distance of the last tick
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

    /// That of links of these passes, one of each, which are solved together; their ends have so many slots.
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

    /// The motions; the places come first.
    pub fn d(&self) -> usize {
        self.slots
    }
    /// The forces.
    pub fn f(&self) -> usize {
        2 * self.slots
    }
    /// P, then Q, then C.
    pub fn own(&self) -> usize {
        3 * self.slots
    }
    /// The coefficients.
    pub fn coef(&self) -> usize {
        6 * self.slots
    }
    /// The memory.
    pub fn memory(&self) -> usize {
        self.coef() + self.coefs
    }
    /// The last lengths, of each port.
    pub fn length(&self) -> usize {
        self.memory() + self.mem
    }
    /// The constant part of the elongation, of each link.
    pub fn e0(&self) -> usize {
        self.length() + self.ports.len()
    }
    /// What ports in space need, four numbers of each port.
    pub fn reach(&self) -> usize {
        self.e0() + self.links
    }
    /// How many there are.
    fn len(&self) -> usize {
        self.reach() + 4 * self.ports.len()
    }

    /// Of what the link reads, that which has an adjoint in each tick. Of two ends one is enough, where the force goes by
    /// their difference alone. `motions`: lengths before are not kept, and had from motion.
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

/// A link that is run alone, or several of one pass one after the other; or some that are solved together.
pub struct Alone {
    /// what they read
    pub shape: Shape,
    /// its pass; of those that are solved together each, then the one that solves
    ops: Vec<Op<Dual>>,
    /// a dipole on a line whose force is that of its law
    direct: bool,
    layout: Layout<Dual>,
    s: State<Dual>,
    /// what the link at hand reads
    pub given: Vec<f64>,
    /// the derivatives of each of it
    pub moving: Vec<[f64; TANGENTS]>,
    /// the adjoint of each of it
    pub adjoint: Vec<f64>,
    /// the derivatives of what it does: the forces on its ends, memory, lengths, and its own force (that of each)
    pub done: Vec<[f64; TANGENTS]>,
}

/// Adjoints of what a link does.
pub struct LinkAdjoints<'a> {
    /// forces on its ends (slots)
    pub force: &'a [f64],
    /// its own force (links)
    pub tap: &'a [f64],
    /// memory, as it is afterwards
    pub memory: &'a [f64],
    /// lengths, as they are afterwards (ports)
    pub lengths: [f64; 2],
}

impl Alone {
    /// The links of a pass, whose law is one of the `dual` scene; `None` where that has none such.
    pub fn new(op: &Op, dual: &Scene<Dual>) -> Option<Alone> {
        let shape = Shape::of(op)?;
        let ends = |p: &Port| [p.first as u32, (p.first + p.axes) as u32];
        let (own, onto) = (vec![ends(&shape.ports[0])], shape.ports[1..].iter().map(ends).collect());
        Alone::of(shape, &[op], own, onto, dual)
    }

    /// Links that are solved together, one of each of these passes, with the first slots of their `ends` among so many.
    pub fn together(ops: &[&Op], ends: Vec<[u32; 2]>, slots: usize, dual: &Scene<Dual>) -> Option<Alone> {
        Alone::of(Shape::together(ops, slots)?, ops, ends, Vec::new(), dual)
    }

    fn of(shape: Shape, ops: &[&Op], ends: Vec<[u32; 2]>, onto: Vec<[u32; 2]>, dual: &Scene<Dual>) -> Option<Alone> {
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
            let pass = Pass::Contacts { modes: false };
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
        Some(Alone {
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

    /// Elongations at which there is no force, of a contact on a line without memory.
    pub fn idle(&self, op: &Op) -> Option<(f64, f64)> {
        let sh = &self.shape;
        let line = sh.ports.len() == 1 && sh.slots == 2;
        let law = op.law.filter(|law| law.contact && law.mem == 0 && line && !sh.last)?;
        Some((law.fns.idle)(&self.given[sh.coef()..][..sh.coefs]))
    }

    /// The derivatives of what the link does, by those of what it reads.
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

    /// Adjoints of the numbers at `wanted`, by those of all that the link does.
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

    /// The same of some numbers of a dipole on a line, by its law without a kernel: a third of the time.
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

    /// Runs its passes.
    fn run(&mut self) {
        for op in &self.ops {
            (op.kernel)(op, &self.layout, &mut self.s);
        }
    }

    /// Writes what is given, with a tangent for each of `some`.
    fn load(&mut self, some: &[usize]) {
        let given = &self.given;
        each(&mut self.s, &mut self.layout, |at, to| *to = Dual::constant(given[at]));
        for (lane, at) in some.iter().enumerate() {
            if let Some(v) = self.at(*at) {
                v.tangents_mut()[lane] = 1.0;
            }
        }
    }

    /// The number at a place of the list.
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

/// A pass of one link of the law of another, which is one of the `dual` scene.
fn pass(op: &Op, dual: &Scene<Dual>) -> Option<Op<Dual>> {
    let code = op.law?.code;
    let (law, fns) = dual.passes.forces.iter().find_map(|o| o.law.zip(o.fns).filter(|(law, _)| law.code == code))?;
    let &Form { measure, onto, .. } = &op.form;
    let form = Form { measure, onto, offset: true, tap: true, ..Form::default() };
    let ports = Ports { measure, onto: onto.map(|m| (m, 0, 1)), ..Ports::default() };
    Some(Op { ports, ..Op::links(law, fns, form, 1) })
}

/// Visits what a link reads, in the order of [`Shape`], each with its place there.
fn each(s: &mut State<Dual>, layout: &mut Layout<Dual>, mut visit: impl FnMut(usize, &mut Dual)) {
    let State { x, d, f, coef, links: LinkState { mem, lengths, .. }, .. } = s;
    let state = [&mut x[..], d, f, coef, mem, lengths].into_iter().flatten();
    let all = state.chain(&mut layout.links.e0).chain(layout.links.reach.as_flattened_mut());
    all.enumerate().for_each(|(at, v)| visit(at, v));
}

/// The slots of link `i` of a pass, port by port, first ends first.
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
