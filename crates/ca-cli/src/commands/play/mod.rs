//! `ca play`: a model in the browser.
//!
//! Decides that this is `ca serve` with a page, not a second host: what people do in the page becomes commands of the same
//! recorder ([`desk`]), an edited model another version of the scene ([`edit`]), what they see and hear comes from a sink like any other ([`sink`]), and the page is greeted with
//! what there is to see ([`greeting`]).

mod desk;
mod edit;
mod energy;
mod greeting;
mod keep;
mod sink;

use crate::args::PlayArgs;
use crate::commands::serve;
use crate::{Failure, Outcome, term};
use ca_compile::Options;
use ca_core::Scene;
use ca_play::Page;
use ca_view::Drawing;
pub(super) use desk::Desk;
use edit::Edit;
pub(super) use keep::{Keep, Kept, TapeSink};
pub(super) use sink::PageSink;
use std::sync::Arc;

/// Where a page is served where nobody says.
const PORT: u16 = 8730;

/// Runs the command.
pub fn run(args: &PlayArgs) -> Outcome {
    serve::session(&args.serve, Some(args))
}

/// Serves the page of a scene.
pub(super) fn open(
    args: &PlayArgs,
    name: &str,
    scene: &Arc<Scene>,
    options: &Options,
    keep: Keep,
) -> Result<(Desk, PageSink), Failure> {
    let drawing = Arc::new(Drawing::new(scene));
    let greeting = greeting::greeting(scene, &drawing, name, 1);
    let page = |port| Page::open(port, &greeting, args.framed);
    let page = match args.port {
        Some(port) => page(port)
            .map_err(|e| Failure::Failed(format!("no page at port {port}: {e}; leave out --port for a free one")))?,
        None => page(PORT).or_else(|_| page(0)).map_err(|e| Failure::Failed(format!("no page: {e}")))?,
    };
    let sink = PageSink::new(page.feed(), drawing.clone(), scene);
    let edit = Edit::new(&args.serve, options);
    Ok((Desk::new(page, name, drawing, scene.clone(), &sink, args, (edit, keep)), sink))
}

/// Says where the page is, and opens it: once nothing can be refused any more.
pub(super) fn announce(address: &str, args: &PlayArgs) {
    // whatever else is quiet: without it nobody can play
    eprintln!("play it at {address}");
    if !args.no_open && has_screen() {
        if let Err(e) = open::that_detached(address) {
            term::note(&format!("no browser opens ({e}); open the address in one"));
        }
    }
}

/// Whether there is a screen for a browser; without one, some desktops would open a browser of text in this terminal.
fn has_screen() -> bool {
    !cfg!(target_os = "linux") || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|v| std::env::var_os(v).is_some())
}
