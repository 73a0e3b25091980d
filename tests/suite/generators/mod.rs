//! Generators: pitch, positions in space, closed forms; waveguides.

mod generate_space;
mod ring;
mod tuning;
mod waveguide;
