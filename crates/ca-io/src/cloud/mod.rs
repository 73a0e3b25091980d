//! Clouds: reads bodies from drawing programs as points and edges.
//!
//! Points keep the order of the file. Points in exactly the same place become one, the first: exporters write a corner
//! once for each seam, and a model never needs two masses in one place. Each edge of a face or line is kept once. A
//! face with fewer than three different corners, or with one corner twice, is skipped and counted. Values that are not
//! finite, and more points than a model can hold, are refused.

mod csv;
mod obj;
mod ply;

use crate::error::{FileError, FileErrorKind};
use crate::read_limited;
use ca_core::internal::kind::cloud::{Cloud, Clouds, Unread};
use ca_core::{Catalog, Type};
use ca_model::LARGEST;
use ca_model::Model;
use ca_model::Value;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

/// Content of a file, unprocessed.
#[derive(Default)]
struct Drawing {
    points: Vec<[f64; 3]>,
    /// Corners of closed faces.
    faces: Vec<Vec<u32>>,
    /// Corners of open lines.
    lines: Vec<Vec<u32>>,
}

/// Reads a `.ply`, `.obj` or `.csv` file.
///
/// # Errors
/// If the file cannot be read, has another extension, or is not of the format of its extension.
pub fn open(path: impl AsRef<Path>) -> Result<Cloud, FileError> {
    let path = path.as_ref();
    let ext = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let read = match ext.as_deref() {
        Some("ply") => ply::read,
        Some("obj") => obj::read,
        Some("csv") => csv::read,
        _ => {
            let e =
                FileError::unsupported("points cannot be read from a file with this extension").file(path.display());
            return Err(e.fix("use `.ply`, `.obj` or `.csv`"));
        }
    };
    // a `.ply` may be binary
    let binary = ext.as_deref() == Some("ply");
    // anything but a plain file is refused, since opening a pipe could block
    if path.metadata().is_ok_and(|m| !m.is_file()) {
        let e = FileError::content("it is not a regular file").file(path.display());
        return Err(e.fix("name a file that holds the points"));
    }
    let bytes = (if binary { read_limited::bytes } else { read_limited::text })(path, read_limited::CLOUD)?;
    read(&bytes).and_then(|d| cloud(&d)).map_err(|e| e.file(path.display()))
}

/// Returns the files that a model names.
pub fn named<'m>(model: &'m Model, catalog: &Catalog) -> BTreeSet<&'m String> {
    let files = model.items.iter().flat_map(|item| {
        let params = catalog.get(&item.kind).map_or(&[][..], |k| k.params);
        let is_file = |key: &str| params.iter().any(|p| p.name == key && p.ty == Type::File);
        item.args.iter().filter(move |e| is_file(&e.key))
    });
    files.filter_map(|e| if let Value::Text(t) = &e.value { Some(t) } else { None }).collect()
}

/// Reads all files that a model names, relative to its folder.
pub fn of_model(model: &Model, catalog: &Catalog, folder: &Path) -> Clouds {
    let read = |name: &String| {
        open(folder.join(name)).map(Arc::new).map_err(|e| {
            let help = match (e.fix.as_str(), e.kind) {
                ("", FileErrorKind::Io) => "paths are relative to the folder of the model".into(),
                ("", _) => "export it again".into(),
                (fix, _) => fix.to_owned(),
            };
            Unread { what: FileError { fix: String::new(), ..e }.to_string(), help }
        })
    };
    named(model, catalog).into_iter().map(|name| (name.clone(), read(name))).collect()
}

/// Returns a cloud as the text of an OBJ file, which reads back as the same points and edges.
pub fn write_obj(cloud: &Cloud) -> String {
    let points = cloud.points.iter().map(|[x, y, z]| format!("v {x:?} {y:?} {z:?}\n"));
    points.chain(cloud.edges.iter().map(|[a, b]| format!("l {} {}\n", a + 1, b + 1))).collect()
}

/// Reads a cloud from the text of an OBJ file.
///
/// # Errors
/// If the text is not OBJ; the error has the line.
pub fn read_obj(text: &[u8]) -> Result<Cloud, FileError> {
    obj::read(text).and_then(|d| cloud(&d))
}

const POINT: &str = "write decimals with a point, as in `0.1`";

/// Splits a text into lines at `\n`, `\r\n`, or `\r` alone.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').flat_map(|l| l.strip_suffix('\r').unwrap_or(l).split('\r'))
}

fn not_too_many(points: usize) -> Result<(), FileError> {
    if points <= LARGEST {
        return Ok(());
    }
    Err(FileError::content(format!("it has {points} points, but a model can have at most {LARGEST}"))
        .fix("reduce its number of points"))
}

/// Merges equal points and collects the edges.
fn cloud(d: &Drawing) -> Result<Cloud, FileError> {
    not_too_many(d.points.len())?;
    if d.points.is_empty() {
        return Err(FileError::content("it contains no points"));
    }
    if let Some(i) = d.points.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        return Err(FileError::content(format!("the coordinates of point {i} are not finite: {:?}", d.points[i]))
            .fix("write finite numbers"));
    }
    let mut cloud = Cloud::default();
    let mut seen: HashMap<[u64; 3], u32> = HashMap::with_capacity(d.points.len());
    let mut number = Vec::with_capacity(d.points.len());
    for p in &d.points {
        // 0 and −0 are the same place
        let place = p.map(|v| (v + 0.0).to_bits());
        number.push(*seen.entry(place).or_insert_with(|| {
            cloud.points.push(*p);
            cloud.points.len() as u32 - 1
        }));
    }
    cloud.merged = d.points.len() - cloud.points.len();
    let mut edges = BTreeSet::new();
    for (corners, closed) in d.faces.iter().map(|c| (c, true)).chain(d.lines.iter().map(|c| (c, false))) {
        let mut own = Vec::with_capacity(corners.len());
        for c in corners {
            let Some(c) = number.get(*c as usize) else {
                let what = format!("a {} uses point {c}, which does not exist", if closed { "face" } else { "line" });
                let fix = format!("the points are counted from 0, and there are {}", d.points.len());
                return Err(FileError::content(what).fix(fix));
            };
            own.push(*c);
        }
        let different: BTreeSet<u32> = own.iter().copied().collect();
        if closed && (different.len() < 3 || different.len() < own.len()) {
            cloud.flat += 1;
            continue;
        }
        let back = if closed { own.first().copied() } else { None };
        for (a, b) in own.iter().copied().zip(own.iter().skip(1).copied().chain(back)) {
            if a != b {
                edges.insert([a.min(b), a.max(b)]);
            }
        }
        if edges.len() > LARGEST {
            let what = format!("it has more than {LARGEST} edges, the limit of a model");
            return Err(FileError::content(what).fix("reduce its number of points"));
        }
    }
    cloud.edges = edges.into_iter().collect();
    Ok(cloud)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_end_is_not_read() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.obj", "a.ply", "a.csv"] {
            let path = dir.path().join(name);
            #[cfg(unix)]
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
            #[cfg(not(unix))]
            std::fs::create_dir(&path).unwrap();
            let e = open(&path).unwrap_err().to_string();
            assert!(e.contains("it is not a regular file"), "{e}");
        }
    }

    #[test]
    fn a_negative_corner_is_told_as_one() {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
        assert!(ply::read(format!("{head}3 0 1 2\n").as_bytes()).is_ok());
        for wrong in [-1, -2] {
            let e =
                ply::read(format!("{head}3 0 1 {wrong}\n").as_bytes()).and_then(|d| cloud(&d)).unwrap_err().to_string();
            assert!(e.contains("negative") && e.contains("there are 3") && !e.contains("42949"), "{e}");
        }
    }
}
