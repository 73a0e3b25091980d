//! Judges a play by [`ca_io::play`]: its ledger, the cause of its divergence, its duration.

use ca_core::{Balance, Ledger, LiveParam, Scene};
use ca_io::gesture::Gesture;
pub use ca_io::length::Length;
use ca_io::perform::{DIVERGED, Performance};
pub use ca_io::perform::{frames, seconds};
pub use ca_io::play::{BLOCK, Played, Sink, play};
pub use ca_io::sound::Sample;
use ca_model::diag::Diags;
use ca_model::quantity;

/// Energy ledger and the time it covers.
pub struct Audit {
    /// Ledger at the end.
    pub ledger: Ledger,
    /// Ticks it covers.
    pub ticks: u64,
    /// True if it covers the whole play.
    pub complete: bool,
    /// True if the scene diverged at the end.
    pub diverged: bool,
}

/// Default time to audit \[s\]: long enough for a stroke and its decay. A whole second of a ledger takes longer than
/// the sound of some models (`benches/render.rs`).
const SECONDS: f64 = 0.5;

/// Limit of modules times ticks in an audit: a second of a string with a thousand masses. Larger scenes are audited for
/// less time, which the summary states.
const AUDITED: u64 = 100_000_000;

/// Ticks between two checks for divergence in an audit; a check takes half as long as a tick.
const LOOK: u64 = 64;

/// Plays the first half second again with the ledger, up to the last tick before any divergence.
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
        // it diverged since the last check: play again up to the exact tick
        p = bounded(1)?;
    }
    let entered = p.state.tick.saturating_sub(1);
    let diverged = !p.state.is_bounded(DIVERGED);
    p.player.state.ledger.map(|ledger| Audit { ledger: *ledger, ticks: entered, complete: false, diverged })
}

/// Divergence of a scene, with its cause.
pub struct Divergence {
    /// Time \[s\].
    pub time: f64,
    /// Module that caused it.
    pub module: String,
    /// Reason.
    pub why: String,
    /// Remedy, if the certificate offers one.
    pub fix: Option<String>,
}

impl Divergence {
    /// Finds the cause where `played` diverged. `audited` is its scene, with the ledger if there is one; `findings` are
    /// the findings of the compiler.
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

/// Returns the remedy that a warning of the compiler offers; warnings that name `module` come first.
fn fix(findings: &Diags, module: &str) -> Option<String> {
    let list = || findings.list.iter();
    let about = |d: &&ca_model::diag::Diag| matches!(d.code, "W103" | "W104" | "W107" | "W110" | "W105" | "W117");
    let named = format!("`{module}`");
    let d = list().filter(about).find(|d| d.title.contains(&named)).or_else(|| list().find(about))?;
    d.help.clone()
}

/// Duration of a play \[s\]: `seconds`, or to the millisecond what was played if it has fewer than `frames`.
pub fn lasted(scene: &Scene, played: &Played, frames: u64, seconds: f64) -> f64 {
    if played.frames < frames { (played.frames as f64 * scene.rates.sample_dt * 1e3).round() / 1e3 } else { seconds }
}

/// Messages about live parameters held at an end of their range because the gesture went beyond.
pub fn clamped(p: &Performance) -> Vec<String> {
    let one = |(param, v): (&LiveParam, f64)| {
        let show = |v: f64| quantity::show(v, param.unit).trim_end().to_owned();
        let (least, bound) = if v > param.max { (false, param.max) } else { (true, param.min) };
        let (name, most) = (&param.name, if least { "minimum" } else { "maximum" });
        let what = format!("the gesture sets `{name}` to {}, but its {most} is {}", show(v), show(bound));
        format!("{what}, which was used instead; numbers in a gesture are in SI units")
    };
    p.clamped().map(one).collect()
}

/// Residual of a ledger, relative to its peak.
pub fn relative(b: &Balance) -> f64 {
    if b.peak > 0.0 || !b.residual.is_finite() { b.residual.abs() / b.peak } else { 0.0 }
}

/// Residual, relative to the energy through the ledger, that exceeds rounding. Bundled models stay below 1e-12.
const UNBALANCED: f64 = 1e-6;

/// Residual that is always ignored \[J\]: the rounding of positions in motions of nanometres.
const NOTHING: f64 = 1e-24;

/// Returns the residual of the ledger where it exceeds rounding \[J\].
pub fn unbalanced(b: &Balance) -> Option<f64> {
    let through = [b.h0, b.h, b.work, b.lost, b.scheme_error, b.changed].map(f64::abs);
    let scale = through.into_iter().fold(b.peak, f64::max);
    // also true of a residual that is not a number
    let balances = b.residual.abs() <= (UNBALANCED * scale).max(NOTHING);
    (!balances).then_some(b.residual)
}

/// Returns the energy made by the scheme \[J\] if it exceeds the energy received from load, ports, changes and weight.
/// The sound is then an error of the scheme.
pub fn made(b: &Balance) -> Option<f64> {
    (b.scheme_error > b.received.max(NOTHING)).then_some(b.scheme_error)
}

/// Returns a message if the scheme made more energy than it received.
pub fn gained(b: &Balance) -> Option<String> {
    let made = made(b)?;
    let mend = "use `method = \"stable\"` for the contacts, or raise the sound rate";
    Some(format!(
        "the numerical scheme created {made:.3e} J, more than the {:.3e} J that the model received: {mend}",
        b.received
    ))
}

/// Largest gain at which the sound fits, rounded down to three digits.
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
        assert!(relative(&Balance { residual: f64::NAN, ..Balance::default() }).is_nan(), "not exactly 0");
        // a scene whose energy is always small although much passes through it
        assert_eq!(
            unbalanced(&Balance { residual: 1e-9, work: 5e-3, lost: 5e-3, peak: 1e-8, ..Balance::default() }),
            None
        );
        assert_eq!(unbalanced(&Balance::default()), None);
        assert_eq!(unbalanced(&Balance { residual: 5e-35, work: 2e-31, ..Balance::default() }), None);
    }
}
