//! Canonical bytes of a model, independent of comments and blanks in its file.
//!
//! They hold the text of the model as written by this program, so that the usual reader reads them, and two things that
//! the text lacks: the order of modules, in which forces are summed, and the contents of the files that the model
//! names. Models with equal bytes give the same sound to the bit, on any machine.

use crate::load::Loaded;
use crate::{Failure, Found};
use ca_core::internal::kind::cloud::{Cloud, Clouds, Unread};
use ca_model::Model;
use ca_model::diag::Diags;
use ca_model::{read, write};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Prefix of the bytes of a model.
const MAGIC: &[u8] = b"ca model 1\n";

/// Returns the bytes of a model, without its file name and comments.
///
/// # Errors
/// [`Failure::Found`] where the text has errors, since its bytes would lack the unread part.
pub fn bytes(loaded: &Loaded) -> Result<Vec<u8>, Failure> {
    let model = Model { header: String::new(), ..loaded.model.clone() };
    let text = write::write(&model);
    // the reader returns modules in the order of the text
    let (again, found) = read::read(&text, "", &crate::catalog());
    let place: BTreeMap<&str, u64> = again.items.iter().zip(0..).map(|(i, k)| (i.name.as_str(), k)).collect();
    let order: Vec<u64> = model.items.iter().filter_map(|i| place.get(i.name.as_str()).copied()).collect();
    let broken = [&loaded.diags, &found].into_iter().find(|d| d.has_errors());
    if let Some(diags) = broken {
        let model = if std::ptr::eq(diags, &raw const found) { again } else { loaded.model.clone() };
        return Err(Failure::Found(Box::new(Found { model, diags: diags.clone() })));
    }
    let mut to = MAGIC.to_vec();
    put(&mut to, text.as_bytes());
    let order: Vec<u8> = order.into_iter().flat_map(u64::to_le_bytes).collect();
    put(&mut to, &order);
    for (name, cloud) in &loaded.clouds {
        put(&mut to, name.as_bytes());
        match cloud {
            Err(unread) => {
                put(&mut to, unread.what.as_bytes());
                put(&mut to, unread.help.as_bytes());
            }
            Ok(c) => {
                put(&mut to, &[]);
                let points: Vec<u8> = c.points.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
                let edges: Vec<u8> = c.edges.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
                put(&mut to, &points);
                put(&mut to, &edges);
                put(&mut to, &[c.merged, c.flat].map(|n| (n as u64).to_le_bytes()).concat());
            }
        }
    }
    Ok(to)
}

fn put(to: &mut Vec<u8>, part: &[u8]) {
    to.extend((part.len() as u64).to_le_bytes());
    to.extend(part);
}

/// Returns the hash of a model and its sound rate \[Hz\], which identifies a scene on all machines.
///
/// # Errors
/// As [`bytes`].
pub fn named(loaded: &Loaded, rate: f64) -> Result<blake3::Hash, Failure> {
    let mut all = bytes(loaded)?;
    all.extend(rate.to_le_bytes());
    Ok(blake3::hash(&all))
}

/// Reads a model from bytes and calls it `name`. Its findings are not in a file.
///
/// # Errors
/// [`Failure::Failed`] where the bytes are not a model.
pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Loaded, Failure> {
    parse(bytes, name).ok_or_else(|| Failure::Failed("the bytes are not a model saved by this version of ca".into()))
}

fn parse(bytes: &[u8], name: &str) -> Option<Loaded> {
    let mut rest = bytes.strip_prefix(MAGIC)?;
    let mut take = || -> Option<&[u8]> {
        let (n, after) = rest.split_first_chunk::<8>()?;
        let (part, after) = after.split_at_checked(usize::try_from(u64::from_le_bytes(*n)).ok()?)?;
        rest = after;
        Some(part)
    };
    let text = std::str::from_utf8(take()?).ok()?;
    let order: Vec<usize> = words(take()?)?.map(|n| n as usize).collect();
    let mut clouds = Clouds::new();
    while let Some(name) = take() {
        let name = std::str::from_utf8(name).ok()?.to_owned();
        let what = std::str::from_utf8(take()?).ok()?;
        let cloud = if what.is_empty() {
            let points: Vec<f64> = words(take()?)?.map(f64::from_bits).collect();
            let edges = take()?.chunks_exact(4).filter_map(|c| Some(u32::from_le_bytes(*c.first_chunk()?)));
            let edges: Vec<u32> = edges.collect();
            let counts: Vec<u64> = words(take()?)?.collect();
            let [merged, flat] = counts[..] else { return None };
            Ok(Arc::new(Cloud {
                points: points.as_chunks::<3>().0.to_vec(),
                edges: edges.as_chunks::<2>().0.to_vec(),
                merged: merged as usize,
                flat: flat as usize,
            }))
        } else {
            Err(Unread { what: what.into(), help: std::str::from_utf8(take()?).ok()?.into() })
        };
        clouds.insert(name, cloud);
    }
    let (mut model, _) = read::read(text, "", &crate::catalog());
    let items: Option<Vec<_>> = order.iter().map(|k| model.items.get(*k).cloned()).collect();
    model.items = items.filter(|i| i.len() == model.items.len())?;
    Some(Loaded { name: name.into(), model, diags: Diags::new(), clouds, format: None })
}

fn words(bytes: &[u8]) -> Option<impl Iterator<Item = u64>> {
    let (chunks, rest) = bytes.as_chunks::<8>();
    rest.is_empty().then(|| chunks.iter().map(|c| u64::from_le_bytes(*c)))
}
