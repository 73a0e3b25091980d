//! Energy ledger over the time of a performance, sampled at intervals.
//!
//! The residual has its own plot, relative to the peak energy: it is ten orders of magnitude smaller than the other
//! terms, and it is the curve that tests the engine. If the model diverges, the ledger is shown only while its energy
//! is comparable with the energy supplied. Later values measure only the divergence.

use ca_core::{Balance, Ledger, Scene};
use ca_lab::facts::energy::{grows, joule, makers};
use ca_lab::play::relative;
use ca_report::{Axis, Block, Curve, Grid, Plot, Section, Table};

/// Ratio of energy to supplied energy above which a diverged ledger is cut off.
const DIVERGED: f64 = 1e6;

/// Samples of the ledger.
#[derive(Default)]
pub(crate) struct EnergyOverTime {
    /// Times of the samples \[s\].
    times: Vec<f64>,
    /// Balance and kinetic energy \[J\].
    sums: Vec<(Balance, f64)>,
    /// Ledger at the end.
    pub end: Option<Ledger>,
    /// Time at which the model diverged \[s\].
    pub diverged_at: Option<f64>,
}

impl EnergyOverTime {
    /// Samples the ledger at `time` \[s\].
    pub fn look(&mut self, time: f64, ledger: Option<&Ledger>) {
        if let Some(ledger) = ledger {
            self.times.push(time);
            self.sums.push((ledger.balance(), ledger.kinetic));
        }
    }

    /// Builds the section, with joules multiplied by `scale`. Returns `None` without a ledger.
    pub fn section(&self, scene: &Scene, scale: f64) -> Option<Section> {
        let end = self.end.as_ref()?;
        let tame = |(b, motion): &&(Balance, f64)| {
            let given = b.h0.abs().max(b.work.abs()).max(b.changed.abs());
            self.diverged_at.is_none() || b.peak.max(motion.abs()) <= DIVERGED * given
        };
        let blown = format!("The model diverged at {:.4} s{}", self.diverged_at.unwrap_or_default(), grows(scene, end));
        let sums: Vec<&(Balance, f64)> = self.sums.iter().take_while(tame).collect();
        let Some((b, last)) = (match self.diverged_at {
            None => Some((end.balance(), f64::INFINITY)),
            Some(_) => sums.last().map(|s| (s.0, self.times[sums.len() - 1])),
        }) else {
            let early = format!("{blown}. This is too early to show the energy.");
            return Some(Section::new("Energy", vec![Block::Text(early)]));
        };
        let grid = || Grid::Points(self.times[..sums.len()].to_vec());
        let curve = |name: &str, of: fn(&(Balance, f64)) -> f64| {
            let y: Vec<f64> = sums.iter().map(|s| scale * of(s)).collect();
            // leaves out accounts that stay zero
            y.iter().any(|v| *v != 0.0).then(|| Curve::line(name, y))
        };
        let accounts = [
            curve("stored", |s| s.0.h),
            curve("stored, kinetic", |s| s.1),
            curve("lost", |s| s.0.lost),
            curve("received from ports", |s| s.0.work),
            curve("received by changes", |s| s.0.changed),
            curve("error of the scheme", |s| s.0.scheme_error),
        ];
        let curves: Vec<Curve> = accounts.into_iter().flatten().collect();
        let rest = vec![Curve::line("residual", sums.iter().map(|s| relative(&s.0)).collect())];
        let balance = match relative(&b) {
            _ if self.diverged_at.is_some() => {
                format!(
                    "{blown}. The ledger covers the time up to {last:.4} s, while the energy was comparable to the energy \
                     supplied."
                )
            }
            rel if !rel.is_finite() => {
                "The ledger does not balance: a sum of it is beyond the range of numbers.".into()
            }
            _ if b.peak == 0.0 => "Nothing moved, so the energy is zero.".into(),
            0.0 => "The ledger balances exactly.".into(),
            rel => format!("The ledger balances to {rel:.1e} of its peak, {}.", joule(scale * b.peak)),
        };
        let mut rows = vec![
            ("at load", joule(scale * b.h0)),
            ("received from ports", joule(scale * b.work)),
            ("received by changes", joule(scale * b.changed)),
            ("lost", joule(scale * b.lost)),
            ("error of the scheme", joule(scale * b.scheme_error)),
            ("stored", joule(scale * b.h)),
            ("residual", format!("{:.1e} J", scale * b.residual)),
        ];
        if b.strayed > 0.0 {
            rows.push(("contacts in space off their potential, at most", joule(scale * b.strayed)));
        }
        // per-link ledgers exist only for the end
        let makers = if self.diverged_at.is_none() { makers(scene, end, 5) } else { Vec::new() };
        let row = |(name, made): &(String, f64)| {
            ("largest error of the scheme", format!("`{name}`: {}", joule(scale * made)))
        };
        rows.extend(makers.iter().map(row));
        let mut blocks = vec![Block::Text(balance)];
        if !curves.is_empty() {
            blocks.push(Block::Plot(Plot::over_time("Energy", Axis::linear("energy", "J"), grid(), curves)));
            let axis = Axis::log("residual / peak", "");
            blocks.push(Block::Plot(Plot::over_time("Residual", axis, grid(), rest)));
        }
        blocks.push(Block::Table(Table::pairs(rows)));
        Some(Section::new("Energy", blocks))
    }
}
