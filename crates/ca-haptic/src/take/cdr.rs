//! CDR encoding of the records of a take, and a reader by definition.
//!
//! Records are plain little-endian CDR (header `00 01 00 00`, natural alignment counted after it) with a ROS 2
//! definition, which every viewer and NumPy reads. A structure without padding *is* its body. Only a few records have
//! lists or texts, so this module has a small writer instead of a crate. The reader by definition serves exports.

use crate::engine::Change;
use ca_core::Patch;
use ca_io::error::FileError;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// The first bytes of every message.
pub const HEAD: [u8; 4] = [0, 1, 0, 0];

/// Parameters that changed in one tick: `ca/msg/Change`.
pub const CHANGE: &str = "\
uint64 tick
uint32[] param
float64[] value
uint32[] length
uint32[] place
float64[] coef
";
/// One of these parameters, for people: `ca/msg/Param`.
pub const PARAM: &str = "\
uint64 tick
float64 value
string name
";
/// A device that described itself: `ca/msg/Profile`.
pub const PROFILE: &str = "\
uint64 tick
uint32 port
string profile
";
/// A stretch of sound, exact: `ca/msg/Sound`.
pub const SOUND: &str = "\
uint64 tick
uint32 channels
uint32 reserved
float64[] samples
";

/// Writes a structure as a message.
pub fn body<T: IntoBytes + Immutable>(out: &mut Vec<u8>, record: &T) {
    out.clear();
    out.extend_from_slice(&HEAD);
    out.extend_from_slice(record.as_bytes());
}

/// Reads a message as a structure; `None` where it has another length or is not CDR.
pub fn record<T: FromBytes>(data: &[u8]) -> Option<T> {
    T::read_from_bytes(data.strip_prefix(&HEAD)?).ok()
}

/// Writer of a message with lists.
pub struct Out<'a>(&'a mut Vec<u8>);

impl<'a> Out<'a> {
    /// Begins a message in `to`.
    pub fn new(to: &'a mut Vec<u8>) -> Out<'a> {
        to.clear();
        to.extend_from_slice(&HEAD);
        Out(to)
    }

    fn align(&mut self, n: usize) {
        let past = (self.0.len() - HEAD.len()) % n;
        if past > 0 {
            self.0.resize(self.0.len() + n - past, 0);
        }
    }

    /// Writes a number.
    pub fn put<T: IntoBytes + Immutable + Copy>(&mut self, v: T) -> &mut Self {
        self.align(size_of::<T>());
        self.0.extend_from_slice(v.as_bytes());
        self
    }

    /// Writes a list.
    pub fn list<T: IntoBytes + Immutable>(&mut self, v: &[T]) -> &mut Self {
        self.put(v.len() as u32);
        if !v.is_empty() {
            self.align(size_of::<T>());
            self.0.extend_from_slice(v.as_bytes());
        }
        self
    }

    /// Writes a text.
    pub fn text(&mut self, v: &str) -> &mut Self {
        self.put(v.len() as u32 + 1);
        self.0.extend_from_slice(v.as_bytes());
        self.0.push(0);
        self
    }
}

/// Reader of a message with lists. The first read that does not fit, and every one after it, returns `None`.
pub struct In<'a> {
    data: &'a [u8],
    at: usize,
}

impl<'a> In<'a> {
    /// Starts at the beginning of a message; `None` where it is not CDR.
    pub fn new(data: &'a [u8]) -> Option<In<'a>> {
        Some(In { data: data.strip_prefix(&HEAD)?, at: 0 })
    }

    fn bytes(&mut self, align: usize, n: usize) -> Option<&'a [u8]> {
        let from = self.at.next_multiple_of(align);
        let to = from.checked_add(n)?;
        let found = self.data.get(from..to)?;
        self.at = to;
        Some(found)
    }

    /// Reads a number.
    pub fn get<T: FromBytes>(&mut self) -> Option<T> {
        T::read_from_bytes(self.bytes(size_of::<T>(), size_of::<T>())?).ok()
    }

    /// Reads a list.
    pub fn list<T: FromBytes>(&mut self) -> Option<Vec<T>> {
        let n = self.get::<u32>()? as usize;
        if n == 0 {
            return Some(Vec::new());
        }
        let raw = self.bytes(size_of::<T>(), n.checked_mul(size_of::<T>())?)?;
        raw.chunks_exact(size_of::<T>()).map(|c| T::read_from_bytes(c).ok()).collect()
    }

    /// Reads a text.
    pub fn text(&mut self) -> Option<String> {
        let n = self.get::<u32>()? as usize;
        let raw = self.bytes(1, n)?;
        Some(String::from_utf8_lossy(raw.strip_suffix(&[0]).unwrap_or(raw)).into_owned())
    }
}

/// Writes a change as a message.
pub fn change(out: &mut Vec<u8>, tick: u64, c: &Change) {
    let (param, value): (Vec<u32>, Vec<f64>) = c.params.iter().copied().unzip();
    let length: Vec<u32> = c.patches.iter().map(|p| p.set.len() as u32).collect();
    let (place, coef): (Vec<u32>, Vec<f64>) = c.patches.iter().flat_map(|p| p.set.iter().copied()).unzip();
    Out::new(out).put(tick).list(&param).list(&value).list(&length).list(&place).list(&coef);
}

/// Reads a message as its tick and change. The patches belong to no scene, because a message names none.
pub fn read_change(data: &[u8]) -> Option<(u64, Change)> {
    let mut r = In::new(data)?;
    let tick = r.get()?;
    let (param, value): (Vec<u32>, Vec<f64>) = (r.list()?, r.list()?);
    let (length, place, coef): (Vec<u32>, Vec<u32>, Vec<f64>) = (r.list()?, r.list()?, r.list()?);
    if param.len() != value.len() || place.len() != coef.len() {
        return None;
    }
    let mut all = place.into_iter().zip(coef);
    let mut patch = |n: &u32| Patch { set: all.by_ref().take(*n as usize).collect(), ..Patch::default() };
    let patches: Vec<Patch> = length.iter().map(&mut patch).collect();
    let whole = patches.iter().zip(&length).all(|(p, n)| p.set.len() == *n as usize) && all.next().is_none();
    whole.then(|| (tick, Change { params: param.into_iter().zip(value).collect(), patches }))
}

/// Type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Unsigned integer of this many bytes.
    Uint(usize),
    /// Floating point of this many bytes.
    Float(usize),
    /// Text.
    Text,
}

impl Kind {
    /// Returns the bytes per element.
    pub fn size(self) -> usize {
        match self {
            Kind::Uint(n) | Kind::Float(n) => n,
            Kind::Text => 1,
        }
    }
}

/// A field of a definition.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Kind,
    /// Number of elements: `None` for a list, 1 for a number.
    pub count: Option<usize>,
}

impl Field {
    /// Returns its bytes in a message; 0 for lists and texts.
    pub fn size(&self) -> usize {
        if self.kind == Kind::Text { 0 } else { self.count.unwrap_or(0) * self.kind.size() }
    }

    /// Returns true if it has the same size in all messages.
    pub fn is_fixed(&self) -> bool {
        self.count.is_some() && self.kind != Kind::Text
    }
}

/// Parses the fields of a definition, in order; unknown ones are left out.
pub fn fields(schema: &str) -> Vec<Field> {
    let field = |line: &str| {
        let (ty, name) = line.trim().split_once(' ')?;
        let (base, count) = match ty.strip_suffix(']').and_then(|t| t.split_once('[')) {
            Some((base, "")) => (base, None),
            Some((base, n)) => (base, Some(n.parse().ok()?)),
            None => (ty, Some(1)),
        };
        let kind = match base {
            "uint8" => Kind::Uint(1),
            "uint16" => Kind::Uint(2),
            "uint32" => Kind::Uint(4),
            "uint64" => Kind::Uint(8),
            "float32" => Kind::Float(4),
            "float64" => Kind::Float(8),
            "string" => Kind::Text,
            _ => return None,
        };
        Some(Field { name: name.into(), kind, count })
    };
    schema.lines().filter_map(field).collect()
}

/// Formats the values of a field exactly, for people.
///
/// # Errors
/// If the bytes end before the field does.
pub fn show(field: &Field, r: &mut In) -> Result<Vec<String>, FileError> {
    let read = |r: &mut In| -> Option<Vec<String>> {
        if field.kind == Kind::Text {
            return Some(vec![r.text()?]);
        }
        let n = match field.count {
            Some(n) => n,
            None => r.get::<u32>()? as usize,
        };
        let one = |r: &mut In| {
            Some(match field.kind {
                Kind::Uint(1) => r.get::<u8>()?.to_string(),
                Kind::Uint(2) => r.get::<u16>()?.to_string(),
                Kind::Uint(4) => r.get::<u32>()?.to_string(),
                Kind::Float(4) => r.get::<f32>()?.to_string(),
                Kind::Float(_) => r.get::<f64>()?.to_string(),
                _ => r.get::<u64>()?.to_string(),
            })
        };
        (0..n).map(|_| one(r)).collect()
    };
    read(r).ok_or_else(|| FileError::format(format!("a message ends within `{}`", field.name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{DeviceFrame, ForceFrame};

    #[test]
    fn a_change_comes_back() {
        let some = Change {
            params: vec![(0, 0.1), (7, -1.0 / 3.0)],
            patches: vec![
                Patch { set: vec![(1, 2.0), (3, f64::MIN_POSITIVE)], ..Patch::default() },
                Patch::default(),
                Patch { set: vec![(9, 1e300)], ..Patch::default() },
            ],
        };
        let mut data = Vec::new();
        for c in [some, Change::default()] {
            change(&mut data, 12, &c);
            assert_eq!(read_change(&data), Some((12, c)));
            for cut in 0..data.len() {
                assert!(read_change(&data[..cut]).is_none(), "cut at {cut}");
            }
        }
        // lengths beyond the data
        let mut data = Vec::new();
        Out::new(&mut data).put(1u64).list(&[0u32; 0]).list(&[0f64; 0]).list(&[2u32]).list(&[1u32]).list(&[0.5f64]);
        assert!(read_change(&data).is_none());
    }

    #[test]
    fn lists_and_texts_are_read_by_definition() {
        let mut data = Vec::new();
        Out::new(&mut data).put(5u64).put(0.1f64).text("a b");
        let mut r = In::new(&data).unwrap();
        let all: Vec<Vec<String>> = fields(PARAM).iter().map(|f| show(f, &mut r).unwrap()).collect();
        assert_eq!(all, [["5"], ["0.1"], ["a b"]]);
        assert_eq!(fields(DeviceFrame::SCHEMA).iter().map(Field::size).sum::<usize>(), size_of::<DeviceFrame>());
        assert_eq!(fields(ForceFrame::SCHEMA).iter().map(Field::size).sum::<usize>(), size_of::<ForceFrame>());
    }
}
