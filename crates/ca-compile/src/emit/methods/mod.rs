//! Passes of methods: implicit links, `pefrl`, ticks between samples.

pub mod implicit;
pub mod oversample;
pub mod pefrl;
