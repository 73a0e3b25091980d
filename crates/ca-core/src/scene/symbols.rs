//! Symbols: name, kind and location of every module of a scene.
//!
//! Consecutive modules of an item are one run: a string of 10⁵ masses stores one name. A [`Symbol`] is made on request.

use crate::kind::name::Name;
use alloc::vec::Vec;

/// Code of a mode. A mode replaces masses and has no kind.
pub const MODE: &str = "mode";

/// Name, kind and location of a compiled module.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    /// name, e.g. `low[3]`
    pub name: Name,
    /// code of what runs, e.g. `MAS`, `RES`
    pub code: &'static str,
    /// axes along which a MAT moves: 1 on a line, 2 in a plane, 3 in space; 1 for a LIA
    pub axes: u8,
    /// location in the state
    pub location: Location,
}

/// Location of a module in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// a MAT: index into [`State::x`](crate::State::x), the first of three if it has more than one axis
    Mat(u32),
    /// a LIA: op number in [`Passes::forces`](super::Passes::forces) and position in it
    Lia(u32, u32),
}

/// Consecutive modules of one kind.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    pub(super) name: Name,
    pub(super) code: &'static str,
    pub(super) axes: u8,
    /// number of modules before it
    pub(super) first: u32,
}

/// All modules of a scene, MATs first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Symbols {
    pub(super) runs: Vec<Run>,
    /// slots of the MATs
    pub(super) mats: Vec<u32>,
    /// locations of the LIAs
    pub(super) lias: Vec<[u32; 2]>,
}

impl Symbols {
    /// Returns the number of modules.
    pub fn len(&self) -> usize {
        self.mats.len() + self.lias.len()
    }

    /// Returns true if there are no modules.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of MATs.
    pub fn mats(&self) -> usize {
        self.mats.len()
    }

    /// Returns the slots of the MATs in document order: indices into [`State::x`](crate::State::x), the first of each.
    pub fn places(&self) -> &[u32] {
        &self.mats
    }

    /// Returns the locations of the LIAs: op number and position in it.
    pub fn lias(&self) -> &[[u32; 2]] {
        &self.lias
    }

    fn run(&self, i: usize) -> Option<&Run> {
        self.runs.get(self.runs.partition_point(|r| r.first as usize <= i).checked_sub(1)?)
    }

    /// Returns module `i`.
    pub fn get(&self, i: usize) -> Option<Symbol> {
        let location = match i.checked_sub(self.mats.len()) {
            None => Location::Mat(*self.mats.get(i)?),
            Some(l) => self.lias.get(l).map(|[op, at]| Location::Lia(*op, *at))?,
        };
        let run = self.run(i)?;
        Some(Symbol { name: run.name.plus(i as u32 - run.first), code: run.code, axes: run.axes, location })
    }

    /// Iterates over all modules, in document order.
    pub fn iter(&self) -> impl Iterator<Item = Symbol> + '_ {
        (0..self.len()).filter_map(|i| self.get(i))
    }

    pub(crate) fn mat(&self, place: usize) -> Option<Name> {
        let here = |(i, at): (usize, &u32)| {
            let slots = |axes| if axes > 1 { 3 } else { 1 };
            let at = *at as usize;
            let near = (at..at + 3).contains(&place);
            (near && self.run(i).is_some_and(|r| place < at + slots(r.axes))).then_some(i)
        };
        self.get(self.mats.iter().enumerate().find_map(here)?).map(|s| s.name)
    }

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

/// Collects the symbols of a scene during compilation.
pub struct SymbolsBuilder(Symbols);

impl SymbolsBuilder {
    /// Allocates for this number of MATs and LIAs.
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

    /// Renumbers the passes of the LIAs: `place` gives the new index of each pass.
    pub fn renumber(&mut self, place: &[u32]) {
        self.0.lias.iter_mut().for_each(|[op, _]| *op = place[*op as usize]);
    }

    /// Returns the symbols, without unused capacity.
    pub fn build(mut self) -> Symbols {
        self.0.runs.shrink_to_fit();
        self.0
    }
}
