//! `ca play`: a model in the browser.
//!
//! This is `ca serve` with a page: a session ([`ca_session`]) answers the requests of the page. Here are its page ([`desk`])
//! and its compiler ([`edit`]); its files are written by [`ca_play::Keep`].

mod browser;
mod desk;
mod edit;

use crate::args::PlayArgs;
use crate::commands::serve::{self, Frontend, Opening};
use crate::language::ModelLanguage;
use crate::outcome::{Failure, Outcome};
use crate::term;
use ca_haptic::serve::{Kept, Sink};
use ca_play::{Keep, Page, TapeSink};
use ca_session::{Language as _, PageSink, Parts, Session};
use ca_view::Drawing;
use desk::Desk;
use edit::Compiler;
use std::any::Any;
use std::sync::Arc;

/// Where a page is served where nobody says.
const PORT: u16 = 8730;

/// Runs the command.
pub fn run(args: &PlayArgs) -> Outcome {
    serve::session(&args.serve, Some(args))
}

impl Frontend for PlayArgs {
    fn whole(&self) -> bool {
        !self.lean
    }

    fn open(&self, opening: Opening<'_>, sinks: &mut Vec<Box<dyn Sink>>) -> Result<Box<dyn serve::Desk>, Failure> {
        let Opening { name, scene, options, header } = opening;
        let mut kept = None;
        if let Some(header) = header {
            match Kept::begin(&header, scene) {
                Ok((begun, line)) => {
                    sinks.push(Box::new(line));
                    kept = Some(begun);
                }
                Err(e) => term::warning(&format!("what is played cannot be saved as a take afterwards: {e}")),
            }
        }
        let tape = TapeSink::default();
        sinks.push(Box::new(tape.clone()));
        let keep = Keep::new(name, kept, tape);
        let drawing = Arc::new(Drawing::new(scene));
        let greeting = ca_session::greeting(scene, &drawing, name, 1, ModelLanguage.stability(scene));
        let page = |port| Page::open(port, &greeting, self.framed);
        let page = match self.port {
            Some(port) => page(port).map_err(|e| {
                Failure::Failed(format!("no page at port {port}: {e}; leave out --port for a free one"))
            })?,
            None => page(PORT).or_else(|_| page(0)).map_err(|e| Failure::Failed(format!("no page: {e}")))?,
        };
        let sink = PageSink::new(Box::new(page.feed()), drawing.clone(), scene);
        let parts = Parts {
            pages: Box::new(page.feed()),
            language: Box::new(ModelLanguage),
            maker: Box::new(Compiler::new(&self.serve, options)),
            files: Box::new(keep),
            name: name.into(),
            allow_arm: self.allow_arm,
        };
        let session = Session::new(parts, scene.clone(), drawing, &sink);
        sinks.push(Box::new(sink));
        Ok(Box::new(Desk { page, session }))
    }

    /// Opens it too.
    fn announce(&self, address: &str) -> Box<dyn Any> {
        // whatever else is quiet: without it nobody can play
        eprintln!("play it at {address}");
        let open = !self.no_open && has_screen();
        Box::new(open.then(|| browser::open(address)))
    }
}

/// Whether there is a screen for a browser; without one, some desktops would open a browser of text in this terminal.
fn has_screen() -> bool {
    !cfg!(target_os = "linux") || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|v| std::env::var_os(v).is_some())
}
