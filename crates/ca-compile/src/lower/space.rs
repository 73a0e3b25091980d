//! Space: how many axes things have, and what that means for places, directions and ends.
//!
//! Decides that a plane is space with a frozen axis, so that everything behind the compiler knows two cases: a place
//! on a line and three places in a row.

use crate::net::{End, LiaNode, Measure, Net};
use alloc::format;
use alloc::vec::Vec;
use ca_core::sketch::Arg;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};

/// The names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A place along `dim` axes: a number on a line, as many numbers as axes elsewhere. Nothing written is the origin.
pub fn place(arg: Option<&Arg>, dim: u8, span: Span, what: &str, diags: &mut Diags) -> Option<[f64; 3]> {
    let wrong = |is: &str| {
        let (wants, help) = match dim {
            1 => ("one number, on a line", "write one number, or put it into a group with `dim = 3`"),
            2 => ("two numbers, in a plane", "write `[x, y]`"),
            _ => ("three numbers, in space", "write `[x, y, z]`"),
        };
        Diag::error("E006", format!("{what} is {wants}, not {is}")).at(span, "does not fit").help(help)
    };
    match arg {
        None | Some(Arg::Absent) => Some([0.0; 3]),
        Some(Arg::Num(v)) if dim == 1 => Some([*v, 0.0, 0.0]),
        // what was not written
        Some(Arg::Num(0.0)) if span == Span::NONE => Some([0.0; 3]),
        Some(Arg::Num(_)) => {
            diags.push(wrong("one"));
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

/// The unit vector a direction means.
pub fn direction(arg: &Arg) -> Option<[f64; 3]> {
    let Arg::List(l) = arg else { return None };
    let mut n = [0.0; 3];
    n.iter_mut().zip(l).for_each(|(n, v)| *n = *v);
    Some(n)
}

/// The axis a direction runs along, if it is one and points forward.
fn axis(n: [f64; 3]) -> Option<u8> {
    (0..3u8).find(|k| n[*k as usize] == 1.0)
}

/// How a port measures these ends; an error in words where it cannot.
pub fn measure(net: &Net, ends: [End; 2], along: Option<[f64; 3]>) -> Result<Measure, (&'static str, &'static str)> {
    let space = ends.map(|e| net.axes(e) > 1);
    let Some(n) = along else {
        return match space {
            [false, false] => Ok(Measure::Line([0, 0])),
            [true, true] => Ok(Measure::Radial),
            _ => Err((
                "joins a line and space",
                "add `along = \"x\"`: the end on the line then moves along that axis; or couple them by an LPR",
            )),
        };
    };
    let flat = (0..2).any(|k| net.axes(ends[k]) == 2 && n[2] != 0.0);
    match (space, axis(n)) {
        ([false, false], _) => Err(("has a direction, but both ends live on a line", "leave out `along`")),
        _ if flat => Err(("has a direction out of the plane", "write `along = \"x\"`, `\"y\"` or `[x, y]`")),
        ([true, true], Some(k)) => Ok(Measure::Line([k, k])),
        ([true, true], None) => Ok(Measure::Along(n)),
        ([true, false], Some(k)) => Ok(Measure::Line([k, 0])),
        ([false, true], Some(k)) => Ok(Measure::Line([0, k])),
        _ => Err(("joins a line and a direction that is no axis", "write `along = \"x\"`, `\"y\"` or `\"z\"`")),
    }
}

/// A linear link in space that is slack at length 0 has no direction of its own: it becomes one along each axis that
/// moves, damper included. Any other link stays as it is.
pub fn vectorial(net: &Net, l: LiaNode) -> Vec<LiaNode> {
    if l.measure != Measure::Radial || l.onto.is_some() || !l.law.linear || l.l0 != Some(0.0) {
        return alloc::vec![l];
    }
    let axes = l.ends.iter().map(|e| net.axes(*e)).max().unwrap_or(3);
    let along = |k: u8| {
        let name = format!("{}.{}", l.name, AXES[k as usize]);
        LiaNode { name, measure: Measure::Line([k, k]), ..l.clone() }
    };
    (0..axes).map(along).collect()
}
