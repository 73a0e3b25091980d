//! The commands. Each has a file or folder with its arguments and `run`, except that `control.rs` holds the six that
//! talk to a running server. `border.rs` and `error_target.rs` serve several
//! commands.

use crate::outcome::Outcome;
use clap::Subcommand;

pub(crate) mod accuracy;
pub(crate) mod bench;
mod border;
pub(crate) mod check;
pub(crate) mod completions;
pub(crate) mod control;
pub(crate) mod device;
pub(crate) mod equiv;
mod error_target;
pub(crate) mod explain;
pub(crate) mod export;
pub(crate) mod fit;
pub(crate) mod import;
pub(crate) mod list;
pub(crate) mod modes;
pub(crate) mod new;
pub(crate) mod play;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod serve;
pub(crate) mod shm;
pub(crate) mod site;
pub(crate) mod sweep;
pub(crate) mod take;
pub(crate) mod tune;

/// Defines the subcommands with their arguments and `run` functions, in the order of `ca --help`. The help of a command is at its arguments. A doc
/// comment here would replace it, and is used only where several commands share their arguments.
macro_rules! commands {
    ($($(#[$help:meta])* $name:ident($args:path) => $run:path,)*) => {
        /// A command with its arguments.
        #[derive(Subcommand)]
        pub enum Command {
            $($(#[$help])* $name($args),)*
        }

        /// Runs a command.
        pub fn run(command: &Command) -> Outcome {
            match command {
                $(Command::$name(args) => $run(args),)*
            }
        }
    };
}

commands! {
    // Make and hear
    New(new::NewArgs) => new::run,
    Import(import::ImportArgs) => import::run,
    Check(check::CheckArgs) => check::run,
    Render(render::RenderArgs) => render::run,
    Report(report::ReportArgs) => report::run,
    Play(play::PlayArgs) => play::run,
    Export(export::ExportArgs) => export::run,
    Site(site::SiteArgs) => site::run,
    Set(control::SetArgs) => control::set,
    Audio(control::AudioArgs) => control::audio,
    /// Shows the state of a running `ca serve` or `ca play`
    ///
    /// Prints the number of gesture frames and sound samples played since the start, the mode of each device, why its
    /// forces are off, what an armed device is waiting for, and the number of lost records. With `--json`, it also
    /// prints the live parameters in SI units.
    Status(control::StatusArgs) => control::status,
    /// Ends a running `ca serve` or `ca play`
    ///
    /// Forces go to zero with the next gesture frame. The running command then finishes its sound file and its take,
    /// and prints its summary.
    Stop(control::StatusArgs) => control::stop,
    // Tune and measure
    Tune(tune::TuneArgs) => tune::run,
    Fit(fit::FitArgs) => fit::run,
    Modes(modes::ModesArgs) => modes::run,
    Accuracy(accuracy::AccuracyArgs) => accuracy::run,
    Bench(bench::BenchArgs) => bench::run,
    // Devices
    Serve(serve::ServeArgs) => serve::run,
    /// Turns on the forces of a running `ca serve` or `ca play`
    ///
    /// Forces then fade in within a second, as soon as nothing pushes (docs/safety.md, H5). `ca status` shows what an
    /// armed device is waiting for. After a fault, forces stay off until you run `ca arm` again. A model that diverged
    /// is first loaded again.
    Arm(control::ArmArgs) => control::arm,
    /// Turns off the forces of a running `ca serve` or `ca play` at once
    ///
    /// Takes effect with the next gesture frame, even if a disk, a terminal or a queue is blocked. The model, its sound
    /// and the take go on. `ca arm` turns forces on again. It does not replace a switch that cuts the power of the
    /// motors (docs/safety.md).
    Disarm(control::ArmArgs) => control::disarm,
    Equiv(equiv::EquivArgs) => equiv::run,
    Device(device::DeviceArgs) => device::run,
    Shm(shm::ShmArgs) => shm::run,
    // Recordings and sweeps
    Replay(take::ReplayArgs) => take::replay::run,
    Log(take::LogArgs) => take::log::run,
    Sweep(sweep::SweepArgs) => sweep::run,
    // Help
    List(list::ListArgs) => list::run,
    Explain(explain::ExplainArgs) => explain::run,
    Completions(completions::CompletionsArgs) => completions::run,
}
