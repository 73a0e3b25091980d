//! PLY clouds: elements `vertex` (x, y, z), `face` and `tristrips` (vertex_indices or vertex_index) and `edge`
//! (vertex1, vertex2), as text or binary of either byte order. Other elements and properties are skipped.
//!
//! Other programs write a byte order mark, blank lines, comments in Latin-1 and lines that end in a carriage return
//! alone. The library refuses all of these, so this module removes them first. It also writes its own messages, because
//! those from the library show its parser.

use super::Drawing;
use crate::error::{FileError, FileErrorKind, lower, shown};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{ErrorKind, Read as _};

#[derive(Default)]
struct Element {
    place: [f64; 3],
    corners: Vec<u32>,
    ends: [u32; 2],
}

/// Number that no point has.
const NOBODY: u32 = u32::MAX;

/// Stands for −1, which begins a new strip.
const NEXT: u32 = u32::MAX - 1;

/// Returns the number of a point. An invalid one is refused later, with all others that name no point.
fn index(v: f64) -> u32 {
    if v >= 0.0 && v < f64::from(NEXT) {
        v as u32
    } else if v == -1.0 {
        NEXT
    } else {
        NOBODY
    }
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

/// The file, cleaned up for the library.
struct Tidy<'b> {
    header: String,
    payload: Cow<'b, [u8]>,
    /// For text, the line of the file for each line of `payload`.
    lines: Vec<usize>,
}

impl Tidy<'_> {
    fn of(bytes: &[u8]) -> Tidy<'_> {
        let mut rest = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let first = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let end = match first.and_then(|at| rest.get(at..)) {
            Some([b'\r', b'\n', ..]) | None => b'\n',
            Some(all) => all[0],
        };
        let (mut header, mut lines, mut ascii) = (String::new(), Vec::new(), false);
        let mut n = 0;
        while !rest.is_empty() {
            let at = rest.iter().position(|b| *b == end).map_or(rest.len(), |at| at + 1);
            let (line, after) = rest.split_at(at);
            rest = after;
            n += 1;
            let line = String::from_utf8_lossy(line);
            let line = line.trim();
            let word = line.split_whitespace().next().unwrap_or("comment");
            let _ = writeln!(header, "{}", if matches!(word, "comment" | "obj_info") { "comment" } else { line });
            ascii |= word == "format" && line.contains("ascii");
            if word == "end_header" {
                break;
            }
        }
        if !ascii {
            return Tidy { header, payload: rest.into(), lines };
        }
        let mut payload = String::with_capacity(rest.len());
        for line in super::lines(&String::from_utf8_lossy(rest)) {
            n += 1;
            if !line.trim().is_empty() {
                payload.extend([line, "\n"]);
                lines.push(n);
            }
        }
        Tidy { header, payload: payload.into_bytes().into(), lines }
    }

    /// Returns a line by its number in the cleaned-up file: its number in the original file, and its text.
    fn line(&self, n: usize) -> Option<(usize, Cow<'_, str>)> {
        let above = self.header.lines().count();
        if n <= above {
            return Some((n, self.header.lines().nth(n.checked_sub(1)?)?.into()));
        }
        let at = n - above - 1;
        let text = self.payload.split(|b| *b == b'\n').nth(at)?;
        Some((*self.lines.get(at)?, String::from_utf8_lossy(text)))
    }

    fn wrong(&self, e: &ParseError, element: Option<&ElementDef>) -> FileError {
        const ANEW: &str = "export it again, as text or binary PLY";
        let (what, fix) = match (element, e.line().and_then(|n| self.line(n))) {
            (Some(element), _) if e.kind() == ErrorKind::UnexpectedEof => {
                (format!("it ends before the last of its {} elements `{}`", element.count, element.name), ANEW)
            }
            (None, _) if e.kind() == ErrorKind::UnexpectedEof => ("its header lacks `end_header`".into(), ANEW),
            (element, Some((n, text))) => {
                let comma = |word: &&str| word.contains(',') && word.replace(',', ".").parse::<f64>().is_ok();
                let (what, fix) = match (element, text.split_whitespace().find(comma)) {
                    (Some(_), Some(word)) => (format!("`{}` is not a number", shown(word)), super::POINT),
                    (Some(element), None) => {
                        let names: Vec<&str> = element.properties.keys().map(String::as_str).collect();
                        let has = format!("a `{}` with the properties {}", element.name, names.join(", "));
                        (format!("`{}` is not {has}", shown(text.trim())), ANEW)
                    }
                    (None, _) if n == 1 => (format!("the first line is `{}`, not `ply`", shown(&text)), ANEW),
                    (None, _) => (format!("`{}` is not a header line", shown(&text)), ANEW),
                };
                return FileError::new(FileErrorKind::Format, what).at(format!("line {n}")).fix(fix);
            }
            (_, None) => {
                let text = e.to_string();
                let first = text.lines().next().unwrap_or("").trim_end_matches('.');
                let first = first.split_once(": ").filter(|_| e.line().is_some()).map_or(first, |t| t.1);
                (lower(&shown(first)), ANEW)
            }
        };
        FileError::new(FileErrorKind::Format, what).fix(fix)
    }
}

/// Returns the triangles of a strip: each corner with the two before it. A triangle without area is skipped.
fn triangles(strip: &[u32]) -> impl Iterator<Item = Vec<u32>> {
    let whole = |t: &&[u32]| t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
    strip.split(|c| *c == NEXT).flat_map(move |s| s.windows(3).filter(whole).map(<[u32]>::to_vec))
}

pub(super) fn read(bytes: &[u8]) -> Result<Drawing, FileError> {
    let tidy = Tidy::of(bytes);
    let mut reader = Reader::new(tidy.header.as_bytes().chain(&tidy.payload[..]));
    let parser = Parser::<Element>::new();
    let header = parser.read_header(&mut reader).map_err(|e| tidy.wrong(&e, None))?;
    let mut d = Drawing::default();
    for (name, element) in &header.elements {
        if name == "vertex" {
            super::not_too_many(element.count)?;
            if let Some(missing) = ["x", "y", "z"].into_iter().find(|p| !element.properties.contains_key(*p)) {
                return Err(FileError::content(format!("its points lack `{missing}`")).fix("export x, y and z"));
            }
        }
        let all = parser.read_payload_for_element(&mut reader, element, &header);
        let all = all.map_err(|e| tidy.wrong(&e, Some(element)))?;
        match name.as_str() {
            "vertex" => d.points = all.into_iter().map(|e| e.place).collect(),
            "face" => d.faces.extend(all.into_iter().map(|e| e.corners)),
            "tristrips" => d.faces.extend(all.iter().flat_map(|e| triangles(&e.corners))),
            "edge" => d.lines = all.into_iter().map(|e| e.ends.to_vec()).collect(),
            _ => {}
        }
    }
    let corners = |all: &[Vec<u32>]| all.iter().flatten().any(|c| *c >= NEXT);
    if let Some((what, _)) = [("face", &d.faces), ("line", &d.lines)].into_iter().find(|(_, all)| corners(all)) {
        let what = format!("a {what} refers to a point by a value that is negative, too large or not a number");
        return Err(
            FileError::content(what).fix(format!("the points are counted from 0, and there are {}", d.points.len()))
        );
    }
    Ok(d)
}
