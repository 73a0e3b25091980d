//! Names of modules, written out as text only on request.
//!
//! A name is the name of its item and the index of the module in it. A generator makes a hundred thousand names, of
//! which few are read. All modules of an item share its text.

use alloc::sync::Arc;
use core::fmt::{self, Write as _};

/// Index of a module in an item, e.g. `[3]` or `[3,4]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Index {
    /// the whole item
    #[default]
    None,
    /// index in a row
    One(u32),
    /// index in a grid
    Two(u32, u32),
}

impl Index {
    fn plus(self, n: u32) -> Index {
        match self {
            Index::None => Index::None,
            Index::One(i) => Index::One(i + n),
            Index::Two(i, j) => Index::Two(i, j + n),
        }
    }
}

impl From<usize> for Index {
    fn from(i: usize) -> Index {
        Index::One(i as u32)
    }
}

impl From<[usize; 2]> for Index {
    fn from([i, j]: [usize; 2]) -> Index {
        Index::Two(i as u32, j as u32)
    }
}

/// List of an item that contains a module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Part {
    /// the item itself
    #[default]
    Own,
    /// `name.link`
    Link,
    /// `name.end`
    End,
    /// `name.mode`
    Mode,
}

/// The name of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Name {
    /// name of the item
    pub of: Arc<str>,
    /// list within the item
    pub part: Part,
    /// index in the list
    pub index: Index,
    /// axis of a link that was split into one link per axis
    pub axis: Option<u8>,
}

impl Name {
    /// Makes the name of module `index` in a list of the item `of`.
    pub fn new(of: &Arc<str>, part: Part, index: Index) -> Name {
        Name { of: of.clone(), part, index, axis: None }
    }

    /// Returns true if `other` is the module `n` after this one.
    pub(crate) fn continues(&self, n: u32, other: &Name) -> bool {
        let same = Arc::ptr_eq(&self.of, &other.of) && (self.part, self.axis) == (other.part, other.axis);
        same && self.index != Index::None && self.index.plus(n) == other.index
    }

    #[must_use]
    pub(crate) fn plus(&self, n: u32) -> Name {
        Name { index: self.index.plus(n), ..self.clone() }
    }
}

impl From<&Arc<str>> for Name {
    fn from(of: &Arc<str>) -> Name {
        Name::new(of, Part::Own, Index::None)
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.of)?;
        f.write_str(match self.part {
            Part::Own => "",
            Part::Link => ".link",
            Part::End => ".end",
            Part::Mode => ".mode",
        })?;
        match self.index {
            Index::None => {}
            Index::One(i) => write!(f, "[{i}]")?,
            Index::Two(i, j) => write!(f, "[{i},{j}]")?,
        }
        match self.axis {
            None => Ok(()),
            Some(axis) => {
                f.write_char('.')?;
                f.write_char(char::from(b'x' + axis))
            }
        }
    }
}

/// Rest of a text after removing the parts of a name from its start.
struct Rest<'a>(&'a str);

impl fmt::Write for Rest<'_> {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        self.0 = self.0.strip_prefix(part).ok_or(fmt::Error)?;
        Ok(())
    }
}

impl PartialEq<str> for Name {
    fn eq(&self, other: &str) -> bool {
        let mut rest = Rest(other);
        write!(rest, "{self}").is_ok() && rest.0.is_empty()
    }
}

impl PartialEq<&str> for Name {
    fn eq(&self, other: &&str) -> bool {
        *self == **other
    }
}

impl PartialEq<alloc::string::String> for Name {
    fn eq(&self, other: &alloc::string::String) -> bool {
        *self == **other
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    #[test]
    fn a_name_is_written_and_compared_as_its_text() {
        let of: Arc<str> = Arc::from("low");
        let whole = Name::from(&of);
        let link = Name { axis: Some(1), ..Name::new(&of, Part::Link, 12.into()) };
        let node = Name::new(&of, Part::Own, [3, 40].into());
        for (name, text) in [(&whole, "low"), (&link, "low.link[12].y"), (&node, "low[3,40]")] {
            assert_eq!(name.to_string(), text);
            assert!(*name == text && *name != *"low[3]" && *name != *"lo" && *name != *"low[3,40].z");
        }
        assert!(node.continues(2, &node.plus(2)) && !node.continues(1, &node.plus(2)));
        assert!(!whole.continues(1, &whole) && !node.continues(1, &link));
    }
}
