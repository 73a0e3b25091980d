//! Page of a performance: passes its requests to the session.

use crate::compiler::Compiler;
use crate::inputs::Inputs;
use crate::language::ModelLanguage;
use crate::request::{Listener, OneFile, PageOptions, Request};
use crate::text::Stored;
use ca_compile::Options;
use ca_core::Scene;
use ca_haptic::engine::Setup;
use ca_haptic::serve::{Recorder, Shared, Sink, TemporaryTake};
use ca_haptic::take::Header;
use ca_lab::Failure;
use ca_play::{MakesText, Offers, Page, PageFiles, PageRequest, SoundFileSink};
use ca_session::{Language as _, PageSink, Parts, Refused, Session};
use ca_view::Drawing;
use std::any::Any;
use std::sync::{Arc, PoisonError};
use std::time::Instant;

/// Default TCP port of a page.
const PORT: u16 = 8730;

/// Performance for which a page opens.
pub(crate) struct Opening<'a> {
    pub(crate) request: &'a Request,
    pub(crate) scene: &'a Arc<Scene>,
    pub(crate) options: &'a Options,
    /// Header of a take, for a performance without devices that does not write a take itself.
    pub(crate) header: Option<Header>,
}

/// Returns what a page of the model `name` offers, of the snapshot that was stored last.
fn offers(options: &PageOptions, name: &str, stored: &Stored) -> Offers {
    let makes = |make: Option<OneFile>| -> MakesText {
        let (stored, file, site) =
            (stored.clone(), format!("{name}.ca.toml"), options.site.clone().unwrap_or_default());
        Box::new(move || {
            let snapshot = stored.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
            let text = snapshot.text()?;
            Some(make.map_or_else(|| text.clone(), |make| make(&text, &file, &site)))
        })
    };
    let one_file = options.one_file.map(|make| makes(Some(make)));
    Offers { site: options.site.clone(), model: Some(makes(None)), one_file }
}

pub(crate) struct PageSession {
    page: Page,
    session: Session,
}

impl PageSession {
    /// Opens the page and adds its sinks.
    ///
    /// # Errors
    /// Fails if the port is in use.
    pub(crate) fn open(
        options: &PageOptions,
        opening: Opening<'_>,
        listener: &Arc<dyn Listener>,
        sinks: &mut Vec<Box<dyn Sink>>,
    ) -> Result<PageSession, Failure> {
        let Opening { request, scene, options: compile, header } = opening;
        let name = &request.loaded.name;
        let mut take = None;
        if let Some(header) = header {
            match TemporaryTake::begin(&header, scene) {
                Ok((begun, line)) => {
                    sinks.push(Box::new(line));
                    take = Some(begun);
                }
                Err(e) => listener.warning(&format!("this performance cannot be saved as a take later: {e}")),
            }
        }
        let sound_file = SoundFileSink::default();
        sinks.push(Box::new(sound_file.clone()));
        let files = PageFiles::new(name, take, sound_file);
        let drawing = Arc::new(Drawing::new(scene));
        let greeting = ca_session::greeting(scene, &drawing, name, 1, ModelLanguage.stability(scene));
        let stored = Stored::default();
        let page = |port| Page::open(port, &greeting, options.framed, offers(options, name, &stored));
        let page = match options.port {
            Some(port) => page(port).map_err(|e| {
                Failure::Failed(format!("cannot open the page at port {port}: {e}; leave out `--port` for a free one"))
            })?,
            None => {
                page(PORT).or_else(|_| page(0)).map_err(|e| Failure::Failed(format!("cannot open the page: {e}")))?
            }
        };
        let sink = PageSink::new(Box::new(page.feed()), drawing.clone(), scene);
        let parts = Parts {
            pages: Box::new(page.feed()),
            language: Box::new(ModelLanguage),
            maker: Box::new(Compiler::new(&request.source, compile, stored)),
            files: Box::new(files),
            name: name.clone(),
            allow_arm: options.allow_arm,
        };
        let session = Session::new(parts, scene.clone(), drawing, &sink);
        sinks.push(Box::new(sink));
        Ok(PageSession { page, session })
    }

    pub(crate) fn address(&self) -> String {
        self.page.address()
    }

    /// Reports the output that plays the sound now.
    pub(crate) fn sounds_by(&mut self, host: &str) {
        self.session.sounds_by(host);
    }

    /// Changes a number of the model, as `--set` does.
    ///
    /// # Errors
    /// Returns the reason if the model cannot be compiled again.
    pub(crate) fn change(&mut self, name: &str, value: &str) -> Result<(), Refused> {
        self.session.change(name, value)
    }

    /// Closes the page and ends the session. Its files are finished when the result is dropped.
    pub(crate) fn close(self) -> Box<dyn Any> {
        let PageSession { page, session } = self;
        drop(page);
        Box::new(session.close())
    }

    /// Handles requests of pages until `end`, but at least one, and sends messages to pages.
    ///
    /// The model is not replaced while `setups` is `None`. Returns true if a page requests a stop.
    pub(crate) fn poll(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        setups: Option<&[Setup]>,
        (shared, end): (&Shared, Instant),
    ) -> bool {
        let mut leave = false;
        if !self.session.poll(recorder, &mut inputs.midi, setups) {
            return leave;
        }
        let mut late = false;
        while !late {
            let Some(PageRequest { client, request }) = self.page.requests().next() else { break };
            late = Instant::now() >= end;
            match request {
                Some(asked) => {
                    let now = inputs.now();
                    leave |= self.session.request(recorder, &mut inputs.midi, (client, asked), now);
                }
                None => self.session.left(recorder, client),
            }
        }
        let now = inputs.now();
        self.session.send_state(recorder, &inputs.midi, shared, now);
        leave
    }
}
