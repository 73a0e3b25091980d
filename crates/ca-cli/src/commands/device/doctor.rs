//! `ca device doctor`: examines this machine and prints what it lacks.

use crate::outcome::{Ended, Failure, Outcome};
use ca_device_tools::doctor;
use serde_json::json;
use std::io::Write as _;

/// Runs the command.
pub fn run(asked: bool) -> Outcome {
    let found = doctor::examine()?;
    let mut out = std::io::stdout().lock();
    if asked {
        let rows: Vec<_> = found
            .rows
            .iter()
            .map(|r| json!({"what": r.what, "state": r.state.name(), "found": r.found, "fix": r.fix}))
            .collect();
        let v = json!({
            "usable": found.is_usable(), "rows": rows, "late_us": found.late, "late_by_a_frame": found.late_by_a_frame,
        });
        writeln!(out, "{v:#}")?;
    } else {
        for r in &found.rows {
            writeln!(out, "{:<5}{:<11}{}", r.state.name(), r.what, r.found)?;
            if !r.fix.is_empty() {
                writeln!(out, "     {:<11}{}", "", r.fix)?;
            }
        }
    }
    if !found.is_usable() {
        return Err(Failure::Failed("devices cannot be played on this machine; apply the fixes listed above".into()));
    }
    Ok(Ended::Well)
}
