//! Scenes in three dimensions.

mod reference;
