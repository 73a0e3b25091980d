//! A build without `analysis`: only the cheap bounds speak.

use crate::certify::accumulate::Sums;
use crate::net::{LiaNode, Pruned};
use ca_core::internal::scene::certificate::FactorVerdict;
use ca_core::{Bound, Certificate};
use ca_model::Model;
use ca_model::diag::Diag;

/// As many products as a factorisation may take for contacts alone.
pub const WORK: usize = 1;

/// There is none.
pub enum Exact {}

impl Exact {
    /// None.
    pub fn new(_: &Pruned, _: &[Sums], _: &[Bound]) -> Option<Exact> {
        None
    }
    /// Never asked.
    pub fn verdict(&self, _: &Pruned, _: &[Bound]) -> FactorVerdict {
        match *self {}
    }
    /// Never asked.
    pub fn mobility(&self, _: &Pruned, _: &LiaNode, _: &Bound) -> Option<f64> {
        match *self {}
    }
    /// Never asked.
    pub fn room(&self) -> Option<f64> {
        match *self {}
    }
    /// Never asked.
    pub fn largest(&self, _: &Certificate, _: bool) -> Option<(f64, f64)> {
        match *self {}
    }
    /// Never asked.
    pub fn blame(&self, _: &Model, _: &Pruned, _: &[Bound], _: usize, _: &Certificate) -> Diag {
        match *self {}
    }
}
