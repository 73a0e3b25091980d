//! The table of a conformance run: what was asked, whether it holds, and what was found.

use crate::args::ConformanceArgs;
use crate::outcome::{Ended, Failure, Outcome};
use serde_json::json;
use std::io::Write as _;

/// One thing that is asked of a device.
struct CheckRow {
    name: &'static str,
    pass: bool,
    found: String,
}

/// The table.
#[derive(Default)]
pub(super) struct CheckTable(Vec<CheckRow>);

impl CheckTable {
    pub(super) fn row(&mut self, name: &'static str, pass: bool, found: impl Into<String>) {
        self.0.push(CheckRow { name, pass, found: found.into() });
    }

    /// Prints the table; an error where something in it failed.
    pub(super) fn print(&self, args: &ConformanceArgs) -> Outcome {
        let failed = self.0.iter().filter(|r| !r.pass).count();
        let mut out = std::io::stdout().lock();
        if args.json {
            let rows: Vec<_> =
                self.0.iter().map(|r| json!({"name": r.name, "pass": r.pass, "found": r.found})).collect();
            writeln!(out, "{:#}", json!({"device": args.name, "pass": failed == 0, "rows": rows}))?;
        } else {
            for r in &self.0 {
                writeln!(out, "{:<5}{:<11}{}", if r.pass { "pass" } else { "FAIL" }, r.name, r.found)?;
            }
        }
        if failed > 0 {
            let what = format!("`{}` fails {failed} of {}", args.name, self.0.len());
            return Err(Failure::Failed(format!("{what}; an engine may hurt a hand through it, or be blind to it")));
        }
        Ok(Ended::Well)
    }
}
