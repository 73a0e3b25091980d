//! The command `ca`: models in text to sound, findings and pages.
//!
//! Decides what every command shares: exit codes (0 ok, 1 failed, 2 usage, 3 finished but degraded), where things are
//! printed (results on stdout, everything about them on stderr), and that a reader who goes away is no failure. A command is one file of `commands/` with one function `run`.
#![forbid(unsafe_code)]

mod args;
mod commands;
mod load;
mod page;
mod store;
mod term;
mod watch;

use args::{Cli, Command};
use ca_haptic::host::{HostError, HostErrorKind};
pub use ca_lab::catalog;
use clap::FromArgMatches as _;
use std::process::ExitCode;

/// How a command ended where it did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// as asked
    Well,
    /// something was made, but not what was meant: unstable, clipped, inputs refused
    Degraded,
}

/// Why a command failed. What is said ends up on stderr.
#[derive(Debug)]
pub enum Failure {
    /// the request makes no sense: exit code 2
    Usage(String),
    /// the request could not be done: exit code 1
    Failed(String),
    /// as before, but all is already said: exit code 1
    Reported,
    /// somebody pressed Ctrl-C: exit code 130, as of any command that ends so
    Interrupted,
    /// the reader of stdout went away
    BrokenPipe,
}

impl From<std::io::Error> for Failure {
    fn from(e: std::io::Error) -> Failure {
        match e.kind() {
            std::io::ErrorKind::BrokenPipe => Failure::BrokenPipe,
            _ => Failure::Failed(format!("stdout cannot be written: {e}")),
        }
    }
}

impl From<ca_io::FileError> for Failure {
    fn from(e: ca_io::FileError) -> Failure {
        match e.kind {
            ca_io::FileErrorKind::Usage | ca_io::FileErrorKind::Unsupported => Failure::Usage(e.to_string()),
            _ => Failure::Failed(e.to_string()),
        }
    }
}

impl From<ca_lab::Failure> for Failure {
    fn from(e: ca_lab::Failure) -> Failure {
        match e {
            ca_lab::Failure::Usage(what) => Failure::Usage(what),
            ca_lab::Failure::Failed(what) => Failure::Failed(what),
            ca_lab::Failure::Stopped => Failure::Interrupted,
            ca_lab::Failure::Found(found) => {
                term::findings(&found.diags, &found.model);
                Failure::Reported
            }
        }
    }
}

impl From<HostError> for Failure {
    fn from(e: HostError) -> Failure {
        match e.kind {
            HostErrorKind::Site | HostErrorKind::Name => Failure::Usage(e.to_string()),
            _ => Failure::Failed(e.to_string()),
        }
    }
}

/// What every command gives back.
pub type Outcome = Result<Ended, Failure>;

fn main() -> ExitCode {
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
    let outcome = match &cli.command {
        Command::Render(a) => commands::render::run(a),
        Command::Check(a) => commands::check::run(a),
        Command::Modes(a) => commands::modes::run(a),
        Command::Accuracy(a) => commands::accuracy::run(a),
        Command::Bench(a) => commands::bench::run(a),
        Command::Sweep(a) => commands::sweep::run(a),
        Command::Tune(a) => commands::tune::run(a),
        Command::Report(a) => commands::report::run(a),
        Command::Equiv(a) => commands::equiv::run(a),
        Command::List(a) => commands::list::run(a),
        Command::Explain(a) => commands::explain::run(a),
        Command::New(a) => commands::new::run(a),
        Command::Import(a) => commands::import::run(a),
        Command::Play(a) => commands::play::run(a),
        Command::Serve(a) => commands::serve::run(a),
        Command::Set(a) => commands::control::set(a),
        Command::Arm(a) => commands::control::arm(a),
        Command::Disarm(a) => commands::control::disarm(a),
        Command::Status(a) => commands::control::status(a),
        Command::Stop(a) => commands::control::stop(a),
        Command::Replay(a) => commands::replay::run(a),
        Command::Log(a) => commands::log::run(a),
        Command::Device(a) => commands::device::run(a),
        Command::Shm(a) => commands::shm::run(a),
    };
    match outcome {
        Ok(Ended::Well) | Err(Failure::BrokenPipe) => ExitCode::SUCCESS,
        Ok(Ended::Degraded) => ExitCode::from(3),
        Err(Failure::Reported) => ExitCode::from(1),
        Err(Failure::Interrupted) => ExitCode::from(130),
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
