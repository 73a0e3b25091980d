//! What generators draw: its modes, its pitch, its place in space.

mod generate_space;
mod modes;
mod ring;
mod tuning;
mod waveguide;
