//! The command line: program, subcommands and common rules.

use crate::args::common::imported;
use crate::commands::Command;
use clap::builder::UnknownArgumentValueParser;
use clap::{CommandFactory as _, Parser};
use std::any::TypeId;

/// Virtual instruments made of masses and interactions (CORDIS-ANIMA).
#[derive(Parser)]
#[command(name = "ca", version, about = "Virtual instruments made of masses and interactions (CORDIS-ANIMA)")]
#[command(max_term_width = 100)]
#[command(
    after_help = format!(
        "Exit codes: 0 ok, 1 failed, 2 usage error, 3 finished but degraded (e.g. unstable or clipped), 130 interrupted.\n\
         A model is a `*.ca.toml` file, {}the name of a bundled model (`ca list`), or `-` for standard input.\n\
         A take is a recorded performance: `ca play --log FILE.mcap` writes one.\n\
         `ca completions --help` shows how to set up shell completion.",
        imported(|f| format!("a {} `*.{}` file, ", f.name, f.extension))
    )
)]
pub struct Cli {
    /// what to do
    #[command(subcommand)]
    pub command: Command,
}

/// Builds the parser. A negative number after an option is parsed as its value and checked like any other value.
pub fn command() -> clap::Command {
    numbers(Cli::command().mut_subcommand("render", |c| c.args(other_names())))
}

/// Names that options of `ca render` have in other programs. clap answers them with a suggestion of the right name.
fn other_names() -> [clap::Arg; 3] {
    [("--format", "bits", "bit-depth"), ("--seconds", "duration", "length"), ("--rate", "sample-rate", "samplerate")]
        .map(|(ours, one, other)| {
            let meant = UnknownArgumentValueParser::suggest_arg(ours);
            clap::Arg::new(one).long(one).alias(other).hide(true).value_parser(meant)
        })
}

/// Returns true with `--quiet` or `--json`. The command then prints little besides its result.
pub fn is_terse(matches: &clap::ArgMatches) -> bool {
    let given = |flag: &str| matches.try_get_one::<bool>(flag).is_ok_and(|v| v.is_some_and(|v| *v));
    given("quiet") || given("json") || matches.subcommand().is_some_and(|(_, m)| is_terse(m))
}

fn numbers(command: clap::Command) -> clap::Command {
    let takes_number = |arg: &clap::Arg| {
        let is = arg.get_value_parser().type_id();
        let of = [TypeId::of::<f64>(), TypeId::of::<u8>(), TypeId::of::<u16>(), TypeId::of::<u32>()];
        !arg.is_positional() && of.into_iter().chain([TypeId::of::<u64>(), TypeId::of::<usize>()]).any(|t| is == t)
    };
    let one = |arg: clap::Arg| if takes_number(&arg) { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(one).mut_subcommands(numbers)
}
