//! Plays a scene by hand: devices, their safety, the real-time loop and takes.
//!
//! Foreign files (gestures, sounds, point clouds) and playing a scene to its end without a device are in `ca-io`.
//!
//! ```text
//! frame, profile, calibration, equivalence → guard → engine → coupling, admission, record, version → serve
//!                                 rt, stats ──────────────────────────────┘
//! simulated (a device as physics)    host (shared memory, feature `iceoryx`)    take (MCAP, feature `mcap`)
//! ```
//! The default feature `host` turns on `iceoryx` and `mcap`; each of them needs `system`. Without features, the guard,
//! the engine and the loop remain: no threads, no clock ([`time`]), no compiler.
//!
//! `docs/safety.md` lists every stage between a model and a hand, with every number: read it before a device has power.
//! A device process needs only the client of [`host`] (`examples/device.rs`, `examples/device.c`, docs/devices.md).
//! `ca_live::play` plays a scene through all of this.
//!
//! The tick is in `ca-core`, models are in `ca-model` and `ca-compile`, user interfaces in `ca-cli` and `ca-play`.
#[cfg(feature = "system")]
pub mod admission;
mod block_ring;
pub mod calibration;
pub mod control;
#[cfg(feature = "system")]
pub mod coupling;
pub mod engine;
pub mod equivalence;
pub mod frame;
pub mod guard;
#[cfg(feature = "iceoryx")]
pub mod host;
pub mod profile;
pub mod record;
#[cfg(feature = "system")]
pub mod rt;
pub mod serve;
pub mod simulated;
pub mod stats;
#[cfg(feature = "mcap")]
pub mod take;
pub mod time;
pub mod version;
