//! Plan: a compiled scene as bytes, to be kept, sent to another process, and read without a compiler.
//!
//! A plan is a head, then a record of the scene in the format of `postcard`. The head has eight bytes that say what it is,
//! the version of the record, the arithmetic of the tick, the length of the record and its checksum. A record names laws, kinds
//! and units by their codes, which a [`Catalog`] finds again. Numbers keep their bits.
//!
//! [`Scene::from_bytes`] trusts nothing: each index that a tick, a start or a change of a live parameter uses is compared with the
//! length of what it indexes (`verify`), before memory is taken by a count. A scene that is read can therefore be played without a
//! panic. Values are not judged: a plan may hold coefficients that no compiler writes, and arguments with which a generator fails
//! when a live parameter changes.
//!
//! The format serves one version of the arithmetic, and its records follow the structures of this crate. A program that meets
//! another version compiles the model again.

mod known;
mod read;
mod record;
mod verify;
mod write;

use crate::catalog::Catalog;
use crate::scene::{ARITHMETIC, Scene};
use crate::state::checksum;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use known::Known;
use record::SceneRecord;
use verify::Wrong;

/// A compiled scene over `f64`, from which scenes over other numbers are bound, and which has a form in bytes.
pub type Plan = Scene<f64>;

/// The first bytes of a plan.
const MAGIC: &[u8; 8] = b"ca plan\n";
/// Version of the record. It changes whenever a structure that a record holds does.
pub const PLAN_VERSION: u32 = 2;
/// Bytes before the record.
const HEAD: usize = 32;

/// Why bytes are not a plan that can be played.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlanError {
    /// they begin as no plan does
    Magic,
    /// a plan of this version, which is not [`PLAN_VERSION`]
    Version(u32),
    /// a plan for this arithmetic, which is not [`ARITHMETIC`]
    Arithmetic(u32),
    /// the head names another length than there is
    Length {
        /// bytes of the whole plan by its head
        expected: u64,
        /// bytes there are
        found: u64,
    },
    /// the bytes were changed since they were written
    Checksum,
    /// the record ends early, goes on behind its end, or is of another form
    Record,
    /// this code of a law is not in the catalog
    Law(String),
    /// this code of a kind is not in the catalog
    Kind(String),
    /// no unit has this symbol
    Unit(String),
    /// the parts of the record do not fit each other: what does not
    Invalid(&'static str),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const AGAIN: &str = "compile the model again";
        match self {
            PlanError::Magic => f.write_str("this is not a compiled scene: give a file that `to_bytes` wrote"),
            PlanError::Version(v) => {
                write!(f, "the compiled scene has format {v}, and this program reads format {PLAN_VERSION}: {AGAIN}")
            }
            PlanError::Arithmetic(a) => {
                write!(f, "the compiled scene is for arithmetic {a}, and this program plays {ARITHMETIC}: {AGAIN}")
            }
            PlanError::Length { expected, found } => {
                write!(f, "the compiled scene should have {expected} bytes and has {found}: copy it whole, or {AGAIN}")
            }
            PlanError::Checksum => write!(f, "the compiled scene was changed since it was written: {AGAIN}"),
            PlanError::Record => write!(f, "the compiled scene cannot be read: {AGAIN}"),
            PlanError::Law(code) => {
                write!(f, "the law `{code}` is not in the catalog: add the kinds of the crate that has it")
            }
            PlanError::Kind(code) => {
                write!(f, "the kind `{code}` is not in the catalog: add the kinds of the crate that has it")
            }
            PlanError::Unit(symbol) => {
                write!(f, "no unit has the symbol `{symbol}`: add the kinds of the crate that uses it to the catalog")
            }
            PlanError::Invalid(what) => write!(f, "the compiled scene cannot be played, {what}: {AGAIN}"),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<Wrong> for PlanError {
    fn from(Wrong(what): Wrong) -> PlanError {
        PlanError::Invalid(what)
    }
}

impl Scene {
    /// The scene as bytes. Two scenes of one model that were compiled with the same options have the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let record = write::scene(self);
        // numbers alone are written, into memory that grows
        let mut bytes = postcard::to_extend(&record, alloc::vec![0; HEAD]).unwrap_or_default();
        if let Some((head, body)) = bytes.split_at_mut_checked(HEAD) {
            let sum = checksum(body);
            let parts: [&[u8]; 5] = [
                MAGIC,
                &PLAN_VERSION.to_le_bytes(),
                &ARITHMETIC.to_le_bytes(),
                &(body.len() as u64).to_le_bytes(),
                &sum.to_le_bytes(),
            ];
            head.iter_mut().zip(parts.into_iter().flatten()).for_each(|(to, from)| *to = *from);
        }
        bytes
    }

    /// The scene of bytes that [`Scene::to_bytes`] wrote. `catalog` lists the kinds of its links, and of its items with live
    /// parameters.
    ///
    /// # Errors
    /// [`PlanError`]. Takes time and memory in proportion to the bytes, whatever they are.
    pub fn from_bytes(bytes: &[u8], catalog: &Catalog) -> Result<Scene, PlanError> {
        let record: SceneRecord = match postcard::take_from_bytes(body(bytes)?) {
            Ok((record, [])) => record,
            _ => return Err(PlanError::Record),
        };
        read::scene(record, &Known::new(catalog))
    }
}

/// The record behind the head.
fn body(bytes: &[u8]) -> Result<&[u8], PlanError> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|w| u32::from_le_bytes(*w));
    let long = |at: usize| bytes.get(at..)?.first_chunk().map(|w| u64::from_le_bytes(*w));
    if bytes.first_chunk() != Some(MAGIC) {
        return Err(PlanError::Magic);
    }
    let found = bytes.len() as u64;
    let short = PlanError::Length { expected: HEAD as u64, found };
    let [version, arithmetic] = [8, 12].map(|at| word(at).ok_or(short.clone()));
    let (version, arithmetic) = (version?, arithmetic?);
    if version != PLAN_VERSION {
        return Err(PlanError::Version(version));
    }
    if arithmetic != ARITHMETIC {
        return Err(PlanError::Arithmetic(arithmetic));
    }
    let (Some(length), Some(sum), Some(body)) = (long(16), long(24), bytes.get(HEAD..)) else { return Err(short) };
    if length != body.len() as u64 {
        return Err(PlanError::Length { expected: length.saturating_add(HEAD as u64), found });
    }
    if sum == checksum(body) { Ok(body) } else { Err(PlanError::Checksum) }
}
