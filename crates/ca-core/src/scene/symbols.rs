//! Symbols: name, kind and place of every module of a scene.
//!
//! Decides that modules one behind the other in an item are one run: a string of 10⁵ masses keeps one name, not as many. A
//! [`Symbol`] is made when it is asked for.

use crate::kind::name::Name;
use alloc::vec::Vec;

/// Code of a mode. It stands in place of masses, and lacks a kind.
pub const MODE: &str = "mode";

/// Name, kind and place of a module that was compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    /// e.g. `low[3]`
    pub name: Name,
    /// code of what runs, e.g. `MAS`, `RES`
    pub code: &'static str,
    /// axes along which a MAT moves: 1 on a line, 2 in a plane, 3 in space; 1 for a LIA
    pub axes: u8,
    /// where it stands
    pub location: Location,
}

/// Where a module stands in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// a MAT: index into [`State::x`](crate::State::x), the first of three where it has more than one axis
    Mat(u32),
    /// a LIA: op number in [`Passes::forces`](super::Passes::forces) and position in it
    Lia(u32, u32),
}

/// Modules one behind the other, of one kind.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    /// the first of them
    pub(super) name: Name,
    pub(super) code: &'static str,
    pub(super) axes: u8,
    /// how many modules there are before it
    pub(super) first: u32,
}

/// All modules of a scene, MATs first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Symbols {
    pub(super) runs: Vec<Run>,
    /// places of the MATs
    pub(super) mats: Vec<u32>,
    /// places of the LIAs
    pub(super) lias: Vec<[u32; 2]>,
}

impl Symbols {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.mats.len() + self.lias.len()
    }

    /// True where there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// MATs by number.
    pub fn mats(&self) -> usize {
        self.mats.len()
    }

    /// Places of the MATs, in document order: indices into [`State::x`](crate::State::x), the first of each.
    pub fn places(&self) -> &[u32] {
        &self.mats
    }

    /// Places of the LIAs: op number and position in it.
    pub fn lias(&self) -> &[[u32; 2]] {
        &self.lias
    }

    fn run(&self, i: usize) -> Option<&Run> {
        self.runs.get(self.runs.partition_point(|r| r.first as usize <= i).checked_sub(1)?)
    }

    /// Module `i`.
    pub fn get(&self, i: usize) -> Option<Symbol> {
        let location = match i.checked_sub(self.mats.len()) {
            None => Location::Mat(*self.mats.get(i)?),
            Some(l) => self.lias.get(l).map(|[op, at]| Location::Lia(*op, *at))?,
        };
        let run = self.run(i)?;
        Some(Symbol { name: run.name.plus(i as u32 - run.first), code: run.code, axes: run.axes, location })
    }

    /// All of them, in document order.
    pub fn iter(&self) -> impl Iterator<Item = Symbol> + '_ {
        (0..self.len()).filter_map(|i| self.get(i))
    }

    /// The name of the MAT at a place of the state.
    pub(crate) fn mat(&self, place: usize) -> Option<Name> {
        let here = |(i, at): (usize, &u32)| {
            let slots = |axes| if axes > 1 { 3 } else { 1 };
            let at = *at as usize;
            let near = (at..at + 3).contains(&place);
            (near && self.run(i).is_some_and(|r| place < at + slots(r.axes))).then_some(i)
        };
        self.get(self.mats.iter().enumerate().find_map(here)?).map(|s| s.name)
    }

    /// The name of link `i` of a pass.
    pub(crate) fn lia(&self, op: usize, i: usize) -> Option<Name> {
        let at = self.lias.iter().position(|l| *l == [op as u32, i as u32])?;
        self.get(self.mats.len() + at).map(|s| s.name)
    }
}

impl<'a> IntoIterator for &'a Symbols {
    type Item = Symbol;
    type IntoIter = alloc::boxed::Box<dyn Iterator<Item = Symbol> + 'a>;
    fn into_iter(self) -> Self::IntoIter {
        alloc::boxed::Box::new(self.iter())
    }
}

/// The symbols of a scene that is being compiled.
pub struct SymbolsBuilder(Symbols);

impl SymbolsBuilder {
    /// Room for this number of MATs and LIAs.
    pub fn with_capacity(mats: usize, lias: usize) -> SymbolsBuilder {
        SymbolsBuilder(Symbols { runs: Vec::new(), mats: Vec::with_capacity(mats), lias: Vec::with_capacity(lias) })
    }

    /// Adds a module; all MATs come before the first LIA.
    pub fn push(&mut self, name: &Name, code: &'static str, axes: u8, location: Location) {
        let all = &mut self.0;
        let first = all.len() as u32;
        let joins = all.runs.last().is_some_and(|r| {
            let n = first - r.first;
            (r.code, r.axes) == (code, axes) && r.name.continues(n, name)
        });
        if !joins {
            all.runs.push(Run { name: name.clone(), code, axes, first });
        }
        match location {
            Location::Mat(at) => all.mats.push(at),
            Location::Lia(op, i) => all.lias.push([op, i]),
        }
    }

    /// Puts the LIAs of each pass where the pass now stands in the list.
    pub fn renumber(&mut self, place: &[u32]) {
        self.0.lias.iter_mut().for_each(|[op, _]| *op = place[*op as usize]);
    }

    /// The symbols, without the room that nothing takes.
    pub fn build(mut self) -> Symbols {
        self.0.runs.shrink_to_fit();
        self.0
    }
}
