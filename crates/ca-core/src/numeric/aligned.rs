//! Aligned: an array of numbers that begins at a cache line.
//!
//! A vector of eight that crosses from one line to the next is read twice: a long folded row (`op/links/folded.rs`) then takes
//! half as long again. Decides for a `Vec` with room for the way to the next line, in safe code: a type of its own alignment
//! could not be seen as plain numbers without unsafe code, and a crate that does so brings more than this file. What a tick
//! computes does not depend on where an array begins.

use crate::numeric::{Real, real};
use alloc::vec::Vec;
use core::fmt;
use core::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;
/// The same in numbers.
const NUMBERS: usize = LINE / size_of::<Real>();

/// Numbers that begin at a cache line; a slice in all else. Its length is that it was made with.
#[derive(Default)]
pub struct Aligned {
    /// nothing stands behind the last, so that one compare finds them
    all: Vec<Real>,
    /// where the first number stands in `all`
    first: usize,
}

impl Aligned {
    /// `len` times 0.
    pub fn zeros(len: usize) -> Aligned {
        let mut all = alloc::vec![real(0.0); len + NUMBERS - 1];
        // where the address cannot be asked for, any is as good
        let first = all.as_ptr().align_offset(LINE).min(NUMBERS - 1);
        all.truncate(first + len);
        Aligned { all, first }
    }
}

impl Deref for Aligned {
    type Target = [Real];
    #[inline(always)]
    fn deref(&self) -> &[Real] {
        &self.all[self.first..]
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Real] {
        &mut self.all[self.first..]
    }
}

impl From<&[Real]> for Aligned {
    fn from(from: &[Real]) -> Aligned {
        let mut to = Aligned::zeros(from.len());
        to.copy_from_slice(from);
        to
    }
}

impl FromIterator<Real> for Aligned {
    fn from_iter<I: IntoIterator<Item = Real>>(all: I) -> Aligned {
        Aligned::from(&all.into_iter().collect::<Vec<Real>>()[..])
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Aligned {
        Aligned::from(&self[..])
    }

    /// Allocates nothing where the lengths agree.
    fn clone_from(&mut self, from: &Aligned) {
        if self.len() == from.len() {
            self.copy_from_slice(from);
        } else {
            *self = from.clone();
        }
    }
}

impl PartialEq for Aligned {
    fn eq(&self, other: &Aligned) -> bool {
        self[..] == other[..]
    }
}

impl fmt::Debug for Aligned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self[..].fmt(f)
    }
}

impl<'a> IntoIterator for &'a Aligned {
    type Item = &'a Real;
    type IntoIter = core::slice::Iter<'a, Real>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Aligned {
    type Item = &'a mut Real;
    type IntoIter = core::slice::IterMut<'a, Real>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_array_begins_at_a_line_and_keeps_its_numbers() {
        for n in [0, 1, 7, 8, 9, 1000] {
            let numbers: Vec<Real> = (0..n).map(|i| real(f64::from(i))).collect();
            let mut a: Aligned = numbers.iter().copied().collect();
            assert_eq!(a[..], numbers[..]);
            assert_eq!(a.as_ptr() as usize % LINE, 0, "{n} numbers");
            let moved = alloc::boxed::Box::new(a.clone());
            assert_eq!((moved.as_ptr() as usize % LINE, *moved == a), (0, true));
            a.iter_mut().for_each(|v| *v += 1.0);
            assert!(n == 0 || a != *moved);
            a.clone_from(&moved);
            assert_eq!(a, *moved);
            a.clone_from(&Aligned::zeros(3));
            assert_eq!(a[..], [real(0.0); 3]);
        }
    }
}
