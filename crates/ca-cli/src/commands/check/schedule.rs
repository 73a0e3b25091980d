//! The passes of one tick, and what each costs.
//!
//! Decides to measure, and to show beside it what the table of `ca_compile::cost` predicts: instructions, times what one
//! takes here. Where the two differ, a pass waits for something, or its vectors are wider than those of the table. Each pass is run over and
//! over on a copy of a state that is in motion, the copy renewed before every batch so that nothing decays to zero or
//! grows; the fastest batch counts, which is the one that nobody disturbed. What this leaves out is that passes warm
//! the caches for each other, so the whole tick is measured too and the sum may differ from it.

use crate::outcome::Failure;
use crate::term::short;
use ca_compile::cost;
use ca_core::internal::op::{Band, Hub, Integrate, MeasureKind, Op};
use ca_core::{Scene, State, tick};
use ca_io::perform::Performance;
use ca_lab::timing::Timing;
use serde_json::{Value as Json, json};
use std::io::Write as _;
use std::time::{Duration, Instant};

/// Playing so long brings the state into motion \[s\].
const WARM: f64 = 0.2;
/// A large scene is played no longer than this for it.
const PATIENCE: Duration = Duration::from_secs(1);

/// The pass of groups at the gesture rate, and a tick at which a frame begins.
const GROUP: &str = "gesture group";
const FIRST: u64 = 1;

/// One pass.
pub(super) struct PassRow {
    stage: &'static str,
    op: Op,
    modules: usize,
    /// per tick
    ns: f64,
    /// instructions per tick, where the table of costs has the pass
    instructions: Option<f64>,
}

/// All passes, and the whole tick.
pub(super) struct Measured {
    rows: Vec<PassRow>,
    tick: f64,
    /// instructions of a tick, without passes that the table of costs does not have
    instructions: f64,
    /// what an instruction takes here
    ns_per_instruction: f64,
    /// groups at the gesture rate: their step of a frame \[ns\]
    step: Option<f64>,
}

/// Measures every pass of a tick, and what an instruction takes.
pub(super) fn measure(scene: &Scene) -> Result<Measured, Failure> {
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
            state = p.state;
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
    // what is done once a frame is not what most ticks do
    let frame = f64::from(scene.rates.frame);
    let step = rows.iter_mut().find(|r| r.op.name() == GROUP).map(|r| {
        let first = fastest(&state, |s| one(&r.op, scene, s, FIRST));
        let others = fastest(&state, |s| one(&r.op, scene, s, FIRST + 1));
        r.ns = (first + (frame - 1.0) * others) / frame;
        first
    });
    let tick = fastest(&state, |s| tick(scene, s));
    let ns_per_instruction = ca_lab::bench::ns_per_instruction()?;
    Ok(Measured { rows, tick, instructions: cost::of_tick(scene), ns_per_instruction, step })
}

/// One pass, as if it were always the same tick: some count ticks.
fn one(op: &Op, scene: &Scene, s: &mut State, tick: u64) {
    s.tick = tick;
    (op.kernel)(op, scene, s);
    s.tick = tick;
}

/// Fastest time of one call \[ns\].
fn fastest(state: &State, run: impl FnMut(&mut State)) -> f64 {
    Timing::default().fastest(&mut state.clone(), |s| s.clone_from(state), run)
}

/// How the links of a pass are laid out.
fn form(op: &Op) -> String {
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

/// How many pairs a pass joins as one module, if it does.
fn pairs(scene: &Scene, op: &Op) -> Option<u64> {
    op.ports.pair_set.map(|c| scene.links.pair_sets[c].pairs())
}

/// What a scene could have and this one has not.
fn absent(scene: &Scene) -> Vec<&'static str> {
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
        ("TGR in", "no border to a device"),
        ("ENX", "no position inputs"),
        ("ENF", "no force inputs"),
        ("points", "no moving points"),
        ("waves in", "no waveguides"),
        ("modal ports", "no modes"),
        ("implicit", "nothing that is implicit"),
        ("weight", "no gravity"),
        ("outputs", "no outputs"),
        ("high pass", "no high pass"),
        ("low pass", "no low-pass"),
        ("ticks between", "one tick a sample"),
    ]
    .into_iter()
    .filter(|a| !any(a.0))
    .map(|a| a.1);
    absent.chain((!space).then_some("nothing in space")).collect()
}

/// For people.
pub(super) fn text(scene: &Scene, m: &Measured) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "\nOne tick, measured here:")?;
    let forms: Vec<String> = m.rows.iter().map(|r| form(&r.op)).collect();
    let wide = forms.iter().map(String::len).fold(20, usize::max);
    writeln!(
        out,
        "  {:<7} {:<15} {:>8}  {:<wide$} {:>10} {:>10} {:>10}",
        "", "pass", "modules", "form", "ns/tick", "predicted", "ns/module"
    )?;
    let mut last = "";
    for (r, form) in m.rows.iter().zip(forms) {
        let stage = if r.stage == last { "" } else { r.stage };
        last = r.stage;
        let (n, name) = (r.modules, r.op.name());
        let each = r.ns / n.max(1) as f64;
        let predicted = r.instructions.map_or("-".into(), |n| format!("{:.1}", n * m.ns_per_instruction));
        let name = pairs(scene, &r.op).map_or(name.to_string(), |p| format!("{name} ({p} pairs)"));
        writeln!(out, "  {stage:<7} {name:<15} {n:>8}  {form:<wide$} {:>10.1} {predicted:>10} {each:>10.2}", r.ns)?;
    }
    let budget = 1e9 * scene.rates.sample_dt;
    writeln!(
        out,
        "  whole tick {:.1} ns of {budget:.0} ns: {} times real time on one core",
        m.tick,
        short(budget / m.tick.max(1e-3))
    )?;
    let without = if m.rows.iter().all(|r| r.instructions.is_some()) { "" } else { " without those marked -" };
    writeln!(
        out,
        "  predicted {:.1} ns{without}: {:.0} instructions of AVX2\n  by a table of costs, {:.4} ns each, measured here on \
         links that are looked up one by one; what waits for memory, in large scenes, is not in it",
        m.instructions * m.ns_per_instruction,
        m.instructions,
        m.ns_per_instruction
    )?;
    if let Some((group, step)) = scene.rates.slow.as_ref().zip(m.step) {
        writeln!(
            out,
            "  the group: {} masses and {} links take {step:.1} ns once in {} ticks, which at the sound rate each tick would take",
            group.masses, group.links, scene.rates.frame
        )?;
    }
    writeln!(out, "\nLeft out:")?;
    for what in &scene.about.left_out {
        writeln!(out, "  {what}")?;
    }
    writeln!(out, "  {}", absent(scene).join(", "))?;
    Ok(())
}

/// For programs.
pub(super) fn json(scene: &Scene, m: &Measured) -> Json {
    let rows: Vec<Json> = m
        .rows
        .iter()
        .map(|r| {
            let of_links = r.op.law.is_some();
            let n = r.modules;
            json!({
                "stage": r.stage, "pass": r.op.name(), "modules": n, "stride": of_links.then_some(r.op.form.stride),
                "offset": of_links.then_some(r.op.form.offset), "tap": of_links.then_some(r.op.form.tap),
                "pairs": pairs(scene, &r.op), "ns_per_tick": r.ns, "ns_per_module": r.ns / n.max(1) as f64,
                "instructions_predicted": r.instructions,
                "ns_predicted": r.instructions.map(|i| i * m.ns_per_instruction),
            })
        })
        .collect();
    json!({
        "passes": rows, "ns_per_tick": m.tick, "budget_ns": 1e9 * scene.rates.sample_dt, "measured": "here",
        "instructions_predicted": m.instructions, "ns_predicted": m.instructions * m.ns_per_instruction,
        "ns_per_instruction": m.ns_per_instruction,
        "ns_of_group_per_frame": m.step, "left_out": scene.about.left_out, "absent": absent(scene),
    })
}
