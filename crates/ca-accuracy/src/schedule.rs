//! Passes of a tick and their costs.
//!
//! Each pass is measured and compared with the prediction of `ca_compile::cost`: its instructions times the time per
//! instruction on this machine. A slower pass waits for memory or another pass; a faster one uses wider vectors than
//! the table assumes. A pass runs repeatedly on a copy of a state in motion, renewed before each batch so that nothing
//! decays or grows. The fastest batch counts, since other programs disturb the rest. Passes warm the caches for each
//! other, so the whole tick is measured too and may differ from the sum of the passes.

use crate::bench;
use crate::timing::Timing;
use ca_compile::cost;
use ca_core::internal::op::{Band, Hub, Integrate, MeasureKind, Op};
use ca_core::{Scene, State, tick};
use ca_io::perform::Performance;
use ca_lab::Failure;
use std::time::{Duration, Instant};

/// Time of play that brings the state into motion \[s\].
const WARM: f64 = 0.2;
/// Limit of real time for that play.
const PATIENCE: Duration = Duration::from_secs(1);

/// Pass of groups at the gesture rate, and a tick at which a frame begins.
const GROUP: &str = "gesture group";
const FIRST: u64 = 1;

/// Measured pass.
#[derive(Clone)]
pub struct PassRow {
    /// Stage of the tick: reads, forces, writes or moves.
    pub stage: &'static str,
    /// The pass.
    pub op: Op,
    /// Number of its modules.
    pub modules: usize,
    /// Time per tick \[ns\].
    pub ns: f64,
    /// Instructions per tick, if the cost table has the pass.
    pub instructions: Option<f64>,
}

/// All passes, and the whole tick.
#[derive(Clone)]
pub struct Schedule {
    /// Passes in the order of the tick.
    pub rows: Vec<PassRow>,
    /// Time of the whole tick \[ns\].
    pub tick: f64,
    /// Predicted instructions of a tick, without passes that the cost table lacks.
    pub instructions: f64,
    /// Time per instruction on this machine \[ns\].
    pub ns_per_instruction: f64,
    /// Time of a step of groups at the gesture rate, once per frame \[ns\].
    pub step: Option<f64>,
}

/// Measures every pass of a tick, and the time per instruction.
///
/// # Errors
/// If the reference scene for the time per instruction does not compile.
pub fn measure(scene: &Scene) -> Result<Schedule, Failure> {
    let mut state = scene.state();
    if let Ok(mut p) = Performance::new(scene, None) {
        let end = Instant::now() + PATIENCE;
        for n in 0..(WARM * scene.rate) as u64 {
            if n % 16 == 0 && Instant::now() > end {
                break;
            }
            p.tick();
        }
        if !p.diverged {
            state = p.player.state;
        }
    }
    let stages = [
        ("reads", &scene.passes.reads[..]),
        ("forces", scene.passes.summed()),
        ("writes", &scene.passes.writes),
        ("moves", &scene.passes.moves),
    ];
    let mut rows: Vec<PassRow> = stages
        .into_iter()
        .flat_map(|(stage, ops)| ops.iter().map(move |op| (stage, *op)))
        .map(|(stage, op)| {
            let ns = fastest(&state, |s| one(&op, scene, s, state.tick));
            PassRow {
                stage,
                op,
                modules: ca_core::internal::scene::modules(scene, &op),
                ns,
                instructions: cost::of_pass(scene, &op),
            }
        })
        .collect();
    // the step happens once per frame: average over its ticks
    let frame = f64::from(scene.rates.frame);
    let step = rows.iter_mut().find(|r| r.op.name() == GROUP).map(|r| {
        let first = fastest(&state, |s| one(&r.op, scene, s, FIRST));
        let others = fastest(&state, |s| one(&r.op, scene, s, FIRST + 1));
        r.ns = (first + (frame - 1.0) * others) / frame;
        first
    });
    let tick = fastest(&state, |s| tick(scene, s));
    let ns_per_instruction = bench::ns_per_instruction()?;
    Ok(Schedule { rows, tick, instructions: cost::of_tick(scene), ns_per_instruction, step })
}

/// Runs one pass always at the same tick, since some passes count ticks.
fn one(op: &Op, scene: &Scene, s: &mut State, tick: u64) {
    s.tick = tick;
    (op.kernel)(op, scene, s);
    s.tick = tick;
}

/// Fastest time of one call \[ns\].
fn fastest(state: &State, run: impl FnMut(&mut State)) -> f64 {
    Timing::default().fastest(&mut state.clone(), |s| s.clone_from(state), run)
}

/// Describes the layout of the links of a pass; empty for a pass without links.
pub fn form(op: &Op) -> String {
    if op.law.is_none() {
        return String::new();
    }
    let measure = |g: MeasureKind| match g {
        MeasureKind::Line => "line",
        MeasureKind::Along => "direction",
        MeasureKind::Radial => "distance",
    };
    if op.form.set {
        return if op.form.tap { "all pairs, neighbour list + tap".into() } else { "all pairs, neighbour list".into() };
    }
    let mut words = vec![match (op.form.measure, op.form.onto, op.form.stride) {
        (a, Some(b), _) => format!("{} onto {}", measure(a), measure(b)),
        (MeasureKind::Line, None, 0) if op.form.hub != Hub::None => "fan".to_string(),
        (MeasureKind::Line, None, 0) => "gather".to_string(),
        (MeasureKind::Line, None, 1) => "run".to_string(),
        (MeasureKind::Line, None, n) => format!("run, stride {n}"),
        (g, None, _) => measure(g).to_string(),
    }];
    let offset = op.form.offset && op.form.measure == MeasureKind::Line;
    words.extend(offset.then(|| "offset".to_string()));
    words.extend(op.form.tap.then(|| "tap".to_string()));
    words.extend(op.form.folded.then(|| "folded".to_string()));
    if let Band::Along(width) = op.form.band {
        words.push(format!("across, {width} apart"));
    }
    words.extend((op.form.integrate != Integrate::No).then(|| "integration".to_string()));
    words.join(" + ")
}

/// Returns the number of pairs of a pass that joins all pairs of two sets as one module.
pub fn pairs(scene: &Scene, op: &Op) -> Option<u64> {
    op.ports.pair_set.map(|c| scene.links.pair_sets[c].pairs())
}

/// Names the optional passes that this scene does not need.
pub fn absent(scene: &Scene) -> Vec<&'static str> {
    // `high pass of motion` is a high pass too
    let is =
        |own: &str, name: &str| own.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(" of "));
    let any = |name: &str| {
        [&scene.passes.reads, &scene.passes.forces, &scene.passes.writes, &scene.passes.moves]
            .into_iter()
            .flatten()
            .any(|o| is(o.name(), name))
    };
    let space = scene.symbols.iter().any(|s| s.axes > 1);
    let absent = [
        ("ledger", "no energy ledger"),
        ("changes", "no live parameters"),
        ("TGR in", "no device ports"),
        ("ENX", "no position inputs"),
        ("ENF", "no force inputs"),
        ("points", "no moving points"),
        ("waves in", "no waveguides"),
        ("modal ports", "no modes"),
        ("implicit", "no implicit parts"),
        ("weight", "no gravity"),
        ("outputs", "no outputs"),
        ("high pass", "no high pass"),
        ("low pass", "no low-pass"),
        ("ticks between", "one tick per sample"),
    ]
    .into_iter()
    .filter(|a| !any(a.0))
    .map(|a| a.1);
    absent.chain((!space).then_some("no modules in space")).collect()
}
