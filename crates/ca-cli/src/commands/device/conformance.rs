//! `ca device conformance`: tests a device process and prints the table.

use super::ConformanceArgs;
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_device_tools::Message;
use ca_device_tools::conformance::{self, Conformance};
use serde_json::json;
use std::io::Write as _;

/// Runs the command.
pub fn run(args: &ConformanceArgs) -> Outcome {
    if !(args.force >= 0.0 && args.force.is_finite()) {
        return Err(Failure::Usage("--force: expected a force in newtons, 0 or more".into()));
    }
    let other = args.profile.iter().find(|g| g.split_once('=').is_some_and(|(device, _)| device != args.name));
    if let Some(given) = other {
        return Err(Failure::Usage(format!(
            "--profile {given}: the tested device is `{}`; give its profile",
            args.name
        )));
    }
    let asked = Conformance { name: args.name.clone(), profile: args.profile.clone(), force: args.force };
    let table = conformance::run(&asked, &mut |message| match message {
        Message::Note(_) if args.json => {}
        message => term::message(message),
    })?;
    let failed = table.failed();
    let mut out = std::io::stdout().lock();
    if args.json {
        let rows: Vec<_> =
            table.rows.iter().map(|r| json!({"name": r.name, "pass": r.pass, "found": r.found})).collect();
        writeln!(out, "{:#}", json!({"device": args.name, "pass": failed == 0, "rows": rows}))?;
    } else {
        for r in &table.rows {
            writeln!(out, "{:<5}{:<11}{}", if r.pass { "pass" } else { "FAIL" }, r.name, r.found)?;
        }
    }
    if failed > 0 {
        let what = format!("`{}` fails {failed} of {} tests", args.name, table.rows.len());
        return Err(Failure::Failed(format!(
            "{what}; with this device, the engine may hurt a hand or miss its motion"
        )));
    }
    Ok(Ended::Well)
}
