//! Plans: a compiled scene as bytes, to be stored, sent to another process, and read without a compiler.
//!
//! A plan is a head followed by a record of the scene in `postcard` format. The head consists of eight identifying
//! bytes, the version of the record, the arithmetic of the tick, the length of the record and its checksum. A record
//! names laws, kinds and units by their codes, which a [`Catalog`] resolves. Numbers keep their bits.
//!
//! [`Scene::from_bytes`] does not trust its input. It compares each index that a tick, a start or a live change uses
//! with the length of the indexed array (`verify`), before it allocates by any count. A scene that was read can thus be
//! played without a panic. Values are not checked: a plan may hold coefficients that the compiler never writes, and
//! arguments with which a generator fails when a live parameter changes.
//!
//! The format supports one version of the arithmetic, and its records follow the structures of this crate. A program
//! that finds another version compiles the model again.

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

/// A compiled scene over `f64`. It can be bound to other number types and converted to bytes.
pub type Plan = Scene<f64>;

const MAGIC: &[u8; 8] = b"ca plan\n";
/// Version of the record. It changes with any structure that a record holds.
pub const PLAN_VERSION: u32 = 4;
/// Bytes before the record.
const HEAD: usize = 32;

/// Why bytes are not a playable plan.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlanError {
    /// they do not begin like a plan
    Magic,
    /// the plan has this version instead of [`PLAN_VERSION`]
    Version(u32),
    /// the plan is for this arithmetic instead of [`ARITHMETIC`]
    Arithmetic(u32),
    /// the length in the head differs from the actual length
    Length {
        /// length of the whole plan according to its head
        expected: u64,
        /// actual length
        found: u64,
    },
    /// the bytes were changed after writing
    Checksum,
    /// the record ends early, continues past its end, or has another form
    Record,
    /// the catalog has no law with this code
    Law(String),
    /// the catalog has no kind with this code
    Kind(String),
    /// units do not include this symbol
    Unit(String),
    /// the parts of the record do not fit together, with the reason
    Invalid(&'static str),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const AGAIN: &str = "compile the model again";
        match self {
            PlanError::Magic => f.write_str("the bytes are not a compiled scene: give those that `to_bytes` returned"),
            PlanError::Version(v) => {
                write!(f, "the compiled scene has format {v}, but this program reads format {PLAN_VERSION}: {AGAIN}")
            }
            PlanError::Arithmetic(a) => {
                write!(f, "the compiled scene is for arithmetic {a}, but this program plays {ARITHMETIC}: {AGAIN}")
            }
            PlanError::Length { expected, found } => {
                write!(
                    f,
                    "the compiled scene should have {expected} bytes but has {found}: copy it completely, or {AGAIN}"
                )
            }
            PlanError::Checksum => write!(f, "the compiled scene was changed since it was written: {AGAIN}"),
            PlanError::Record => write!(f, "the compiled scene cannot be read: {AGAIN}"),
            PlanError::Law(code) => {
                write!(f, "the law `{code}` is not in the catalog: add the kinds of the crate that defines it")
            }
            PlanError::Kind(code) => {
                write!(f, "the kind `{code}` is not in the catalog: add the kinds of the crate that defines it")
            }
            PlanError::Unit(symbol) => {
                write!(f, "unknown unit `{symbol}`: add the kinds of the crate that uses it to the catalog")
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
    /// Returns the scene as bytes. Compiling a model twice with the same options gives the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let record = write::scene(self);
        // writing numbers to growing memory cannot fail
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

    /// Reads a scene from the bytes of [`Scene::to_bytes`]. `catalog` lists the kinds of its links and live items.
    ///
    /// # Errors
    /// [`PlanError`]. Time and memory are proportional to the number of bytes, for any input.
    pub fn from_bytes(bytes: &[u8], catalog: &Catalog) -> Result<Scene, PlanError> {
        let record: SceneRecord = match postcard::take_from_bytes(body(bytes)?) {
            Ok((record, [])) => record,
            _ => return Err(PlanError::Record),
        };
        read::scene(record, &Known::new(catalog))
    }
}

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
