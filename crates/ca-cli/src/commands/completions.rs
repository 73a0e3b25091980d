//! `ca completions`: prints the shell script that enables completion.

use crate::outcome::{Ended, Failure, Outcome};
use clap::Args;
use clap_complete::Shell;
use clap_complete::env::Shells;

/// Prints what makes a shell complete commands, options and names of models
///
/// The script makes the shell ask `ca` itself at each Tab. The shell then completes commands, options and their values, bundled
/// models and model files, as the installed program has them. In bash: `echo 'source <(ca completions bash)' >> ~/.bashrc`; in zsh
/// the same with `zsh` and `~/.zshrc`; in fish: `ca completions fish > ~/.config/fish/completions/ca.fish`. Write it again
/// after an update where it is kept in a file.
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
    let shell = shells.completer(&name).ok_or_else(|| Failure::Usage(format!("`{name}` cannot ask a program")))?;
    // uses the plain name, because a command line that begins with `ca` finds the program by it
    shell.write_registration(ASKED_BY, "ca", "ca", "ca", &mut std::io::stdout().lock())?;
    Ok(Ended::Well)
}
