//! `ca export`: writes an instrument as a web page in one file.
//!
//! The page has the engine inside, so it plays from a disk and from any web server.

use crate::args::common::{model_help, site_address};
use crate::args::{Source, completions};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{load, term};
use ca_compile::Options;
use ca_io::atomic_file;
use ca_lab::load::{needs_no_files, own_text};
use ca_site::{WebModules, modules, one_file};
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::path::PathBuf;

/// Writes an instrument as a web page in one file
///
/// The page needs neither `ca` nor a network. It has the moving picture, the keys, the parameters and the sound, and
/// its reader can also change the text of the model.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca export hammered_string --html string.html
  ca export mine.ca.toml --html mine.html
  ca export mine.ca.toml --html mine.html --site https://example.org/ca/")]
pub struct ExportArgs {
    /// the model
    #[arg(help = model_help(), add = ArgValueCompleter::new(completions::models))]
    pub model: String,
    /// Page to write
    #[arg(long, value_name = "FILE.html", required = true)]
    pub html: PathBuf,
    /// Address of a site (`ca site`) for links to the model
    #[arg(long, value_name = "URL", value_parser = site_address)]
    pub site: Option<String>,
}

/// Runs the command.
pub fn run(args: &ExportArgs) -> Outcome {
    let modules = built_in()?;
    let loaded = load::load(&Source::of(&args.model))?;
    load::scene(&loaded, &Options::default())?;
    needs_no_files(&loaded)?;
    let page = one_file(
        &own_text(&loaded),
        &format!("{}.ca.toml", loaded.name),
        args.site.as_deref().unwrap_or_default(),
        modules,
    );
    atomic_file::write(&args.html, page.as_bytes())?;
    term::note(&format!("{} written ({:.1} MB)", args.html.display(), page.len() as f64 * 1e-6));
    Ok(Ended::Well)
}

/// Returns the engine for browsers.
pub(super) fn built_in() -> Result<WebModules, Failure> {
    modules().ok_or_else(|| {
        Failure::Failed(
            "this `ca` was built without the engine for browsers; in its sources, `tools/site FOLDER` builds it".into(),
        )
    })
}
