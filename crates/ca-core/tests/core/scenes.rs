//! Tests of scenes built by hand, without a compiler: the tick against closed forms and against a plain loop.

use crate::numbers;
use ca_core::equivalence::{Equivalence, Gains};
use ca_core::internal::live::LiveTable;
use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::layout::{Counts, Enf, Enx, Layout, Output, Places, Rates, Tap};
use ca_core::internal::op::{Form, Op, Pass};
use ca_core::internal::scene::{About, InHand, OutputNames, Passes};
use ca_core::{Certificate, Input, InputRole, Law, Role, Scene, State, Symbols, integrate, process, tick};

const RATE: f64 = 48_000.0;

struct Row {
    layout: Layout,
    state: State,
    reads: Vec<Op>,
    forces: Vec<Op>,
    moves: Vec<Op>,
    inputs: Vec<Input>,
}

impl Row {
    /// Makes MATs at rest with these coefficients P, Q and C.
    fn new(mats: &[[f64; 3]]) -> Row {
        let n = mats.len();
        let layout = Layout {
            rates: Rates { sample_dt: 1.0 / RATE, ratio: 1, frame: 1, ..Rates::default() },
            counts: Counts { n_mat: n, ..Counts::default() },
            places: Places { rest: vec![0.0; n], ..Places::default() },
            ..Layout::default()
        };
        let coef = (0..3).flat_map(|k| mats.iter().map(move |m| m[k])).collect();
        let zeros = || Aligned::zeros(n);
        let mut state = State::default();
        (state.x, state.d, state.f, state.coef) = (zeros(), zeros(), zeros(), coef);
        let own = Op::pass(Pass::IntegrateFull, n);
        let moves = vec![own, Op::pass(Pass::Flush, n)];
        Row { layout, state, reads: Vec::new(), forces: Vec::new(), moves, inputs: Vec::new() }
    }

    /// Joins neighbours by links of `law`, one by one or as a row.
    fn join(mut self, law: &'static Law, coefs: &[Vec<f64>], row: bool) -> Row {
        let (n, l) = (coefs.len(), &mut self.layout);
        let form = Form { stride: usize::from(row), ..Form::default() };
        let mut op = Op { coef: self.state.coef.len(), ..Op::links(law, law.fns, form, n) };
        op.first = l.links.ends.len();
        l.links.ends.extend((0..n as u32).map(|i| [i, i + 1]));
        l.counts.n_lia += n;
        self.more((0..law.coefs).flat_map(|k| coefs.iter().map(move |c| c[k])));
        self.state.links.tap = Aligned::zeros(n);
        self.forces.push(op);
        self
    }

    fn more(&mut self, coefs: impl IntoIterator<Item = f64>) {
        self.state.coef = self.state.coef.iter().copied().chain(coefs).collect();
    }

    /// Adds an output of the position of a MAT.
    fn hear(mut self, mat: u32) -> (Scene, State) {
        let channel = self.layout.out.outputs.len() as u32;
        self.layout.out.outputs.push(Output { tap: Tap::Position(mat), channel });
        (self.layout.counts.channels, self.layout.counts.n_out) = (1, 1);
        let op = Op { coef: self.state.coef.len(), ..Op::pass(Pass::Outputs, 1) };
        self.more([1.0]);
        self.state.output.push(0.0);
        self.layout.counts.n_coef = self.state.coef.len();
        self.state.ports.last_input.clone_from(&self.state.input);
        let scene = Scene {
            rate: RATE,
            layout: self.layout,
            passes: Passes {
                reads: self.reads,
                forces: self.forces,
                fused: 0,
                writes: vec![op],
                moves: self.moves,
                sorted: false,
            },
            inputs: self.inputs,
            names: OutputNames { channel_names: vec!["out".into()], probe_names: Vec::new(), probe_of: Vec::new() },
            live: LiveTable::default(),
            about: About {
                gestures: Vec::new(),
                presets: Vec::new(),
                left_out: Vec::new(),
                title: "by hand".into(),
                seconds: None,
            },
            symbols: Symbols::default(),
            certificate: Certificate::default(),
            hand: InHand { equivalence: Equivalence::default(), couplings: Vec::new() },
            initial: self.state,
            before: None,
        };
        let state = scene.state();
        (scene, state)
    }
}

fn law(kind: &'static ca_core::Kind) -> &'static Law {
    let Role::Lia(law) = kind.role else { panic!("{} is no link", kind.code) };
    law
}

fn input(name: &str, role: InputRole) -> Input {
    Input { name: name.into(), role, rest: 0.0, midi: None, device: None, gains: Gains::default() }
}

/// x_n = A cos((n + φ)θ), cos θ = 1 − a/2: the explicit scheme without damping (docs/numerics.md §1.1).
#[test]
fn an_oscillator_is_its_closed_form() {
    let a = 0.03_f64;
    let (scene, mut s) = Row::new(&[[1.0, -a, 1.0]]).hear(0);
    (s.x[0], s.d[0]) = (1.0, 0.0);
    let mut out = vec![0.0; 48_000];
    assert!(process(&scene, &mut s, &mut out));
    let theta = libm::acos(1.0 - 0.5 * a);
    // x₀ = x₋₁: the crest is half a tick before the start
    let closed = |n: usize| libm::cos((n as f64 + 0.5) * theta) / libm::cos(0.5 * theta);
    let worst = out.iter().enumerate().map(|(n, x)| (x - closed(n)).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
}

/// The same links give the same bits one by one, as a row, and in a plain loop over modules.
#[test]
fn a_row_is_its_links_one_by_one() {
    let n = 67;
    let mut next = numbers(5);
    let mats: Vec<[f64; 3]> = (0..n).map(|_| [1.0 - 1e-4 * next(), -1e-3 * next(), 0.2 + 0.1 * next()]).collect();
    let coefs: Vec<Vec<f64>> = (1..n).map(|_| vec![1.0 + next(), 0.1 * next()]).collect();
    let start: Vec<f64> = (0..n).map(|_| 1e-3 * (next() - 0.5)).collect();
    let play = |row: bool| {
        let (scene, mut s) = Row::new(&mats).join(law(&ca_core::internal::phi::REF), &coefs, row).hear(3);
        s.x.copy_from_slice(&start);
        (0..5_000).for_each(|_| tick(&scene, &mut s));
        s
    };
    let (one, all) = (play(false), play(true));
    let (mut x, mut d) = (start.clone(), vec![0.0; n]);
    for _ in 0..5_000 {
        let mut f = vec![0.0; n];
        for (i, c) in coefs.iter().enumerate() {
            let force = c[0] * (x[i + 1] - x[i]) + c[1] * (d[i + 1] - d[i]);
            f[i] += force;
            f[i + 1] -= force;
        }
        for i in 0..n {
            d[i] = mats[i][0] * d[i] + mats[i][1] * x[i] + mats[i][2] * f[i];
            x[i] += d[i];
        }
    }
    assert!(x.iter().any(|x| x.abs() > 1e-9), "it is still in motion");
    assert_eq!((&one.x[..], &one.d[..]), (&x[..], &d[..]), "one by one");
    assert_eq!((&all.x[..], &all.d[..]), (&x[..], &d[..]), "as a row");
    assert_eq!(one.bits(), all.bits());
}

/// The energy of the explicit scheme, ½ d²/c + ½ Σ k e₀e₁, does not drift.
#[test]
fn a_string_without_loss_keeps_its_energy() {
    let n = 40;
    let coefs = vec![vec![1.0]; n - 1];
    let (scene, mut s) =
        Row::new(&vec![[1.0, 0.0, 0.5]; n]).join(law(&ca_core::internal::phi::res::KIND), &coefs, true).hear(0);
    s.x[7] = 1e-3;
    let energy = |s: &State| {
        let kinetic: f64 = s.d.iter().map(|d| d * d).sum();
        let springs: f64 =
            (1..n).map(|i| (s.x[i] - s.x[i - 1]) * ((s.x[i] - s.d[i]) - (s.x[i - 1] - s.d[i - 1]))).sum();
        kinetic + 0.5 * springs
    };
    tick(&scene, &mut s);
    let at_first = energy(&s);
    let mut worst = 0.0_f64;
    for _ in 0..100_000 {
        tick(&scene, &mut s);
        worst = worst.max((energy(&s) / at_first - 1.0).abs());
    }
    assert!(worst < 1e-11, "{worst:e}");
}

#[test]
fn inputs_that_are_not_finite_are_refused() {
    let mut row = Row::new(&[[1.0, 0.0, 0.0], [1.0, 0.0, 1.0]]);
    row.layout.ports.enx = vec![Enx { input: 0, mat: 0, rest: 0.0, implicit: false }];
    row.layout.ports.enf = vec![Enf { input: 1, mat: 1 }];
    row.inputs = vec![input("bow", InputRole::Position), input("push", InputRole::Force)];
    row.state.input = vec![0.0; 2];
    row.reads = vec![Op::pass(Pass::Enx, 1), Op::pass(Pass::Enf { counted: true }, 1)];
    // only the input moves the port
    row.moves = vec![Op { mat: 1, ..Op::pass(Pass::IntegrateFree, 1) }];
    let (scene, mut s) = row.hear(1);
    s.input = vec![0.25, 2.0];
    tick(&scene, &mut s);
    assert_eq!((s.x[0], s.d[1], s.ports.refused), (0.25, 2.0, 0));
    for (k, bad) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().enumerate() {
        s.input = vec![bad, bad];
        tick(&scene, &mut s);
        assert_eq!((s.x[0], s.d[1], s.ports.refused), (0.25, 2.0, 2 * (k as u64 + 1)), "{bad}: held, and no force");
    }
}

#[test]
fn what_does_not_fit_is_not_played() {
    let (scene, mut s) = Row::new(&[[1.0, -0.1, 1.0]]).hear(0);
    s.x[0] = 1.0;
    // rows of one output each; an empty buffer has zero rows
    assert!(process(&scene, &mut s, &mut []) && s.tick == 0);
    let clone = s.clone();
    integrate(&scene, &mut s);
    assert!(s.tick == 1 && s != clone);
}

#[test]
fn small_numbers_become_nothing_before_they_are_slow() {
    let (scene, mut s) = Row::new(&[[0.525, 0.0, 1.0]]).hear(0);
    s.d[0] = 1e-3;
    let mut out = vec![0.0; 1_024];
    assert!(process(&scene, &mut s, &mut out));
    // 1e-3 · 0.525¹⁰²⁴ = 3e-290 is not denormal yet, and far too small to matter
    assert_eq!(s.d[0], 0.0);
    assert!((s.x[0] - 1e-3 * 0.525 / 0.475).abs() < 1e-15, "where it came to rest: {}", s.x[0]);
}
