//! Stores a sweep in a folder: sounds and rows, in chunks that appear whole or not at all.
//!
//! ```text
//! FOLDER/
//!   sweep.toml            what every worker of this folder computes
//!   runs-000000/          a chunk: 000000.flac …, rows.parquet
//!   manifest.parquet      all rows, once all chunks are there
//!   times.parquet         the time that each run took
//! ```
//!
//! A chunk is a folder that gets its final name when it is complete. So workers share nothing but the file system,
//! partial work does not count, and a complete chunk is not computed again. Times are stored separately, so that the
//! manifest is the same to the byte for every worker.

use super::{Audio, RunTable, Sweep, TIMES};
use crate::axis::Space;
use ca_io::atomic_file;
use ca_lab::Failure;
use ca_lab::load::reason;
use ca_model::Value;
use std::collections::hash_map::RandomState;
use std::fmt::Write as _;
use std::hash::{BuildHasher as _, Hasher as _};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

const ROWS: &str = "rows.parquet";
const MANIFEST: &str = "manifest.parquet";
const TIME: &str = "times.parquet";
const ASKED: &str = "sweep.toml";

/// Maximum number of chunks.
const MOST: u64 = 1_000_000;

/// Folder of a sweep.
pub struct Folder {
    path: PathBuf,
    audio: Audio,
    chunk: u64,
    runs: u64,
}

fn failed(path: &Path, what: &str, e: &std::io::Error) -> Failure {
    Failure::Failed(format!("`{}` {what}: {}", path.display(), reason(e)))
}

/// Returns a unique name beside `path`.
fn aside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // random, since process ids are reused and may be equal on other machines
    let random = RandomState::new().build_hasher().finish();
    path.with_file_name(format!(".{name}.{random:016x}.part"))
}

/// Describes a sweep as text; equal sweeps, and only these, have equal text.
pub fn text(sweep: &Sweep, audio: &str, chunk: u64) -> String {
    let ask = sweep.spec();
    let mut text = String::from("# What every worker of this folder computes.\n");
    let mut line = |key: &str, value: String| {
        let _ = writeln!(text, "{key} = {value}");
    };
    line("version", format!("{:?}", env!("CARGO_PKG_VERSION")));
    line("scene", format!("{:?}", sweep.hash()));
    line("runs", sweep.runs().to_string());
    line("drawn", ask.runs.is_some().to_string());
    line("seed", ask.seed.to_string());
    line("rate", format!("{:?}", sweep.rate()));
    if let Some(seconds) = ask.seconds {
        line("seconds", format!("{seconds:?}"));
    }
    if let Some(gesture) = &sweep.played {
        line("gesture", format!("{gesture:?}"));
    }
    line("energy", ask.energy.to_string());
    line("measure", ask.measure.to_string());
    line("audio", format!("{audio:?}"));
    line("chunk", chunk.to_string());
    text += "\n[vary]\n";
    for axis in &ask.axes {
        let space = match &axis.space {
            Space::Range { from, to, log } => format!("{{ from = {from:?}, to = {to:?}, log = {log} }}"),
            Space::List(values) => {
                format!("[{}]", values.iter().map(toml).collect::<Vec<_>>().join(", "))
            }
        };
        let _ = writeln!(text, "{:?} = {space}", axis.name);
    }
    text
}

fn toml(value: &Value) -> String {
    match value {
        Value::Num(v) => format!("{v:?}"),
        Value::Bool(v) => v.to_string(),
        other => format!("{:?}", other.shown()),
    }
}

/// Default number of runs per chunk: enough chunks for many workers, and few enough files for a folder.
pub fn chunk(runs: u64) -> u64 {
    runs.div_ceil(64).clamp(1, 100)
}

impl Folder {
    /// Makes the folder, or continues an existing one. `chunk` is the number of runs per chunk.
    ///
    /// # Errors
    /// [`Failure::Usage`] where the folder holds something else, or the format cannot hold sounds of this shape;
    /// [`Failure::Failed`] where it cannot be written.
    pub fn open(path: &Path, sweep: &Sweep, audio: Audio, chunk: u64) -> Result<Folder, Failure> {
        if !(1..=1_000_000).contains(&chunk) {
            return Err(Failure::Usage(format!("`chunk` is {chunk}; it must be 1 to 1000000 runs")));
        }
        if sweep.runs().div_ceil(chunk) > MOST {
            let what = format!("{} runs in chunks of {chunk} need more than {MOST} folders", sweep.runs());
            return Err(Failure::Usage(format!("{what}; make `chunk` larger")));
        }
        if let Some(why) = audio.refuses(sweep.channels(), sweep.rate()) {
            return Err(Failure::Usage(why));
        }
        let folder = Folder { path: path.to_owned(), audio, chunk, runs: sweep.runs() };
        let (asked, text) = (path.join(ASKED), folder.text(sweep));
        match std::fs::read_to_string(&asked) {
            Ok(there) if there == text => return Ok(folder),
            Ok(_) => {
                let what = format!("`{}` contains another sweep, see `{}`", path.display(), asked.display());
                return Err(Failure::Usage(format!("{what}; choose another folder, or remove this one")));
            }
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(failed(&asked, "cannot be read", &e)),
            Err(_) => {}
        }
        // another worker may be creating the folder too
        let ours = |name: &str| name.contains(ASKED) || name.starts_with("runs-") || name.starts_with(".runs-");
        let mut files = std::fs::read_dir(path).into_iter().flatten().flatten();
        if files.any(|f| !ours(&f.file_name().to_string_lossy())) {
            let what = format!("`{}` is not empty and does not contain a sweep", path.display());
            return Err(Failure::Usage(format!("{what}; choose another folder")));
        }
        atomic_file::new_dir(path, true).map_err(|e| failed(path, "cannot be created", &e))?;
        // workers that begin at the same time write the same text
        atomic_file::write(&asked, text.as_bytes())?;
        Ok(folder)
    }

    fn text(&self, sweep: &Sweep) -> String {
        text(sweep, self.audio.name(), self.chunk)
    }

    /// Number of chunks.
    pub fn chunks(&self) -> u64 {
        self.runs.div_ceil(self.chunk)
    }

    /// Index of the first run of a chunk, and of the one after its last.
    pub fn span(&self, chunk: u64) -> (u64, u64) {
        (chunk * self.chunk, ((chunk + 1) * self.chunk).min(self.runs))
    }

    fn digits(&self, index: u64) -> String {
        let width = (self.runs - 1).to_string().len().max(6);
        format!("{index:0width$}")
    }

    fn home(&self, chunk: u64) -> PathBuf {
        self.path.join(format!("runs-{}", self.digits(chunk * self.chunk)))
    }

    /// Returns whether a chunk exists with complete rows; a power cut may truncate a file.
    pub fn has(&self, chunk: u64) -> bool {
        let whole = |mut file: std::fs::File| -> std::io::Result<bool> {
            let mut end = [0; 4];
            let size = file.seek(SeekFrom::End(-4))?;
            file.read_exact(&mut end)?;
            Ok(&end == b"PAR1" && size > 8)
        };
        std::fs::File::open(self.home(chunk).join(ROWS)).and_then(whole).unwrap_or(false)
    }

    /// Plays the runs of a chunk and stores it. `each` is called regularly, with the status of a run when it is done,
    /// and returns whether to go on.
    ///
    /// # Errors
    /// [`Failure::Stopped`] where `each` returns false; [`Failure::Failed`] where the folder cannot be written.
    pub fn fill(&self, sweep: &Sweep, chunk: u64, each: &mut dyn FnMut(Option<&str>) -> bool) -> Result<(), Failure> {
        // another process may play the same sweep
        if self.has(chunk) {
            return Ok(());
        }
        let home = self.home(chunk);
        let part = aside(&home);
        atomic_file::new_dir(&part, false).map_err(|e| failed(&part, "cannot be created", &e))?;
        let done = self.play(sweep, chunk, &part, each).and_then(|()| {
            // a chunk without rows is incomplete
            if home.exists() && !self.has(chunk) {
                let _ = std::fs::remove_dir_all(&home);
            }
            std::fs::rename(&part, &home).map_err(|e| failed(&home, "cannot be moved into place", &e))
        });
        if done.is_err() {
            let _ = std::fs::remove_dir_all(&part);
        }
        match done {
            // another worker stored the same chunk first
            Err(Failure::Failed(_)) if self.has(chunk) => Ok(()),
            done => done,
        }
    }

    fn play(
        &self,
        sweep: &Sweep,
        chunk: u64,
        part: &Path,
        each: &mut dyn FnMut(Option<&str>) -> bool,
    ) -> Result<(), Failure> {
        let mut rows = Vec::new();
        let (first, end) = self.span(chunk);
        for index in first..end {
            let (row, sound) = sweep.run(index, &mut || each(None))?;
            if self.audio != Audio::None && row.frames > 0 {
                let file = part.join(format!("{}.{}", self.digits(index), self.audio.name()));
                let bytes = self.audio.encode(&sound, sweep.channels(), sweep.rate())?;
                let made = atomic_file::new_file(&file, 0o644).and_then(|mut f| f.write_all(&bytes));
                made.map_err(|e| failed(&file, "cannot be written", &e))?;
            }
            if !each(Some(row.status)) {
                return Err(Failure::Stopped);
            }
            rows.push(row);
        }
        let mut table = sweep.table(&rows);
        if self.audio != Audio::None {
            let home = format!("runs-{}", self.digits(first));
            let file = |r: &super::RunRow| {
                (r.frames > 0).then(|| format!("{home}/{}.{}", self.digits(r.index), self.audio.name()))
            };
            table.columns.push(("file".into(), super::Column::Text(rows.iter().map(file).collect())));
        }
        table.write(&part.join(ROWS), &[])
    }

    /// Writes the tables of all runs and returns their rows; `None` where some are missing.
    ///
    /// # Errors
    /// [`Failure::Failed`] where a chunk cannot be read or the folder cannot be written.
    pub fn gather(&self, sweep: &Sweep) -> Result<Option<RunTable>, Failure> {
        let mut all = RunTable::default();
        for chunk in 0..self.chunks() {
            if !self.has(chunk) {
                return Ok(None);
            }
            all.append(RunTable::read(&self.home(chunk).join(ROWS))?)?;
        }
        // a complete folder may be read-only
        if [MANIFEST, TIME].iter().all(|name| self.path.join(name).exists()) {
            return Ok(Some(all));
        }
        let index = all.column("index").cloned();
        let (mut times, manifest) = all.clone().split(&TIMES);
        times.columns.splice(0..0, index.map(|c| ("index".to_owned(), c)));
        let about = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("scene", sweep.hash()),
            ("seed", sweep.spec().seed.to_string()),
            ("rate", sweep.rate().to_string()),
        ];
        for (name, table) in [(MANIFEST, manifest), (TIME, times)] {
            table.write(&self.path.join(name), &about)?;
        }
        // left over from killed workers
        for file in std::fs::read_dir(&self.path).into_iter().flatten().flatten() {
            let name = file.file_name();
            let name = name.to_string_lossy();
            if name.starts_with(".runs-") && name.ends_with(".part") {
                let _ = std::fs::remove_dir_all(file.path());
            }
        }
        Ok(Some(all))
    }
}
