//! MAT: what has a position. Every MAT is three coefficients, `d ← P·d + Q·x + C·f ; x ← x + d`.
//!
//! Decides that MAS, CEL and SOL do not exist at run time: they differ in three numbers, so one pass integrates them all
//! (seen in mi.lib, style of the field). `x` is relative to the rest position and `d = x_n − x_{n−1}`: this delta form
//! drifts far less than keeping two positions, and keeps single precision alive.

use crate::kind::{Coefs, Kind, MatSpec, Need, Param, Type, Unit};

mod cel;
mod mas;
mod sol;

/// Rest position.
pub const X: Param = Param::new("x", Type::Position { unit: Unit::METRE }, Need::Default(0.0), "rest position");
/// Initial displacement.
pub const DX0: Param = Param::new(
    "dx0",
    Type::Position { unit: Unit::METRE },
    Need::Default(0.0),
    "initial displacement from the rest position",
);
/// Initial velocity.
pub const V: Param = Param::new("v", Type::Position { unit: Unit::SPEED }, Need::Default(0.0), "initial velocity");

/// All MAT kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[&mas::KIND, &sol::KIND, &cel::KIND];
pub use cel::KIND as CEL;
pub use mas::KIND as MAS;
pub use sol::KIND as SOL;
