//! Outcome of a play, as a word and a line.
//!
//! The worst failure is reported: a diverged sound is not also called too loud, and inputs without a value are reported
//! only where nothing is worse.

use crate::load::{Loaded, compiled};
use crate::play::{Divergence, Played, gained};
use ca_compile::Options;
use ca_core::Scene;
use ca_io::gesture::Gesture;
use ca_io::sound::Level;
use ca_model::diag::Diags;

const MUTE: &str = "the model has no output; add one with `[SOX]`";

/// Outcome of a play.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// One of `ok`, `clipped`, `unstable`, `refused` (an input lacked a value), `mute` (neither outputs nor probes),
    /// `gained` (by the energy ledger, the scheme made more than it received) or `invalid` (does not compile).
    pub status: &'static str,
    /// Description of the failure; empty without one.
    pub message: String,
    /// Time of divergence \[s\] and the module that caused it.
    pub failed: Option<(f64, String)>,
}

impl Outcome {
    /// Outcome of a scene that cannot be compiled or played.
    pub fn invalid(message: String) -> Outcome {
        Outcome { status: "invalid", message, failed: None }
    }

    /// Judges a play, with the findings of the compiler. A scene that diverged is compiled again from `loaded` and
    /// `options`, with the energy ledger, to find the module that caused it.
    pub fn of(
        played: &Played,
        level: &Level,
        (scene, findings): (&Scene, &Diags),
        (loaded, options): (&Loaded, &Options),
        gesture: Option<&Gesture>,
    ) -> Outcome {
        if played.diverged_at.is_some() {
            let options = Options { energy: true, probes: Vec::new(), ..options.clone() };
            let audited = compiled(loaded, &options).0;
            let scene_audited = audited.as_ref().unwrap_or(scene);
            if let Some(d) = Divergence::of(played, scene_audited, findings, gesture) {
                return Outcome { status: "unstable", message: d.to_string(), failed: Some((d.time, d.module)) };
            }
        }
        let outcome = Outcome::judge(level, played.performance.state.ports.refused, scene.counts.n_out > 0);
        match played.energy.as_ref().and_then(|ledger| gained(&ledger.balance())) {
            Some(message) if outcome.status == "ok" => Outcome { status: "gained", message, failed: None },
            _ => outcome,
        }
    }

    /// Judges a play without divergence, by its levels, its refused inputs, and whether it has outputs or probes.
    pub fn judge(level: &Level, refused: u64, listened: bool) -> Outcome {
        let ended = |status, message| Outcome { status, message, failed: None };
        if level.clipped + level.non_finite > 0 {
            let (clipped, none) = (level.clipped, level.non_finite);
            let most = level.peak.iter().copied().fold(0.0, f64::max);
            let above = if clipped > 0 {
                format!("; the loudest is {:.1} dB too loud: lower `gain`", 20.0 * most.log10())
            } else {
                String::new()
            };
            return ended("clipped", format!("{clipped} samples beyond full scale, {none} not finite{above}"));
        }
        match refused {
            0 if listened => ended("ok", String::new()),
            0 => ended("mute", MUTE.into()),
            refused => ended("refused", format!("{refused} input values were not finite")),
        }
    }
}
