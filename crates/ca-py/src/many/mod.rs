//! Batches and sweeps: models played many times.

pub mod batch;
pub mod sweep;
