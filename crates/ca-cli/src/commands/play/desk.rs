//! The page of a running engine: gives its requests to the session.

use crate::commands::serve::{self, Inputs};
use ca_haptic::engine::Setup;
use ca_haptic::serve::{Recorder, Shared};
use ca_play::{Page, PageRequest};
use ca_session::Session;
use std::any::Any;
use std::time::Instant;

/// A page and its session.
pub(super) struct Desk {
    pub(super) page: Page,
    pub(super) session: Session,
}

impl serve::Desk for Desk {
    fn address(&self) -> String {
        self.page.address()
    }

    fn sounds_by(&mut self, host: &str) {
        self.session.sounds_by(host);
    }

    fn change(&mut self, name: &str, value: &str) -> Result<(), ca_session::Refused> {
        self.session.change(name, value)
    }

    /// Closes the page and ends the session; its files are finished when the result is dropped.
    fn close(self: Box<Self>) -> Box<dyn Any> {
        let Desk { page, session } = *self;
        drop(page);
        Box::new(session.close())
    }

    fn turn(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        setups: Option<&[Setup]>,
        (shared, end): (&Shared, Instant),
    ) -> bool {
        let mut leave = false;
        if !self.session.turn(recorder, &mut inputs.midi, setups) {
            return leave;
        }
        let mut late = false;
        while !late {
            let Some(PageRequest { client, request }) = self.page.asked().next() else { break };
            late = Instant::now() >= end;
            match request {
                Some(asked) => {
                    let now = inputs.now();
                    leave |= self.session.ask(recorder, &mut inputs.midi, (client, asked), now);
                }
                None => self.session.left(recorder, client),
            }
        }
        let now = inputs.now();
        self.session.news(recorder, &inputs.midi, shared, now);
        leave
    }
}
