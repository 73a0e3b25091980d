//! The command `ca` as a library: turns text models into sound, findings and pages.
//!
//! All commands share their exit codes: 0 ok, 1 failed, 2 usage, 3 finished but degraded, 130 interrupted. Results go
//! to stdout and messages to stderr. A reader that closes stdout early does not cause a failure. Each command is a file
//! or folder of `commands/` whose `run` returns an outcome.
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

/// Runs the command with these arguments, its name first, and returns its exit code. Results go to stdout, messages to
/// stderr. If a shell requests completion through the variable `COMPLETE`, prints only the candidates.
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
    // a host program not written in Rust does not flush stdout at its exit
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

/// Builds the performance requested by arguments of `ca play`, for a program that plays in its process. `read` returns
/// the model, to which `changes` are applied as by `--set`.
///
/// # Errors
/// Returns [`ca_lab::Failure::Failed`] with the usage of the command if the arguments are invalid, and the errors of
/// `read`.
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
        Command::Play(args) if args.error_target.error.is_some() => Err(ca_lab::Failure::Failed(
            "--error: not available while a scene plays; choose the method before, with `Scene.within`".into(),
        )),
        Command::Play(mut args) => {
            args.serve.source.set.splice(..0, changes);
            commands::serve::request(&args.serve, Some(commands::play::page(&args)), read)
        }
        _ => Err(ca_lab::Failure::Failed("these are not arguments of `ca play`".into())),
    }
}

/// Refuses unknown values of `CA_VECTORS`. With a misspelt value, a test would compare a processor with itself.
fn vectors() -> Result<(), Failure> {
    match std::env::var_os("CA_VECTORS") {
        Some(asked) if asked != "portable" && asked != "avx2" => Err(Failure::Usage(format!(
            "CA_VECTORS: `{}` is neither `portable` nor `avx2`; set it to one of them, or unset it",
            asked.display()
        ))),
        _ => Ok(()),
    }
}
