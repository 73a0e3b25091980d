//! Scenes in three dimensions.

mod one_place;
mod reference;
mod stored_lengths;
mod unused_features;
