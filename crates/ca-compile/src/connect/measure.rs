//! Measure of a link between its two ends: on a line, along a direction, or as a distance in space.

use crate::net::{End, LiaNode, Measure, Wired};
use alloc::vec::Vec;
use ca_core::Name;

/// Returns the axis of a direction that points forward along one.
fn axis(n: [f64; 3]) -> Option<u8> {
    (0..3u8).find(|k| n[*k as usize] == 1.0)
}

/// Returns the measure between two ends, or title and help of an error.
pub fn measure(net: &Wired, ends: [End; 2], along: Option<[f64; 3]>) -> Result<Measure, (&'static str, &'static str)> {
    let space = ends.map(|e| net.axes(e) > 1);
    let Some(n) = along else {
        return match space {
            [false, false] => Ok(Measure::Line([0, 0])),
            [true, true] => Ok(Measure::Radial),
            _ => Err((
                "joins one end on a line and one in space",
                "add `along = \"x\"`, so that the end on the line moves along that axis, or couple the two by an LPR",
            )),
        };
    };
    let flat = (0..2).any(|k| net.axes(ends[k]) == 2 && n[2] != 0.0);
    match (space, axis(n)) {
        ([false, false], _) => Err(("has a direction, but both ends are on a line", "leave out `along`")),
        _ if flat => Err(("has a direction out of the plane", "write `along = \"x\"`, `\"y\"` or `[x, y]`")),
        ([true, true], Some(k)) => Ok(Measure::Line([k, k])),
        ([true, true], None) => Ok(Measure::Along(n)),
        ([true, false], Some(k)) => Ok(Measure::Line([k, 0])),
        ([false, true], Some(k)) => Ok(Measure::Line([0, k])),
        _ => Err((
            "joins an end on a line to a direction that is not an axis",
            "write `along = \"x\"`, `\"y\"` or `\"z\"`",
        )),
    }
}

/// Replaces a linear link in space whose rest length is 0 by one link per moving axis, since its direction at rest is
/// undefined. Any other link is returned as it is.
pub fn vectorial(net: &Wired, l: LiaNode) -> Vec<LiaNode> {
    if l.measure != Measure::Radial || l.onto.is_some() || !l.law.linear || l.l0 != Some(0.0) {
        return alloc::vec![l];
    }
    let axes = l.ends.iter().map(|e| net.axes(*e)).max().unwrap_or(3);
    let along = |k: u8| {
        let name = Name { axis: Some(k), ..l.name.clone() };
        LiaNode { name, measure: Measure::Line([k, k]), ..l.clone() }
    };
    (0..axes).map(along).collect()
}
