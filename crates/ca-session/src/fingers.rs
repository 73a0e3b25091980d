//! The fingers of all pages: which one holds which mass.

use crate::refused::Refused;
use ca_core::internal::state::FINGERS;

/// A page, and the number of a finger on it.
type Own = (u64, u8);

/// Fingers of the engine, each with the finger of a page that it is, and the MAT that it holds.
#[derive(Default)]
pub struct Fingers([Option<(Own, usize)>; FINGERS]);

impl Fingers {
    /// Returns the number of the finger that may hold a MAT: the one that `own` has already, or a free one.
    ///
    /// # Errors
    /// If another finger holds the MAT, or if no finger is free.
    pub fn free(&self, own: Own, mass: usize) -> Result<u8, Refused> {
        if self.0.iter().flatten().any(|f| f.1 == mass && f.0 != own) {
            return Err("another page or finger holds this mass; wait until it is released".into());
        }
        let free = self.0.iter().position(Option::is_none).map(|i| i as u8);
        let none = || format!("{FINGERS} masses are held; release one first").into();
        self.of(own).or(free).ok_or_else(none)
    }

    /// Returns the number of a page's finger, if it holds a mass.
    pub fn of(&self, own: Own) -> Option<u8> {
        self.0.iter().position(|f| f.is_some_and(|f| f.0 == own)).map(|i| i as u8)
    }

    /// Enters a held MAT.
    pub fn hold(&mut self, finger: u8, own: Own, mass: usize) {
        self.0[usize::from(finger)] = Some((own, mass));
    }

    /// Frees a finger of a page, or all of them, and returns the numbers of those that held a mass.
    pub fn release(&mut self, page: u64, finger: Option<u8>) -> Vec<u8> {
        let own = |own: &Own| own.0 == page && finger.is_none_or(|f| f == own.1);
        let mut freed = Vec::new();
        for (i, held) in self.0.iter_mut().enumerate().filter(|(_, f)| f.is_some_and(|f| own(&f.0))) {
            *held = None;
            freed.push(i as u8);
        }
        freed
    }
}
