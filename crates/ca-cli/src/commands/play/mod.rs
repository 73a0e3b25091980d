//! `ca play`: plays a model in the browser. This is `ca serve` with a page.

mod args;
mod browser;

pub use args::PlayArgs;

use crate::commands::serve::{self, ServeArgs};
use crate::outcome::Outcome;
use ca_live::PageOptions;
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
    let source = args.aim.meet(&args.serve.source, args.serve.quiet)?;
    let aimed = ServeArgs { source, ..args.serve.clone() };
    serve::play(&aimed, Some(page(args)), Box::new(opens))
}

/// Returns the options of the page.
pub fn page(args: &PlayArgs) -> PageOptions {
    let PlayArgs { port, framed, allow_arm, lean, .. } = *args;
    PageOptions { port, framed, allow_arm, lean }
}

/// Returns true if there is a screen for a browser. Without one, some desktops would open a text browser in this
/// terminal.
fn has_screen() -> bool {
    !cfg!(target_os = "linux") || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|v| std::env::var_os(v).is_some())
}
