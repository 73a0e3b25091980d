//! Probes out: quantities of a model over time, as NPY or CSV.
//!
//! A probe is written as it is computed, in constant memory, at full precision and without clipping. `nan` and `inf`
//! are written as they are, because a probe is how one finds where a model broke.
//!
//! NPY is `float64` of shape `(frames,)` for one quantity and `(frames, k)` for more. The number of frames, unknown
//! until the end, is written into a header of fixed length. A structured NPY with names is not used, because plotting
//! needs a plain array, and CSV has the names.
//!
//! CSV is `time,name…`, a gesture that can be played again, with the shortest digits that read back as the same number.
//! The file is put in place when it is finished (`atomic_file.rs`).

use crate::atomic_file::AtomicFile;
use crate::error::{FileError, FileErrorKind};
use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Length of an NPY header \[bytes\], a multiple of 64 as the format requires.
const HEADER: usize = 128;

enum Kind {
    Npy,
    Csv,
}

/// A probe file being written.
pub struct ProbeOut {
    // before `staged`, so that it is closed before the hidden file is removed
    out: BufWriter<File>,
    staged: AtomicFile,
    path: PathBuf,
    kind: Kind,
    columns: usize,
    rate: f64,
    frames: u64,
}

impl ProbeOut {
    /// Begins a `.npy` or `.csv` file of these quantities, with `rate` \[Hz\] frames a second from time 0.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: impl AsRef<Path>, names: &[&str], rate: f64) -> Result<ProbeOut, FileError> {
        let path = path.as_ref();
        let ext = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let kind = match ext.as_deref() {
            Some("npy") => Kind::Npy,
            Some("csv") => Kind::Csv,
            _ => {
                let e = FileError::new(
                    FileErrorKind::Unsupported,
                    "probes cannot be written to a file with this extension",
                );
                return Err(e.file(path.display()).fix("use `.npy` or `.csv`"));
            }
        };
        if names.is_empty() {
            return Err(FileError::usage("the list of probes is empty").file(path.display()).fix("name a module"));
        }
        crate::gesture::check_rate(rate).map_err(|e| e.file(path.display()))?;
        let staged = AtomicFile::create(path)?;
        let (file, path, columns) = (staged.handle()?, path.to_owned(), names.len());
        let mut p = ProbeOut { out: BufWriter::new(file), staged, path, kind, columns, rate, frames: 0 };
        let begun = match p.kind {
            Kind::Npy => p.out.write_all(&header(0, columns)),
            Kind::Csv => csv_line(&mut p.out, "time", names.iter().map(|n| quoted(n))),
        };
        begun.map_err(|e| p.failed(&e))?;
        Ok(p)
    }

    /// Appends whole frames, one value of each quantity per frame.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        if !frames.len().is_multiple_of(self.columns) {
            let what = format!("{} values are not whole frames of {}", frames.len(), self.columns);
            return Err(FileError::usage(what).file(self.path.display()));
        }
        for frame in frames.chunks_exact(self.columns) {
            let done = match self.kind {
                Kind::Npy => frame.iter().try_for_each(|x| self.out.write_all(&x.to_le_bytes())),
                Kind::Csv => csv_line(&mut self.out, self.frames as f64 / self.rate, frame),
            };
            done.map_err(|e| self.failed(&e))?;
            self.frames += 1;
        }
        Ok(())
    }

    /// Completes the file, puts it in its place and returns its number of frames.
    ///
    /// # Errors
    /// If the disk is full; the file is then removed.
    pub fn finish(mut self) -> Result<u64, FileError> {
        let mut done = self.out.flush();
        if matches!(self.kind, Kind::Npy) {
            done = done
                .and_then(|()| self.out.seek(SeekFrom::Start(0)))
                .and_then(|_| self.out.write_all(&header(self.frames, self.columns)))
                .and_then(|()| self.out.flush());
        }
        done.map_err(|e| self.failed(&e))?;
        self.staged.commit()?;
        Ok(self.frames)
    }

    fn failed(&self, e: &std::io::Error) -> FileError {
        FileError::io(&self.path, "it cannot be written", e)
    }
}

fn csv_line<T: std::fmt::Display>(
    out: &mut impl Write,
    first: impl std::fmt::Display,
    rest: impl IntoIterator<Item = T>,
) -> std::io::Result<()> {
    write!(out, "{first}")?;
    for cell in rest {
        write!(out, ",{cell}")?;
    }
    writeln!(out)
}

/// Returns a name as a CSV cell.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r', '#']) || name.trim() != name {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// Makes an NPY header of version 1.0, always of the same length.
fn header(frames: u64, columns: usize) -> Vec<u8> {
    let shape = if columns == 1 { format!("({frames},)") } else { format!("({frames}, {columns})") };
    let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let mut b = b"\x93NUMPY\x01\x00".to_vec();
    b.extend(((HEADER - 10) as u16).to_le_bytes());
    // at most 55 + 20 + 2 + 20 + 4 characters
    b.extend(format!("{dict:<width$}\n", width = HEADER - 11).as_bytes());
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_never_changes_its_length() {
        for (frames, columns) in [(0, 1), (1, 2), (u64::MAX, 1), (u64::MAX, usize::MAX)] {
            assert_eq!(header(frames, columns).len(), HEADER);
        }
    }

    #[test]
    fn csv_is_a_gesture_again() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.csv");
        let mut p = ProbeOut::create(&path, &["a.x", "odd, \"name\""], 10.0).unwrap();
        let values = [0.1, -1e-300, 1.0 / 3.0, 2.0, f64::MAX, f64::MIN_POSITIVE];
        p.write(&values[..4]).unwrap();
        p.write(&values[4..]).unwrap();
        assert!(!path.exists(), "not before it is finished");
        assert_eq!(p.finish().unwrap(), 3);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("time,a.x,\"odd, \"\"name\"\"\"\n0,0.1,"), "{text}");
        let g = crate::gesture::Gesture::open(&path, &[], None).unwrap();
        for (c, t) in g.tracks().iter().enumerate() {
            for n in 0..3 {
                assert_eq!(t.at(n as f64 / 10.0), values[2 * n + c]);
            }
        }
        assert_eq!(g.tracks()[1].name(), "odd, \"name\"");
    }

    #[test]
    fn npy_keeps_every_bit() {
        let dir = tempfile::tempdir().unwrap();
        for columns in [1, 3] {
            let path = dir.path().join("p.npy");
            let names = vec!["x"; columns];
            let mut p = ProbeOut::create(&path, &names, 3000.0).unwrap();
            let values: Vec<f64> = (0..3000).map(|i| f64::from(i).sqrt()).collect();
            values.chunks(300).for_each(|c| p.write(c).unwrap());
            assert_eq!(p.finish().unwrap(), 3000 / columns as u64);
            let g = crate::gesture::Gesture::open(&path, &[], Some(3000.0)).unwrap();
            assert_eq!(g.tracks().len(), columns);
            for (i, want) in values.iter().enumerate() {
                assert_eq!(g.tracks()[i % columns].at((i / columns) as f64 / 3000.0), *want);
            }
        }
    }

    #[test]
    fn what_has_no_value_is_shown() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.csv");
        let mut p = ProbeOut::create(&path, &["x"], 1.0).unwrap();
        p.write(&[f64::NAN, f64::INFINITY]).unwrap();
        p.finish().unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "time,x\n0,NaN\n1,inf\n");
    }

    #[test]
    fn refuses_what_makes_no_sense() {
        let dir = tempfile::tempdir().unwrap();
        let kind =
            |name: &str, names: &[&str], rate| ProbeOut::create(dir.path().join(name), names, rate).err().unwrap().kind;
        assert_eq!(kind("p.txt", &["x"], 1.0), FileErrorKind::Unsupported);
        assert_eq!(kind("p.npy", &[], 1.0), FileErrorKind::Usage);
        assert_eq!(kind("p.npy", &["x"], f64::NAN), FileErrorKind::Usage);
        let mut p = ProbeOut::create(dir.path().join("p.npy"), &["x", "y"], 1.0).unwrap();
        assert_eq!(p.write(&[1.0]).unwrap_err().kind, FileErrorKind::Usage);
        drop(p);
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0);
    }
}
