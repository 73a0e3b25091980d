//! The command `ca`: models in text to sound, findings and pages.
//!
//! Decides what every command shares: exit codes (0 ok, 1 failed, 2 usage, 3 finished but degraded), where things are
//! printed (results on stdout, everything about them on stderr), and that a reader who goes away is no failure. A command is
//! a file or folder of `commands/` whose `run` gives back an [`outcome`].
#![forbid(unsafe_code)]

mod args;
mod commands;
mod load;
mod outcome;
mod page;
mod store;
mod term;
mod watch;

use args::{Cli, Command};
use clap::FromArgMatches as _;
use outcome::{Ended, Failure, Outcome};
use std::process::ExitCode;

fn main() -> ExitCode {
    // a shell that completes asks by a variable, gets its answer and no more
    clap_complete::CompleteEnv::with_factory(args::command).complete();
    let read = args::command().try_get_matches().and_then(|m| {
        term::explaining(!args::is_terse(&m));
        Cli::from_arg_matches(&m)
    });
    let cli = match read {
        Ok(cli) => cli,
        Err(e) => {
            let _ = e.print();
            return ExitCode::from(if e.use_stderr() { 2 } else { 0 });
        }
    };
    match vectors().and_then(|()| run(&cli.command)) {
        Ok(Ended::Well) | Err(Failure::BrokenPipe) => ExitCode::SUCCESS,
        Ok(Ended::Degraded) => ExitCode::from(3),
        Err(Failure::Reported) => ExitCode::from(1),
        Err(Failure::Interrupted(what)) => {
            term::note(&what);
            ExitCode::from(130)
        }
        Err(Failure::Failed(what)) => {
            term::error(&what);
            ExitCode::from(1)
        }
        Err(Failure::Usage(what)) => {
            term::error(&what);
            ExitCode::from(2)
        }
    }
}

/// Refuses what `CA_VECTORS` may not be, since whoever misspells it would compare a processor with itself.
fn vectors() -> Result<(), Failure> {
    match std::env::var_os("CA_VECTORS") {
        Some(asked) if asked != "portable" && asked != "avx2" => {
            Err(Failure::Usage(format!("CA_VECTORS: `{}` is neither `portable` nor `avx2`", asked.display())))
        }
        _ => Ok(()),
    }
}

fn run(command: &Command) -> Outcome {
    match command {
        Command::Render(a) => commands::render::run(a),
        Command::Check(a) => commands::check::run(a),
        Command::Modes(a) => commands::modes::run(a),
        Command::Accuracy(a) => commands::accuracy::run(a),
        Command::Bench(a) => commands::bench::run(a),
        Command::Sweep(a) => commands::sweep::run(a),
        Command::Tune(a) => commands::tune::run(a),
        Command::Fit(a) => commands::fit::run(a),
        Command::Report(a) => commands::report::run(a),
        Command::Equiv(a) => commands::equiv::run(a),
        Command::List(a) => commands::list::run(a),
        Command::Explain(a) => commands::explain::run(a),
        Command::New(a) => commands::new::run(a),
        Command::Import(a) => commands::import::run(a),
        Command::Play(a) => commands::play::run(a),
        Command::Serve(a) => commands::serve::run(a),
        Command::Set(a) => commands::control::set(a),
        Command::Audio(a) => commands::control::audio(a),
        Command::Arm(a) => commands::control::arm(a),
        Command::Disarm(a) => commands::control::disarm(a),
        Command::Status(a) => commands::control::status(a),
        Command::Stop(a) => commands::control::stop(a),
        Command::Replay(a) => commands::replay::run(a),
        Command::Log(a) => commands::log::run(a),
        Command::Device(a) => commands::device::run(a),
        Command::Shm(a) => commands::shm::run(a),
        Command::Completions(a) => commands::completions::run(a),
    }
}
