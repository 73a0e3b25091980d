//! The scheme itself: warping, limits, tuning, energy, scale; all numbers come from compiled scenes.

mod bench;
mod ledgers;
mod modes;
mod oscillator;
mod scale;
