//! Arguments of `ca play`.

use crate::commands::aim::Aim;
use crate::commands::serve::ServeArgs;
use clap::Args;

/// Plays a model in the browser: you see it move, touch it, and hear it
///
/// Prints one address on this machine and opens it: the moving instrument, whose masses can be grabbed and pulled, its
/// live parameters as sliders, its own gesture, levels and spectrum. Sound is played by the page, or by a sound device
/// (`--audio`). It is the engine of `ca serve` with a page: devices take part as there, and a take (`--log`) has what was
/// done in the page, too. The page cannot arm forces unless `--allow-arm` says so. Whoever has the address can play;
/// nobody beyond this machine can reach it. Ends with Ctrl-C, `ca stop` or the page.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca play hammered_string --no-open --seconds 2
  ca play rattle --no-open --seconds 1 -o shaken.wav --log shaken.mcap")]
#[allow(clippy::struct_excessive_bools, reason = "each is an option of its own")]
pub struct PlayArgs {
    /// what `ca serve` has, too
    #[command(flatten)]
    pub serve: ServeArgs,
    /// the error
    #[command(flatten)]
    pub aim: Aim,
    /// Prints the address and opens nothing
    #[arg(long)]
    pub no_open: bool,
    /// Where the page is served; if left out 8730, so that the browser finds its presets again, or any free port
    #[arg(long, value_name = "PORT")]
    pub port: Option<u16>,
    /// Lets other pages of this machine show it in a frame, as a notebook does
    #[arg(long)]
    pub framed: bool,
    /// Lets the page arm the forces of devices
    #[arg(long)]
    pub allow_arm: bool,
    /// Leaves out what nothing hears, as `ca serve` does, though it could be seen
    #[arg(long)]
    pub lean: bool,
}
