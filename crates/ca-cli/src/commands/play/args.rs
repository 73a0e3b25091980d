//! Arguments of `ca play`.

use crate::args::common::site_address;
use crate::commands::error_target::ErrorTarget;
use crate::commands::serve::ServeArgs;
use clap::Args;

/// Plays a model in the browser, where you can see, touch and hear it
///
/// Prints the address of a page on this machine and opens it. The page shows the moving instrument, whose masses can be
/// grabbed and pulled, its live parameters as sliders, its built-in gesture, levels and spectrum. The page plays the
/// sound, or a sound device does (`--audio`).
///
/// The engine is the same as in `ca serve`: devices work in the same way, and a take (`--log`) also records the actions
/// in the page. The page can arm forces only with `--allow-arm`. Anyone with the address can play, but the page cannot
/// be reached from other machines. Ends with Ctrl-C, `ca stop` or the page.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca play hammered_string --no-open --seconds 2
  ca play hammered_string --no-open --seconds 1 --set hammer.m='30 g'
  ca play rattle --no-open --seconds 1 -o shaken.wav --log shaken.mcap")]
#[allow(clippy::struct_excessive_bools, reason = "each is an option of its own")]
pub struct PlayArgs {
    /// what `ca serve` has, too
    #[command(flatten)]
    pub serve: ServeArgs,
    /// the error
    #[command(flatten)]
    pub error_target: ErrorTarget,
    /// Prints the address without opening it
    #[arg(long, help_heading = "Page")]
    pub no_open: bool,
    /// Port of the page (default: 8730, so that the browser finds its presets again, or any free port)
    #[arg(long, value_name = "PORT", help_heading = "Page")]
    pub port: Option<u16>,
    /// Lets other pages on this machine show the page in a frame, as a notebook does
    #[arg(long, help_heading = "Page")]
    pub framed: bool,
    /// Address of a site (`ca site`) for links to the model, which the page then copies (*Share as link*)
    #[arg(long, value_name = "URL", value_parser = site_address, help_heading = "Page")]
    pub site: Option<String>,
    /// Lets the page arm the forces of devices
    #[arg(long, help_heading = "Page")]
    pub allow_arm: bool,
    /// Leaves out modules that do not affect any output, as `ca serve` does, though they could be shown
    #[arg(long, help_heading = "Page")]
    pub lean: bool,
}
