//! Scenes in three dimensions.

mod absent;
mod kept;
mod reference;
