//! Scenes in three dimensions.

mod absent;
mod reference;
