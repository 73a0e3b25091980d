//! Derivatives of what scenes sound, and of their energy, against closed forms, and against differences of renders in double precision.

mod closed;
mod drawn;
mod energy;
mod few;
mod reference;
mod refused;
mod reverse;
