//! MAT: material elements, which have a position. Every MAT is three coefficients, `d ← P·d + Q·x + C·f ; x ← x + d`.
//!
//! MAS, CEL and SOL differ in three numbers, so one pass integrates them all, as in mi.lib. `x` is relative to the rest
//! position and `d = x_n − x_{n−1}`. This drifts far less than two stored positions and makes single precision usable.

use crate::kind::{Coefs, Kind, MatSpec, Need, Param, Type, Unit};

mod cel;
mod mas;
mod sol;

/// Parameter `x`: rest position.
pub const X: Param = Param::new("x", Type::Position { unit: Unit::METRE }, Need::Default(0.0), "rest position");
/// Parameter `dx0`: initial displacement.
pub const DX0: Param = Param::new(
    "dx0",
    Type::Position { unit: Unit::METRE },
    Need::Default(0.0),
    "initial displacement from the rest position",
);
/// Parameter `v`: initial velocity.
pub const V: Param = Param::new("v", Type::Position { unit: Unit::SPEED }, Need::Default(0.0), "initial velocity");

/// All MAT kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[&mas::KIND, &sol::KIND, &cel::KIND];
pub use cel::KIND as CEL;
pub use mas::KIND as MAS;
pub use sol::KIND as SOL;
