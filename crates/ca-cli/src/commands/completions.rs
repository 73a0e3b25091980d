//! `ca completions`: prints the shell script that enables completion.

use crate::outcome::{Ended, Failure, Outcome};
use clap::Args;
use clap_complete::Shell;
use clap_complete::env::Shells;

/// Prints a shell script that completes commands, options and names of models
///
/// With the script, the shell runs `ca` at each Tab. It completes the commands, options, values, bundled models and
/// model files of the installed program.
///
/// In bash, run `echo 'source <(ca completions bash)' >> ~/.bashrc`. In zsh, use `zsh` and `~/.zshrc`. In fish, run `ca
/// completions fish > ~/.config/fish/completions/ca.fish`. If you keep the script in a file, write it again after an
/// update.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca completions bash
  ca completions zsh > _ca
  ca completions fish > ca.fish")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Environment variable through which the script requests candidates: the default of `CompleteEnv`, which `run` uses.
const ASKED_BY: &str = "COMPLETE";

/// Runs the command.
pub fn run(args: &CompletionsArgs) -> Outcome {
    let name = args.shell.to_string();
    let shells = Shells::builtins();
    let shell = shells
        .completer(&name)
        .ok_or_else(|| Failure::Usage(format!("`{name}` cannot run a program for completion")))?;
    // uses the plain name, because a command line that begins with `ca` finds the program by it
    shell.write_registration(ASKED_BY, "ca", "ca", "ca", &mut std::io::stdout().lock())?;
    Ok(Ended::Well)
}
