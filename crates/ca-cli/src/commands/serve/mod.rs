//! `ca serve`: a model played in real time by device processes.
//!
//! Decides who does what: the engine thread computes, the gateway thread moves frames between shared memory and rings,
//! and this one, the desk, does everything that may take its time. A model without devices gets no gateway and no
//! shared memory; one without live parameters either gets no control.

mod setup;
mod sinks;
mod told;

use crate::args::{ClockKind, ServeArgs};
use crate::load;
use crate::{Ended, Failure, Outcome, term};
use ca_core::Options;
use ca_haptic::engine::Engine;
use ca_haptic::guard::Order;
use ca_haptic::rt::{self, Wish};
use ca_haptic::serve::{Clock, Desk, Every, Live, Shared, Sink, rings};
use ca_haptic::sound::{Format, WavOut};
pub(crate) use setup::{devices, dofs};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::Duration;

/// Between two turns of the desk.
const TURN: Duration = Duration::from_millis(2);
