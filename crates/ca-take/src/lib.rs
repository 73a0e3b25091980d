//! Opens gesture files and records takes without a device.
//!
//! This crate is separate from the crates that play a scene. The MCAP format of takes adds half as many packages as all
//! those crates use, and neither fits nor measurements need it.
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
