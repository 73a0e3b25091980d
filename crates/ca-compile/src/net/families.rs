//! Families: the modules under each name of the network.
//!
//! Decides on a table of hashes over a list, since a model written one by one has hundreds of thousands of names, and on one
//! number for a name that means one module: lists are for what generators made. Who needs the names in order sorts them,
//! which only findings do.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_model::names::hash;
use core::slice;

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
pub struct Families {
    list: Vec<(Arc<str>, Kept)>,
    /// places in the list and 1, by hash; 0 where there is none
    table: Vec<u32>,
}

impl Families {
    /// Where a name stands in the table, or where it would.
    fn slot(&self, name: &str) -> usize {
        let mask = self.table.len() - 1;
        let mut at = hash(name) as usize & mask;
        while let Some((known, _)) = (self.table[at] as usize).checked_sub(1).map(|i| &self.list[i]) {
            if **known == *name {
                break;
            }
            at = (at + 1) & mask;
        }
        at
    }

    fn place(&self, name: &str) -> Option<usize> {
        if self.table.is_empty() { None } else { (self.table[self.slot(name)] as usize).checked_sub(1) }
    }

    /// Says what a name means.
    fn put(&mut self, name: &Arc<str>, kept: Kept) {
        if let Some(i) = self.place(name) {
            self.list[i].1 = kept;
            return;
        }
        self.list.push((name.clone(), kept));
        // at most two thirds full
        if 3 * self.list.len() > 2 * self.table.len() {
            self.table = alloc::vec![0; (2 * self.table.len()).max(16)];
            for i in 0..self.list.len() {
                let at = self.slot(&self.list[i].0);
                self.table[at] = i as u32 + 1;
            }
        } else {
            let at = self.slot(name);
            self.table[at] = self.list.len() as u32;
        }
    }

    /// A name for what a generator made.
    pub fn insert(&mut self, name: &Arc<str>, family: Family) {
        self.put(name, Kept::Many(Box::new(family)));
    }

    /// A name for one MAT.
    pub fn insert_mat(&mut self, name: &Arc<str>, mat: u32) {
        self.put(name, Kept::Mat(mat));
    }

    /// The links that a name means too.
    pub fn insert_links(&mut self, name: &Arc<str>, links: Vec<u32>) {
        let known = self.place(name).map(|i| &mut self.list[i].1);
        match (known, &links[..]) {
            (Some(Kept::Many(f)), _) => f.links = links,
            (Some(Kept::Mat(m)), _) => {
                let family = Family { masses: alloc::vec![*m], links, size: [1, 1], ..Family::default() };
                self.put(name, Kept::Many(Box::new(family)));
            }
            (_, [one]) => self.put(name, Kept::Link(*one)),
            _ => self.insert(name, Family { links, ..Family::default() }),
        }
    }

    /// What a name means.
    pub fn get(&self, name: &str) -> Option<Members<'_>> {
        self.place(name).map(|i| self.list[i].1.members())
    }

    /// What a name means that is known to be there.
    pub fn of(&self, name: &str) -> Members<'_> {
        self.get(name).unwrap_or_default()
    }

    /// All names, sorted.
    pub fn names(&self) -> Vec<&str> {
        let mut all: Vec<&str> = self.list.iter().map(|f| &*f.0).collect();
        all.sort_unstable();
        all
    }

    /// Gives links their new numbers; `u32::MAX` for those that are no more.
    pub fn renumber(&mut self, new: &[u32]) {
        for (_, kept) in &mut self.list {
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
