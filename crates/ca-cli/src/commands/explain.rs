//! `ca explain`: explains a finding by its code.
//!
//! Titles and pages come from `ca-model`, which defines the codes.

use crate::args::completions;
use crate::outcome::{Ended, Failure, Outcome};
use ca_model::diag::{CODES, Severity};
use ca_model::explain::{page, severity};
use ca_model::suggest::nearest;
use clap::Args;
use clap_complete::ArgValueCompleter;
use serde_json::{Value as Json, json};
use std::fmt::Write as _;
use std::io::Write as _;

/// Explains a finding by its code
///
/// Prints the page of a code such as E013: what it means, examples of models with the finding, the message for each,
/// and how to fix it. Without a code, lists all codes with their titles. Codes with E are errors, which prevent
/// compilation, codes with W are warnings, and codes with N are notes. The pages are part of this program.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca explain
  ca explain E013
  ca explain w103 --json")]
pub struct ExplainArgs {
    /// The code, shown in brackets after `error`, `warning` or `note`
    #[arg(add = ArgValueCompleter::new(completions::codes))]
    pub code: Option<String>,
    /// Prints the page or the list as JSON
    #[arg(long)]
    pub json: bool,
}

/// Severities with their heading in the list and their word in the JSON of `ca check --json`.
const GROUPS: [(Severity, &str, &str); 3] = [
    (Severity::Error, "Errors: the model is not compiled", "error"),
    (Severity::Warning, "Warnings: the model is compiled, but is probably not as intended", "warning"),
    (Severity::Note, "Notes: worth knowing", "note"),
];

/// Runs the command.
pub fn run(args: &ExplainArgs) -> Outcome {
    let text = match args.code.as_deref() {
        Some(code) => one(code.trim(), args.json)?,
        None if args.json => format!("{:#}\n", Json::Array(CODES.iter().map(|(c, t)| entry(c, t)).collect())),
        None => list(),
    };
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(Ended::Well)
}

fn one(code: &str, json: bool) -> Result<String, Failure> {
    let Some(page) = page(code) else {
        let hint = match nearest(code, CODES.iter().map(|c| c.0)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`ca explain` lists all codes".into(),
        };
        return Err(Failure::Usage(format!("`{code}` is not the code of a finding; {hint}")));
    };
    if json {
        let mut all = entry(page.code, page.title);
        all["text"] = page.text().into();
        return Ok(format!("{all:#}\n"));
    }
    Ok(format!("{} {}\n\n{}", page.code, page.title, page.plain()))
}

fn entry(code: &str, title: &str) -> Json {
    let word = GROUPS.iter().find(|g| g.0 == severity(code)).map(|g| g.2);
    json!({"code": code, "severity": word, "title": title})
}

fn list() -> String {
    let mut out = String::new();
    for (group, heading, _) in GROUPS {
        let _ = writeln!(out, "{heading}");
        for (code, title) in CODES.iter().filter(|c| severity(c.0) == group) {
            let _ = writeln!(out, "  {code}  {title}");
        }
        out.push('\n');
    }
    out + "`ca explain E013` explains one of them.\n"
}
