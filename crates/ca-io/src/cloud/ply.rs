//! PLY clouds: elements `vertex` (x, y, z), `face` (vertex_indices or vertex_index) and `edge` (vertex1, vertex2), as
//! text or binary of either byte order; other elements and properties are passed over.

use super::Drawing;
use crate::error::{FileError, FileErrorKind, lower};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// One element, whichever it is.
#[derive(Default)]
struct Element {
    place: [f64; 3],
    corners: Vec<u32>,
    ends: [u32; 2],
}

/// What no point has as its number.
const NOBODY: u32 = u32::MAX;

/// A number of a point; what cannot be one is refused later, with the others that name no point.
fn index(v: f64) -> u32 {
    if v >= 0.0 && v < f64::from(NOBODY) { v as u32 } else { NOBODY }
}

fn scalar(p: &Property) -> Option<f64> {
    Some(match p {
        Property::Char(v) => f64::from(*v),
        Property::UChar(v) => f64::from(*v),
        Property::Short(v) => f64::from(*v),
        Property::UShort(v) => f64::from(*v),
        Property::Int(v) => f64::from(*v),
        Property::UInt(v) => f64::from(*v),
        Property::Float(v) => f64::from(*v),
        Property::Double(v) => *v,
        _ => return None,
    })
}

fn list(p: Property) -> Option<Vec<u32>> {
    fn all<T: Into<f64>>(v: Vec<T>) -> Vec<u32> {
        v.into_iter().map(|v| index(v.into())).collect()
    }
    Some(match p {
        Property::ListChar(v) => all(v),
        Property::ListUChar(v) => all(v),
        Property::ListShort(v) => all(v),
        Property::ListUShort(v) => all(v),
        Property::ListInt(v) => all(v),
        Property::ListUInt(v) => all(v),
        _ => return None,
    })
}

impl PropertyAccess for Element {
    fn new() -> Element {
        Element { place: [f64::NAN; 3], corners: Vec::new(), ends: [NOBODY; 2] }
    }

    fn set_property(&mut self, name: &str, p: Property) -> PropertyAccessResult {
        let axis = ["x", "y", "z"].iter().position(|a| *a == name);
        let end = ["vertex1", "vertex2"].iter().position(|a| *a == name);
        match (axis, end, name) {
            (Some(k), _, _) => self.place[k] = scalar(&p).unwrap_or(f64::NAN),
            (_, Some(k), _) => self.ends[k] = scalar(&p).map_or(NOBODY, index),
            (_, _, "vertex_indices" | "vertex_index") => self.corners = list(p).unwrap_or_default(),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// Reads a PLY cloud.
pub(super) fn read(bytes: &[u8]) -> Result<Drawing, FileError> {
    let wrong = |e: &ParseError| {
        let text = e.to_string();
        let text = text.split_once(": ").filter(|_| e.line().is_some()).map_or(text.as_str(), |t| t.1);
        let error = FileError::new(FileErrorKind::Format, lower(text));
        e.line().map_or(error.clone(), |l| error.at(format!("line {l}")))
    };
    let (mut reader, parser) = (Reader::new(bytes), Parser::<Element>::new());
    let header = parser.read_header(&mut reader).map_err(|e| wrong(&e))?;
    let mut d = Drawing::default();
    for (name, element) in &header.elements {
        if name == "vertex" {
            super::not_too_many(element.count)?;
            if let Some(missing) = ["x", "y", "z"].into_iter().find(|p| !element.properties.contains_key(*p)) {
                return Err(FileError::content(format!("its points have no `{missing}`")).fix("export x, y and z"));
            }
        }
        let all = parser.read_payload_for_element(&mut reader, element, &header).map_err(|e| wrong(&e))?;
        match name.as_str() {
            "vertex" => d.points = all.into_iter().map(|e| e.place).collect(),
            "face" => d.faces = all.into_iter().map(|e| e.corners).collect(),
            "edge" => d.lines = all.into_iter().map(|e| e.ends.to_vec()).collect(),
            _ => {}
        }
    }
    Ok(d)
}
