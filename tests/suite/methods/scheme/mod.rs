//! The scheme itself: warping, limits, tuning, energy, scale; all numbers come from compiled scenes.

mod ledgers;
mod modes;
mod oscillator;
mod scale;
mod test_models;
