//! Describes the energy ledger of a scene.

use ca_core::{Ledger, Level, Scene};
use ca_model::quantity::short;

/// Formats an energy with three digits.
pub fn joule(v: f64) -> String {
    // avoids -0
    format!("{} J", short(v + 0.0))
}

/// Explains the growth of a model whose links made hardly any energy, as the end of a sentence.
pub fn grows(scene: &Scene, ledger: &Ledger) -> &'static str {
    let b = ledger.balance();
    let kept = b.scheme_error.abs() <= 1e-6 * b.peak;
    if kept && scene.certificate.level == Level::Unstable {
        ": above the limit of stability, motion grows although no energy is created"
    } else {
        ""
    }
}

/// Returns whether groups at the gesture rate have a border that may make energy.
pub fn compensated(scene: &Scene) -> bool {
    scene.rates.slow.as_ref().is_some_and(|g| g.compensated)
}

/// Returns the links that made most energy, at most `most`, in descending order.
pub fn makers(scene: &Scene, ledger: &Ledger, most: usize) -> Vec<(String, f64)> {
    let mut made: Vec<(usize, f64)> =
        ledger.scheme_error.iter().copied().enumerate().filter(|(_, v)| *v > 0.0).collect();
    made.sort_by(|a, b| b.1.total_cmp(&a.1));
    made.into_iter().filter_map(|(i, v)| Some((scene.audited_name(i)?.into_owned(), v))).take(most).collect()
}
