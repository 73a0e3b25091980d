//! Passes of methods: implicit links, `pefrl`, ticks between two samples.

pub mod implicit;
pub mod oversample;
pub mod pefrl;
