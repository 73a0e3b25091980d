//! The energy ledger over the time of a performance, looked at now and then.
//!
//! Decides to show the residual by itself, as a part of the largest energy so far: it is ten orders of magnitude below
//! the rest, and the one curve that tests the engine.

use crate::commands::render::{joule, makers, relative};
use ca_core::Scene;
use ca_core::energy::{Balance, Ledger};
use ca_report::{Axis, Block, Curve, Grid, Plot, Section, Table};

/// The ledger at several times.
#[derive(Default)]
pub(super) struct EnergyOverTime {
    /// \[s\]
    times: Vec<f64>,
    /// sums, and the part in motion \[J\]
    sums: Vec<(Balance, f64)>,
    /// the ledger at the end
    pub end: Option<Ledger>,
}

impl EnergyOverTime {
    /// Notes what the ledger says at a time \[s\].
    pub fn look(&mut self, time: f64, ledger: Option<&Ledger>) {
        if let Some(ledger) = ledger {
            self.times.push(time);
            self.sums.push((ledger.balance(), ledger.kinetic));
        }
    }

    /// The section, in joules that are `scale` times those of the model; `None` where no ledger was kept.
    pub fn section(&self, scene: &Scene, scale: f64) -> Option<Section> {
        let end = self.end.as_ref()?;
        let b = end.balance();
        let grid = || Grid::Points(self.times.clone());
        let curve = |name: &str, of: fn(&(Balance, f64)) -> f64| {
            let y: Vec<f64> = self.sums.iter().map(|s| scale * of(s)).collect();
            // an account in which nothing happened is no curve
            y.iter().any(|v| *v != 0.0).then(|| Curve::line(name, y))
        };
        let accounts = [
            curve("held", |s| s.0.h),
            curve("of it in motion", |s| s.1),
            curve("lost", |s| s.0.lost),
            curve("received from ports", |s| s.0.work),
            curve("received by changes", |s| s.0.changed),
            curve("made by the scheme", |s| s.0.source),
        ];
        let curves: Vec<Curve> = accounts.into_iter().flatten().collect();
        let rest = vec![Curve::line("residual", self.sums.iter().map(|s| relative(&s.0)).collect())];
        let closes = match relative(&b) {
            _ if b.peak == 0.0 => "Nothing moved, so there is no energy.".into(),
            0.0 => "The ledger balances exactly.".into(),
            rel => format!("The ledger balances to {rel:.1e} of its peak, {}.", joule(scale * b.peak)),
        };
        let mut rows = vec![
            ("at load", joule(scale * b.h0)),
            ("received from ports", joule(scale * b.work)),
            ("received by changes", joule(scale * b.changed)),
            ("lost", joule(scale * b.lost)),
            ("made by the scheme", joule(scale * b.source)),
            ("held", joule(scale * b.h)),
            ("residual", format!("{:.1e} J", scale * b.residual)),
        ];
        let makers = makers(scene, end);
        rows.extend(
            makers.iter().take(5).map(|(name, made)| ("most of it by", format!("`{name}`: {}", joule(scale * made)))),
        );
        let mut blocks = vec![Block::Text(closes)];
        if !curves.is_empty() {
            blocks.push(Block::Plot(Plot::over_time("Energy", Axis::linear("energy", "J"), grid(), curves)));
            let axis = Axis::log("residual / peak", "");
            blocks.push(Block::Plot(Plot::over_time("What does not add up", axis, grid(), rest)));
        }
        blocks.push(Block::Table(Table::pairs(rows)));
        Some(Section::new("Energy", blocks))
    }
}
