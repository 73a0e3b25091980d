//! Aligned: an array of numbers that begins at a cache line.
//!
//! A vector of eight that crosses from one line to the next is read twice: a long folded row (`op/links/folded.rs`) then takes
//! half as long again. Decides for a `Vec` with room for the way to the next line, in safe code: a type of its own alignment
//! could not be seen as plain numbers without unsafe code, and a crate that does so brings more than this file. What a tick
//! computes does not depend on where an array begins.

use crate::numeric::Real;
use alloc::vec::Vec;
use core::fmt;
use core::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;
/// Numbers that begin at a cache line; a slice in all else. Its length is that it was made with.
#[derive(Default)]
pub struct Aligned<R: Real = f64> {
    /// nothing stands behind the last, so that one compare finds them
    all: Vec<R>,
    /// where the first number stands in `all`
    first: usize,
}

impl<R: Real> Aligned<R> {
    /// Numbers of a cache line.
    const NUMBERS: usize = LINE / size_of::<R>();

    /// `len` times 0.
    pub fn zeros(len: usize) -> Aligned<R> {
        let mut all = alloc::vec![R::ZERO; len + Self::NUMBERS - 1];
        // where the address cannot be asked for, any is as good
        let first = all.as_ptr().align_offset(LINE).min(Self::NUMBERS - 1);
        all.truncate(first + len);
        Aligned { all, first }
    }
}

impl<R: Real> Deref for Aligned<R> {
    type Target = [R];
    #[inline(always)]
    fn deref(&self) -> &[R] {
        &self.all[self.first..]
    }
}

impl<R: Real> DerefMut for Aligned<R> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [R] {
        &mut self.all[self.first..]
    }
}

impl<R: Real> From<&[R]> for Aligned<R> {
    fn from(from: &[R]) -> Aligned<R> {
        let mut to = Aligned::zeros(from.len());
        to.copy_from_slice(from);
        to
    }
}

impl<R: Real> FromIterator<R> for Aligned<R> {
    fn from_iter<I: IntoIterator<Item = R>>(all: I) -> Aligned<R> {
        Aligned::from(&all.into_iter().collect::<Vec<R>>()[..])
    }
}

impl<R: Real> Clone for Aligned<R> {
    fn clone(&self) -> Aligned<R> {
        Aligned::from(&self[..])
    }

    /// Allocates nothing where the lengths agree.
    fn clone_from(&mut self, from: &Aligned<R>) {
        if self.len() == from.len() {
            self.copy_from_slice(from);
        } else {
            *self = from.clone();
        }
    }
}

impl<R: Real> PartialEq for Aligned<R> {
    fn eq(&self, other: &Aligned<R>) -> bool {
        self[..] == other[..]
    }
}

impl<R: Real> fmt::Debug for Aligned<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self[..].fmt(f)
    }
}

impl<'a, R: Real> IntoIterator for &'a Aligned<R> {
    type Item = &'a R;
    type IntoIter = core::slice::Iter<'a, R>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a, R: Real> IntoIterator for &'a mut Aligned<R> {
    type Item = &'a mut R;
    type IntoIter = core::slice::IterMut<'a, R>;
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
            let numbers: Vec<f64> = (0..n).map(f64::from).collect();
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
            assert_eq!(a[..], [0.0; 3]);
        }
    }
}
