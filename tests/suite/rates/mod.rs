//! Rates: groups at the gesture rate and their border, oversampling, the output stage.

mod border;
mod compensated;
mod outputs;
mod oversample;
mod slow;
