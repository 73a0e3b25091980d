//! Derivatives of scenes against closed forms, and against differences of renders in double precision.

mod closed;
mod drawn;
mod reference;
mod refused;
mod reverse;
