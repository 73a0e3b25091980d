//! Models played many times: batches and sweeps.

pub mod batch;
pub mod sweep;
