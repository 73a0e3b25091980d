//! Families: the modules under each name of the network.
//!
//! Decides on a hash map, since a model written one by one has hundreds of thousands of names, and on one number for a name
//! that means one module: lists are for what generators made. Who needs the names in order sorts them, which only findings
//! do.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::slice;
use hashbrown::HashMap;

/// What a name means.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Family {
    /// MATs that `name[i]` means
    pub masses: Vec<u32>,
    /// LIAs that `name.link[i]` means
    pub links: Vec<u32>,
    /// fixed points that `name.end[i]` means
    pub anchors: Vec<u32>,
    /// nodes a moving point may stand between
    pub nodes: Vec<u32>,
    /// their arrangement; `[n, 1]` in a row
    pub size: [u32; 2],
}

/// The same as it is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Members<'a> {
    /// see [`Family::masses`]
    pub masses: &'a [u32],
    /// see [`Family::links`]
    pub links: &'a [u32],
    /// see [`Family::anchors`]
    pub anchors: &'a [u32],
    /// see [`Family::nodes`]
    pub nodes: &'a [u32],
    /// see [`Family::size`]
    pub size: [u32; 2],
}

/// The same as it is kept.
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
    /// A name for what a generator made.
    pub fn insert(&mut self, name: &Arc<str>, family: Family) {
        self.0.insert(name.clone(), Kept::Many(Box::new(family)));
    }

    /// A name for one MAT.
    pub fn insert_mat(&mut self, name: &Arc<str>, mat: u32) {
        self.0.insert(name.clone(), Kept::Mat(mat));
    }

    /// The links that a name means too.
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

    /// What a name means.
    pub fn get(&self, name: &str) -> Option<Members<'_>> {
        self.0.get(name).map(Kept::members)
    }

    /// What a name means that is known to be there.
    pub fn of(&self, name: &str) -> Members<'_> {
        self.get(name).unwrap_or_default()
    }

    /// All names, sorted.
    pub fn names(&self) -> Vec<&str> {
        let mut all: Vec<&str> = self.0.keys().map(|name| &**name).collect();
        all.sort_unstable();
        all
    }

    /// Gives links their new numbers; `u32::MAX` for those that are no more.
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
