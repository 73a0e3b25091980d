//! `ca completions`: what makes a shell complete.

use crate::args::CompletionsArgs;
use crate::outcome::{Ended, Failure, Outcome};
use clap_complete::env::Shells;

/// The variable by which the script asks for candidates, as `main` knows it.
const ASKED_BY: &str = "COMPLETE";

/// Runs the command.
pub fn run(args: &CompletionsArgs) -> Outcome {
    let name = args.shell.to_string();
    let shells = Shells::builtins();
    let shell = shells.completer(&name).ok_or_else(|| Failure::Usage(format!("`{name}` cannot ask a program")))?;
    // by its plain name: a line that begins with `ca` found it so
    shell.write_registration(ASKED_BY, "ca", "ca", "ca", &mut std::io::stdout().lock())?;
    Ok(Ended::Well)
}
