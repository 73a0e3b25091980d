//! Name: what a module is called by, written out only when somebody asks.
//!
//! Decides that a name is the one of its item and where in it the module stands: a generator makes a hundred thousand of
//! them, of which few are ever read. The text of the item is shared by all its modules.

use alloc::sync::Arc;
use core::fmt::{self, Write as _};

/// Where in an item a module stands, e.g. `[3]` or `[3,4]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Index {
    /// it is all of it
    #[default]
    None,
    /// in a row
    One(u32),
    /// on a grid
    Two(u32, u32),
}

impl Index {
    /// The one `n` places behind it, in a row of a grid.
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

/// Which list of an item a module stands in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Part {
    /// its own
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
    /// the item
    pub of: Arc<str>,
    /// the list
    pub part: Part,
    /// its place in it
    pub index: Index,
    /// of a link that became one along each axis, which that is
    pub axis: Option<u8>,
}

impl Name {
    /// Place `index` of a list of the item `of`.
    pub fn new(of: &Arc<str>, part: Part, index: Index) -> Name {
        Name { of: of.clone(), part, index, axis: None }
    }

    /// True where `other` is the module `n` places behind this one.
    pub(crate) fn continues(&self, n: u32, other: &Name) -> bool {
        let same = Arc::ptr_eq(&self.of, &other.of) && (self.part, self.axis) == (other.part, other.axis);
        same && self.index != Index::None && self.index.plus(n) == other.index
    }

    /// The name of the module `n` places behind it.
    #[must_use]
    pub(crate) fn plus(&self, n: u32) -> Name {
        Name { index: self.index.plus(n), ..self.clone() }
    }
}

/// An item as a whole.
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

/// What is left of a text when a name has been taken off its beginning.
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
