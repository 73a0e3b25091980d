//! Where rates meet: gesture and sound, oversampled and not, and what comes out.

mod border;
mod compensated;
mod outputs;
mod oversample;
mod slow;
