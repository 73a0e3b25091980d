//! Quantities: `"20 g"`, `"0.2 N s/m"`, `"1e8 N/m^1.5"`.
//!
//! Decides that a string that starts with a digit, a sign or a dot is a quantity and any other is not, so that one
//! look tells a number from the name of a `[param]`. Decides that the number is correctly rounded: the prefixes move
//! the decimal point in the text before it becomes a float, so `"20 g"` is the very `f64` 0.02. The alternative,
//! multiplying by 1e-3, is one bit off for every third number and would make a model's bits depend on how its author
//! likes to write. No units library: three exponents and six symbols are all that mechanics needs here.

mod note;
mod read;
mod show;
mod units;
mod value;

pub use ca_core::internal::numeric::Plain;
pub use note::{near_note, note, note_name, note_number, note_of};
pub use read::{is_quantity, parse, product};
pub use show::{rounded, short, show, six, unit_of};
pub use value::{Quantity, QuantityError};
