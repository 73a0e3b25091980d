//! Families: the modules under each name of the network.
//!
//! Names are in a hash map, because a model written module by module has hundreds of thousands of them. A name of a
//! single module is stored as one number; only generators have lists. Only findings need the names in order, and sort
//! them.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::slice;
use hashbrown::HashMap;

/// The modules that a name refers to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Family {
    /// MATs of `name[i]`.
    pub masses: Vec<u32>,
    /// LIAs of `name.link[i]`.
    pub links: Vec<u32>,
    /// Fixed points of `name.end[i]`.
    pub anchors: Vec<u32>,
    /// Nodes that a moving point can be between.
    pub nodes: Vec<u32>,
    /// Arrangement of the nodes; `[n, 1]` for a row.
    pub size: [u32; 2],
}

/// A [`Family`] by reference.
#[derive(Clone, Copy, Debug, Default)]
pub struct Members<'a> {
    /// See [`Family::masses`].
    pub masses: &'a [u32],
    /// See [`Family::links`].
    pub links: &'a [u32],
    /// See [`Family::anchors`].
    pub anchors: &'a [u32],
    /// See [`Family::nodes`].
    pub nodes: &'a [u32],
    /// See [`Family::size`].
    pub size: [u32; 2],
}

enum Kept {
    Mat(u32),
    Link(u32),
    Many(Box<Family>),
}

impl Kept {
    fn members(&self) -> Members<'_> {
        match self {
            Kept::Mat(m) => Members { masses: slice::from_ref(m), size: [1, 1], ..Members::default() },
            Kept::Link(l) => Members { links: slice::from_ref(l), ..Members::default() },
            Kept::Many(f) => {
                let Family { masses, links, anchors, nodes, size } = &**f;
                Members { masses, links, anchors, nodes, size: *size }
            }
        }
    }
}

/// All names of a network.
#[derive(Default)]
pub struct Families(HashMap<Arc<str>, Kept>);

impl Families {
    /// Adds a name for the modules of a generator.
    pub fn insert(&mut self, name: &Arc<str>, family: Family) {
        self.0.insert(name.clone(), Kept::Many(Box::new(family)));
    }

    /// Adds a name for one MAT.
    pub fn insert_mat(&mut self, name: &Arc<str>, mat: u32) {
        self.0.insert(name.clone(), Kept::Mat(mat));
    }

    /// Adds links to a name.
    pub fn insert_links(&mut self, name: &Arc<str>, links: Vec<u32>) {
        match (self.0.get_mut(name), &links[..]) {
            (Some(Kept::Many(f)), _) => f.links = links,
            (Some(Kept::Mat(m)), _) => {
                let family = Family { masses: alloc::vec![*m], links, size: [1, 1], ..Family::default() };
                self.insert(name, family);
            }
            (_, [one]) => {
                self.0.insert(name.clone(), Kept::Link(*one));
            }
            _ => self.insert(name, Family { links, ..Family::default() }),
        }
    }

    /// Returns the modules of a name.
    pub fn get(&self, name: &str) -> Option<Members<'_>> {
        self.0.get(name).map(Kept::members)
    }

    /// Returns the modules of a name that is known to exist.
    pub fn of(&self, name: &str) -> Members<'_> {
        self.get(name).unwrap_or_default()
    }

    /// Returns all names, sorted.
    pub fn names(&self) -> Vec<&str> {
        let mut all: Vec<&str> = self.0.keys().map(|name| &**name).collect();
        all.sort_unstable();
        all
    }

    /// Replaces link numbers by `new`; `u32::MAX` marks removed links.
    pub fn renumber(&mut self, new: &[u32]) {
        for kept in self.0.values_mut() {
            match kept {
                Kept::Mat(_) => {}
                Kept::Link(l) => match new[*l as usize] {
                    u32::MAX => *kept = Kept::Many(Box::default()),
                    now => *l = now,
                },
                Kept::Many(f) => f.links.retain_mut(|l| {
                    *l = new[*l as usize];
                    *l != u32::MAX
                }),
            }
        }
    }
}
