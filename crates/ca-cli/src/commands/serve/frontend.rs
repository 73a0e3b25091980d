//! What a session is played from besides devices and inputs: a page of `ca play`, or nothing.
//!
//! Decides that a session knows a frontend by these two traits alone, and `ca play` hands one over: `ca serve` stays whole
//! without a page, and the loop that attends to the engine is there once. Against a type parameter of the session, which
//! would build all of it twice.

use super::inputs::Inputs;
use crate::outcome::Failure;
use ca_compile::Options;
use ca_core::Scene;
use ca_haptic::engine::Setup;
use ca_haptic::serve::{Recorder, Shared, Sink};
use ca_haptic::take::Header;
use std::any::Any;
use std::sync::Arc;
use std::time::Instant;

/// What is known of a session when its frontend opens.
pub(crate) struct Opening<'a> {
    /// name of the model
    pub name: &'a str,
    pub scene: &'a Arc<Scene>,
    pub options: &'a Options,
    /// of a take, where the session writes none and has no device
    pub header: Option<Header>,
}

/// Who opens a frontend, once there is a scene.
pub(crate) trait Frontend {
    /// Whether what nothing hears is wanted too.
    fn whole(&self) -> bool;

    /// Opens it, and adds what it sees and hears to the sinks.
    ///
    /// # Errors
    /// Where it cannot be opened, which refuses the session.
    fn open(&self, opening: Opening<'_>, sinks: &mut Vec<Box<dyn Sink>>) -> Result<Box<dyn Desk>, Failure>;

    /// Says where it is, once nothing can be refused any more. The session keeps the result until its end.
    fn announce(&self, address: &str) -> Box<dyn Any>;
}

/// A frontend that is open, in the hands of the recorder's thread.
pub(crate) trait Desk {
    /// Where it is.
    fn address(&self) -> String;

    /// Something else plays the sound.
    fn sounds_by(&mut self, host: &str);

    /// A number of the model is to be another, as by `--set`.
    ///
    /// # Errors
    /// Why it cannot be.
    fn change(&mut self, name: &str, value: &str) -> Result<(), ca_session::Refused>;

    /// One turn: what was asked, one request at least and no more after `end`, and now and then how it goes; no new version of
    /// the model where `setups` is none. True where somebody asked to stop.
    fn turn(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        setups: Option<&[Setup]>,
        shared_and_end: (&Shared, Instant),
    ) -> bool;

    /// Closes it; what it still writes is finished when this is dropped.
    fn close(self: Box<Self>) -> Box<dyn Any>;
}
