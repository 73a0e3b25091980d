//! Gestures and takes as files: a gesture is opened, a take is made without a device.
//!
//! Decides that takes are read and written here, above the crates that play a scene: their format (MCAP) brings as many packages as all
//! the rest of the program, and neither a fit nor a measurement has use for them.
#![forbid(unsafe_code)]

mod devices;
pub mod gesture;
mod record;

pub use devices::{beyond, devices, dofs};
pub use record::{RecordOptions, record};
