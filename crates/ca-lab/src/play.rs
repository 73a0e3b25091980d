//! A play by [`ca_io::play`] and its judgement: its ledger, the cause of its divergence, the time that it lasted.

use ca_core::{Balance, Ledger, LiveParam, Scene};
use ca_io::gesture::Gesture;
pub use ca_io::length::Length;
use ca_io::perform::{DIVERGED, Performance};
pub use ca_io::perform::{frames, seconds};
pub use ca_io::play::{BLOCK, Played, Sink, play};
pub use ca_io::sound::Sample;
use ca_model::diag::Diags;
use ca_model::quantity;

/// An energy ledger, and how much time it covers.
pub struct Audit {
    /// at its end
    pub ledger: Ledger,
    /// ticks it covers
    pub ticks: u64,
    /// whether it was kept all the time
    pub whole: bool,
    /// whether the scene diverged at its end
    pub diverged: bool,
}

/// What is audited without being asked \[s\]: long enough for a stroke and what follows it. A whole second of a ledger costs
/// more than the sound of some models (`benches/render.rs`).
const SECONDS: f64 = 0.5;

/// Modules times ticks the audited scene may take: a second of a thousand-mass string. Larger scenes are audited for
/// less, and the summary says for how long.
const AUDITED: u64 = 100_000_000;

/// Ticks between two looks at whether an audited scene has left its range: at every tick a look takes as long as half of it.
const LOOK: u64 = 64;

/// Plays the first half second once more with the ledger kept, up to the last tick before any divergence.
pub fn audit(audited: &Scene, gesture: Option<&Gesture>, frames: u64) -> Option<Audit> {
    let afford = AUDITED / (audited.counts.n_mat + audited.counts.n_lia).max(1) as u64;
    let ticks = frames.min((SECONDS * audited.rate) as u64).min(afford).max(1);
    let bounded = |look: u64| {
        let mut p = Performance::new(audited, gesture).ok()?;
        p.until(ticks + 1, look);
        Some(p)
    };
    let mut p = bounded(LOOK)?;
    if !p.state.is_bounded(DIVERGED) {
        // it left its range since the last look: the same up to the very tick
        p = bounded(1)?;
    }
    let entered = p.state.tick.saturating_sub(1);
    let diverged = !p.state.is_bounded(DIVERGED);
    p.player.state.ledger.map(|ledger| Audit { ledger: *ledger, ticks: entered, whole: false, diverged })
}

/// Why a scene left every range.
pub struct Divergence {
    /// \[s\]
    pub time: f64,
    /// to blame
    pub module: String,
    /// why it
    pub why: String,
    /// what to do, where the certificate knows
    pub fix: Option<String>,
}

impl Divergence {
    /// What is to blame, where `played` diverged; `audited` is its scene, with the ledger kept if there is one,
    /// `findings` those of the compiler.
    pub fn of(played: &Played, audited: &Scene, findings: &Diags, gesture: Option<&Gesture>) -> Option<Divergence> {
        let time = played.diverged_at? as f64 * audited.rates.sample_dt;
        let (module, why) = played.performance.blame(Some(audited), gesture);
        Some(Divergence { time, fix: fix(findings, &module), module, why })
    }
}

impl std::fmt::Display for Divergence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Divergence { module, why, time, fix } = self;
        let fix = fix.as_ref().map(|f| format!("; {f}")).unwrap_or_default();
        write!(f, "the model diverged at {time:.4} s, silence after that: `{module}`: {why}{fix}")
    }
}

/// What the warnings of the compiler offer against the divergence of `module`: those that name it come first.
fn fix(findings: &Diags, module: &str) -> Option<String> {
    let list = || findings.list.iter();
    let about = |d: &&ca_model::diag::Diag| matches!(d.code, "W103" | "W104" | "W107" | "W110" | "W105" | "W117");
    let named = format!("`{module}`");
    let d = list().filter(about).find(|d| d.title.contains(&named)).or_else(|| list().find(about))?;
    d.help.clone()
}

/// The time that it was played \[s\]: `seconds`, or less, to the millisecond, if fewer than `frames` were played.
pub fn lasted(scene: &Scene, played: &Played, frames: u64, seconds: f64) -> f64 {
    if played.frames < frames { (played.frames as f64 * scene.rates.sample_dt * 1e3).round() / 1e3 } else { seconds }
}

/// What to say of each live parameter that stayed at the end of its range, since its gesture went beyond.
pub fn clamped(p: &Performance) -> Vec<String> {
    let one = |(param, v): (&LiveParam, f64)| {
        let show = |v: f64| quantity::show(v, param.unit).trim_end().to_owned();
        let (least, bound) = if v > param.max { (false, param.max) } else { (true, param.min) };
        let (name, most) = (&param.name, if least { "least" } else { "most" });
        let what = format!("the gesture of `{name}` asks for {}, it is {} at {most}", show(v), show(bound));
        format!("{what} and stayed there; numbers of a gesture are in SI units")
    };
    p.clamped().map(one).collect()
}

/// The residual of a ledger, as a part of its peak.
pub fn relative(b: &Balance) -> f64 {
    if b.peak > 0.0 { b.residual.abs() / b.peak } else { 0.0 }
}

/// A residual of the ledger beyond this part of what went through it is none of rounding, which leaves bundled models
/// below 1e-12.
const UNBALANCED: f64 = 1e-6;

/// A residual that nobody asks about \[J\]: what rounding of places leaves of a motion of nanometres.
const NOTHING: f64 = 1e-24;

/// The residual of a ledger, where that is more than rounding makes of what went through it \[J\].
pub fn unbalanced(b: &Balance) -> Option<f64> {
    let through = [b.h0, b.h, b.work, b.lost, b.scheme_error, b.changed].map(f64::abs);
    let scale = through.into_iter().fold(b.peak, f64::max);
    // a residual that is not a number is none that rounding makes
    let balances = b.residual.abs() <= (UNBALANCED * scale).max(NOTHING);
    (!balances).then_some(b.residual)
}

/// The energy made by the scheme, if it exceeds the energy received from load, ports, changes and weight \[J\]. The sound is then
/// an error of the scheme.
pub fn made(b: &Balance) -> Option<f64> {
    (b.scheme_error > b.received.max(NOTHING)).then_some(b.scheme_error)
}

/// A message if the scheme made more energy than it received.
pub fn gained(b: &Balance) -> Option<String> {
    let made = made(b)?;
    let mend = "use `method = \"stable\"` for its contacts, or raise the sound rate";
    Some(format!("its scheme made {made:.3e} J, more than the {:.3e} J that it received: {mend}", b.received))
}

/// The gain that would just fit, three digits, towards zero.
pub fn gain(peak: f64) -> f64 {
    let ten = (1.0 / peak).log10().floor() - 2.0;
    let n = (1.0 / peak / 10f64.powf(ten)).floor();
    format!("{n}e{ten}").parse().unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_balances_to_rounding_of_what_went_through_it() {
        let b = Balance { h0: 2e-3, h: 1e-3, lost: 1e-3, peak: 2e-3, ..Balance::default() };
        assert_eq!(unbalanced(&b), None);
        assert_eq!(unbalanced(&Balance { residual: 1e-12, ..b }), None);
        assert_eq!(unbalanced(&Balance { residual: -3e-4, ..b }), Some(-3e-4));
        assert!(unbalanced(&Balance { residual: f64::NAN, ..b }).is_some_and(f64::is_nan));
        // a scene that never had energy to speak of, through which much went
        assert_eq!(
            unbalanced(&Balance { residual: 1e-9, work: 5e-3, lost: 5e-3, peak: 1e-8, ..Balance::default() }),
            None
        );
        assert_eq!(unbalanced(&Balance::default()), None);
        assert_eq!(unbalanced(&Balance { residual: 5e-35, work: 2e-31, ..Balance::default() }), None);
    }
}
