//! Gestures and takes as files: a gesture is opened, a take is made without a device.
//!
//! Takes stand above the crates that play a scene: their format (MCAP) brings half as many packages as all below, and neither a fit nor
//! a measurement needs them.
#![forbid(unsafe_code)]

pub mod account;
pub mod demands;
mod devices;
pub mod gesture;
mod original;
mod record;

pub use devices::{beyond, devices, dofs};
pub use original::Original;
pub use record::{RecordOptions, record};
