//! `ca play`: plays a model in the browser. This is `ca serve` with a page.

mod args;
mod browser;

pub use args::PlayArgs;

use crate::commands::serve;
use crate::load::{self, STDIN};
use crate::outcome::{Failure, Outcome};
use ca_live::{OneFile, PageOptions};
use std::sync::Mutex;

/// Runs the command.
pub fn run(args: &PlayArgs) -> Outcome {
    let open = !args.no_open && has_screen();
    // lives until the end, because its file leads the browser to the page
    let redirect = Mutex::new(None);
    let opens = move |address: &str| {
        // printed even with `--quiet`, because playing requires the address
        eprintln!("play it at {address}");
        if let (true, Ok(mut redirect)) = (open, redirect.lock()) {
            *redirect = browser::open(address);
        }
    };
    if args.error_target.error.is_none() {
        return serve::play(&args.serve, Some(page(args)), Box::new(opens));
    }
    let mut aimed = args.serve.clone();
    if aimed.source.model == STDIN {
        let what = "--error: standard input can be read only once; save the model as a file";
        return Err(Failure::Usage(what.into()));
    }
    let loaded = load::load(&aimed.source)?;
    aimed.source.set.extend(args.error_target.changes(&loaded, aimed.source.rate, aimed.quiet)?);
    serve::play(&aimed, Some(page(args)), Box::new(opens))
}

/// Returns the options of the page.
pub fn page(args: &PlayArgs) -> PageOptions {
    let PlayArgs { port, framed, allow_arm, lean, .. } = *args;
    let one_file: Option<OneFile> = ca_site::modules().map(|_| one_file as OneFile);
    PageOptions { port, framed, allow_arm, lean, site: args.site.clone(), one_file }
}

fn one_file(text: &str, file: &str, site: &str) -> String {
    ca_site::modules().map_or_else(String::new, |modules| ca_site::one_file(text, file, site, modules))
}

/// Returns true if there is a screen for a browser. Without one, some desktops would open a text browser in this
/// terminal.
fn has_screen() -> bool {
    !cfg!(target_os = "linux") || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|v| std::env::var_os(v).is_some())
}
