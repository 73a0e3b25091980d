//! `ca site`: writes a folder for a web server, with a gallery of the bundled instruments.

use super::export::built_in;
use crate::outcome::{Ended, Outcome};
use clap::Args;
use std::io::Write as _;
use std::path::PathBuf;

/// Writes a web site with the bundled instruments
///
/// The folder is static: any web server can offer it. It has a gallery, the page that plays an instrument, links that
/// carry a model, the documents for players and composers, and the folder `npm`, a package with the element `<ca-instrument>` and a renderer for Node. Once
/// visited, the site also works without a network.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca site public
  ca site public && ls public/models")]
pub struct SiteArgs {
    /// Folder to write; existing files of the same names are replaced
    pub folder: PathBuf,
}

/// Runs the command.
pub fn run(args: &SiteArgs) -> Outcome {
    let (files, bytes) = ca_site::site(&args.folder, built_in()?)?;
    let folder = args.folder.display();
    writeln!(std::io::stdout().lock(), "{folder}: {files} files, {:.1} MB", bytes as f64 * 1e-6)?;
    Ok(Ended::Well)
}
