//! Generators: pitch, positions in space, closed forms; waveguides.

mod generate_space;
mod ring;
mod stiff;
mod tuning;
mod waveguide;
