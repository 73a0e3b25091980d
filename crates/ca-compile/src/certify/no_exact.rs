//! Replacement of `exact` for builds without the feature `analysis`: the cheap bounds alone decide.

use crate::certify::accumulate::{Accumulated, Sums};
use crate::net::{LiaNode, Pruned};
use ca_core::internal::scene::certificate::FactorVerdict;
use ca_core::{Bound, Certificate};
use ca_model::Model;
use ca_model::diag::Diag;

/// Products that a factorisation may take for contacts alone: none is possible.
pub const WORK: usize = 1;

/// Never exists.
pub enum Exact {}

impl Exact {
    /// Returns `None`.
    pub fn new(_: &Pruned, _: &[Sums], _: &[Bound]) -> Option<Exact> {
        None
    }
    /// Never called.
    pub fn verdict(&self, _: &Pruned, _: &Accumulated) -> FactorVerdict {
        match *self {}
    }
    /// Never called.
    pub fn mobility(&self, _: &Pruned, _: &LiaNode, _: &Bound) -> Option<f64> {
        match *self {}
    }
    /// Never called.
    pub fn headroom(&self) -> Option<f64> {
        match *self {}
    }
    /// Never called.
    pub fn largest(&self, _: &Certificate, _: bool) -> Option<(f64, f64)> {
        match *self {}
    }
    /// Never called.
    pub fn blame(&self, _: &Model, _: &Pruned, _: &Accumulated, _: usize, _: &Certificate) -> Diag {
        match *self {}
    }
}
