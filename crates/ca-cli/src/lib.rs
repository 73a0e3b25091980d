//! The command `ca` as a library: models in text to sound, findings and pages.
//!
//! Every command shares its exit codes (0 ok, 1 failed, 2 usage, 3 finished but degraded, 130 interrupted). Results go to stdout,
//! everything about them to stderr, and a reader of stdout that goes away is not a failure. A command is a file or folder of
//! `commands/` whose `run` returns an outcome.
#![forbid(unsafe_code)]

mod args;
mod cli;
mod commands;
mod load;
mod outcome;
mod outputs;
mod page;
mod term;

use clap::FromArgMatches as _;
use cli::Cli;
use commands::Command;
use outcome::{Ended, Failure};
use std::ffi::OsString;
use std::io::Write as _;

/// Runs the command with these arguments, its name first, and returns its exit code. Results go to stdout,
/// messages to stderr. A shell that completes a line asks by the variable `COMPLETE` and gets only its answer.
pub fn run(args: impl IntoIterator<Item = OsString>) -> u8 {
    let args: Vec<OsString> = args.into_iter().collect();
    let here = std::env::current_dir().ok();
    let completion = clap_complete::CompleteEnv::with_factory(cli::command);
    match completion.try_complete(args.iter().cloned(), here.as_deref()) {
        Ok(true) => return 0,
        Ok(false) => {}
        Err(e) => {
            let _ = e.print();
            return 2;
        }
    }
    let read = cli::command().try_get_matches_from(args).and_then(|m| {
        term::explaining(!cli::is_terse(&m));
        Cli::from_arg_matches(&m)
    });
    let cli = match read {
        Ok(cli) => cli,
        Err(e) => {
            let _ = e.print();
            return if e.use_stderr() { 2 } else { 0 };
        }
    };
    let ended = vectors().and_then(|()| commands::run(&cli.command));
    // a program that is not in Rust ends without this
    let _ = std::io::stdout().flush();
    match ended {
        Ok(Ended::Well) | Err(Failure::BrokenPipe) => 0,
        Ok(Ended::Degraded) => 3,
        Err(Failure::Reported) => 1,
        Err(Failure::Interrupted(what)) => {
            term::note(&what);
            130
        }
        Err(Failure::Failed(what)) => {
            term::error(&what);
            1
        }
        Err(Failure::Usage(what)) => {
            term::error(&what);
            2
        }
    }
}

/// The performance that arguments of `ca play` ask for, for a program that plays in its own process. `read` gives the model,
/// to which `changes` are made as by `--set`.
///
/// # Errors
/// [`ca_lab::Failure::Failed`] with the usage of the command if the arguments make no sense, and the errors of `read`.
pub fn play_request(
    name: &str,
    args: impl IntoIterator<Item = OsString>,
    read: ca_live::Reader,
    changes: Vec<(String, String)>,
) -> Result<ca_live::Request, ca_lab::Failure> {
    let words = ["ca".into(), "play".into(), OsString::from(name)].into_iter().chain(args);
    let failed = |e: clap::Error| ca_lab::Failure::Failed(e.to_string().trim_end().into());
    let cli = cli::command().try_get_matches_from(words).and_then(|m| Cli::from_arg_matches(&m)).map_err(failed)?;
    match cli.command {
        Command::Play(mut args) => {
            args.serve.source.set.splice(..0, changes);
            commands::serve::request(&args.serve, Some(commands::play::page(&args)), read)
        }
        _ => Err(ca_lab::Failure::Failed("these are not arguments of `ca play`".into())),
    }
}

/// Refuses other values of `CA_VECTORS`: a test with a misspelt one would compare a processor with itself.
fn vectors() -> Result<(), Failure> {
    match std::env::var_os("CA_VECTORS") {
        Some(asked) if asked != "portable" && asked != "avx2" => {
            Err(Failure::Usage(format!("CA_VECTORS: `{}` is neither `portable` nor `avx2`", asked.display())))
        }
        _ => Ok(()),
    }
}
