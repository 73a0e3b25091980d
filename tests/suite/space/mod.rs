//! Scenes in three dimensions.

mod reference;
mod stored_lengths;
mod unused_features;
