//! Number of axes of modules, and its meaning for positions and directions.
//!
//! A plane is space with a frozen axis. After the compiler there are therefore only two cases: one number on a line,
//! and three consecutive numbers in space.

use alloc::format;
use ca_core::internal::kind::builder::Arg;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns a position along `dim` axes: one number on a line, else one per axis. The default is the origin.
pub fn position(
    arg: Option<&Arg>,
    dim: u8,
    span: Span,
    what: &dyn core::fmt::Display,
    diags: &mut Diags,
) -> Option<[f64; 3]> {
    let wrong = |is: &str| {
        let (wants, help) = match dim {
            1 => ("one number on a line", "write one number, or put the module into a group with `dim = 3`"),
            2 => ("two numbers in a plane", "write `[x, y]`"),
            _ => ("three numbers in space", "write `[x, y, z]`"),
        };
        Diag::error("E006", format!("{what} must be {wants}, not {is}")).at(span, "does not fit").help(help)
    };
    match arg {
        None | Some(Arg::Absent) => Some([0.0; 3]),
        Some(Arg::Num(v)) if dim == 1 => Some([*v, 0.0, 0.0]),
        // Not written: the default.
        Some(Arg::Num(0.0)) if span == Span::NONE => Some([0.0; 3]),
        Some(Arg::Num(_)) => {
            diags.push(wrong("one number"));
            None
        }
        Some(Arg::List(l)) if l.len() == dim as usize && dim > 1 => {
            let mut all = [0.0; 3];
            all[..l.len()].copy_from_slice(l);
            Some(all)
        }
        Some(Arg::List(l)) => {
            diags.push(wrong(&format!("a list of {}", l.len())));
            None
        }
        Some(Arg::Cloud(_)) => None,
    }
}

/// Returns the unit vector of a direction.
pub fn direction(arg: &Arg) -> Option<[f64; 3]> {
    let Arg::List(l) = arg else { return None };
    let mut n = [0.0; 3];
    n.iter_mut().zip(l).for_each(|(n, v)| *n = *v);
    Some(n)
}
