//! An array of numbers that begins at a cache line.
//!
//! A vector of eight that crosses a cache line is read twice, and a long folded row (`op/links/folded.rs`) then takes
//! half as long again. The start of an array does not affect what a tick computes.
//!
//! The array is a `Vec` with spare numbers in front, in safe code. A type with its own alignment would need unsafe code
//! to be viewed as plain numbers, and a crate for it is larger than this file.

use crate::numeric::Real;
use alloc::vec::Vec;
use core::fmt;
use core::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;
/// Numbers that begin at a cache line. It dereferences to a slice, and its length is fixed when it is made.
#[derive(Default)]
pub struct Aligned<R: Real = f64> {
    /// ends with the last number, so that slicing takes one comparison
    all: Vec<R>,
    /// index of the first number in `all`
    first: usize,
}

impl<R: Real> Aligned<R> {
    const NUMBERS: usize = LINE / size_of::<R>();

    /// Makes an array of `len` zeros.
    pub fn zeros(len: usize) -> Aligned<R> {
        let mut all = alloc::vec![R::ZERO; len + Self::NUMBERS - 1];
        // `align_offset` may fail; then any offset will do
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

    /// Does not allocate if the lengths agree.
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
