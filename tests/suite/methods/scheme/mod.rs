//! The scheme itself: warping, limits, tuning, energy, scale. Every number comes out of a compiled scene.

mod bench;
mod ledgers;
mod modes;
mod oscillator;
mod scale;
