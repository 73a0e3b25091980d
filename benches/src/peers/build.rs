//! Compiles the peers, once each: the name of a program contains a hash of its sources, and an existing one is reused.
//!
//! The time limit uses `timeout`, which also ends the processes started by a compiler. A run that exceeded it is
//! recorded, and repeated only with a longer limit.

use super::net::Net;
use super::write;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiler flags of all peers.
pub const FLAGS: [&str; 3] = ["-O3", "-march=native", "-ffast-math"];

/// Reason why a program is missing.
#[derive(Clone, Debug, PartialEq)]
pub enum Without {
    /// Its compiler is not installed.
    Missing(String),
    /// Compilation exceeded this limit \[s\].
    Late(u32),
    /// Compilation failed with this output.
    Failed(String),
}

/// Compiles peers into a folder.
pub struct Builder {
    folder: PathBuf,
    /// Limit of each compiler run \[s\].
    limit: u32,
}

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peers")
}

/// Returns the first line of the `--version` of a program; `None` if it is not installed.
pub fn version(program: &str) -> Option<String> {
    let out = Command::new(program).arg("--version").output().ok().filter(|o| o.status.success())?;
    String::from_utf8_lossy(&out.stdout).lines().next().map(|l| l.trim().to_owned())
}

/// Returns a Python with numba, and the versions of both: the one installed by `crates/ca-py/benches/run`, or the
/// system's.
pub fn numba() -> Option<(PathBuf, String)> {
    let own = folder().join("../venv-bench/bin/python");
    [own, PathBuf::from("python3")].into_iter().find_map(|python| {
        let script = "import numba, platform; print('Python', platform.python_version(), 'numba', numba.__version__)";
        let out = Command::new(&python).args(["-c", script]).output().ok().filter(|o| o.status.success())?;
        Some((python, String::from_utf8_lossy(&out.stdout).trim().to_owned()))
    })
}

/// Returns the folder of the compiled peers.
pub fn folder() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    target.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../target")).join("peers")
}

/// `string 24` → `string-24`
fn file(name: &str) -> String {
    name.replace(|c: char| !c.is_ascii_alphanumeric(), "-")
}

impl Builder {
    /// Takes the folder, and the limit of each compiler run \[s\].
    ///
    /// # Errors
    /// If the folder cannot be created.
    pub fn new(folder: PathBuf, limit: u32) -> Result<Builder, std::io::Error> {
        std::fs::create_dir_all(&folder)?;
        Ok(Builder { folder, limit })
    }

    /// Writes the table of a network, for the peers that play any network.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn table(&self, net: &Net) -> Result<PathBuf, std::io::Error> {
        let path = self.folder.join(file(&net.name) + ".table");
        std::fs::write(&path, write::table(net))?;
        Ok(path)
    }

    /// Compiles a source in `benches/peers`.
    ///
    /// # Errors
    /// If it cannot be compiled.
    pub fn peer(&self, source: &str, compiler: &str) -> Result<PathBuf, Without> {
        let path = sources().join(source);
        let text = std::fs::read_to_string(&path).map_err(|e| Without::Failed(e.to_string()))?;
        self.compiled(&file(source), compiler, &path, &text)
    }

    /// Compiles a network by Faust and a compiler.
    ///
    /// # Errors
    /// If it cannot be compiled.
    pub fn faust(&self, net: &Net, compiler: &str) -> Result<PathBuf, Without> {
        let program = write::faust(net).ok_or_else(|| Without::Missing("a library for space".into()))?;
        let by = version("faust").ok_or_else(|| Without::Missing("faust".into()))?;
        let frame = sources().join("faust.cpp");
        let frame_text = std::fs::read_to_string(&frame).unwrap_or_default();
        let made = self.named(&file(&net.name), &[&program, &frame_text, &by], "cpp");
        let written = made.with_extension("dsp");
        std::fs::write(&written, &program).map_err(|e| Without::Failed(e.to_string()))?;
        self.run(&made, |to| {
            let mut c = self.limited("faust");
            c.args(["-double", "-t", "0", "-a"]).arg(&frame).arg(&written).arg("-o").arg(to);
            c
        })?;
        let text = std::fs::read_to_string(&made).map_err(|e| Without::Failed(e.to_string()))?;
        self.compiled(&file(&net.name), compiler, &made, &text)
    }

    fn compiled(&self, name: &str, compiler: &str, source: &Path, text: &str) -> Result<PathBuf, Without> {
        let by = version(compiler).ok_or_else(|| Without::Missing(compiler.into()))?;
        let header = |name: &str| std::fs::read_to_string(sources().join(name)).unwrap_or_default();
        let made = self.named(name, &[text, &header("player.h"), &header("table.h"), compiler, &by], "peer");
        self.run(&made, |to| {
            let mut c = self.limited(compiler);
            c.args(FLAGS).arg("-I").arg(sources()).arg(source).arg("-o").arg(to).arg("-lm");
            c
        })?;
        Ok(made)
    }

    fn named(&self, name: &str, of: &[&str], extension: &str) -> PathBuf {
        let mut hash = DefaultHasher::new();
        (of, FLAGS).hash(&mut hash);
        self.folder.join(format!("{name}-{:016x}.{extension}", hash.finish()))
    }

    fn limited(&self, program: &str) -> Command {
        let mut c = Command::new("timeout");
        c.arg(self.limit.to_string()).arg(program);
        c
    }

    /// Makes a file that does not exist yet, by a command that writes it.
    fn run(&self, made: &Path, command: impl Fn(&Path) -> Command) -> Result<(), Without> {
        if made.exists() {
            return Ok(());
        }
        let late = PathBuf::from(format!("{}.late", made.display()));
        let before = std::fs::read_to_string(&late).ok().and_then(|t| t.trim().parse::<u32>().ok());
        if let Some(tried) = before.filter(|tried| *tried >= self.limit) {
            return Err(Without::Late(tried));
        }
        let failed = |e: std::io::Error| Without::Failed(e.to_string());
        let part = PathBuf::from(format!("{}.part", made.display()));
        let out = command(&part).output().map_err(failed)?;
        match out.status.code() {
            Some(0) => std::fs::rename(&part, made).map_err(failed),
            Some(124) => {
                std::fs::write(&late, self.limit.to_string()).map_err(failed)?;
                Err(Without::Late(self.limit))
            }
            _ => Err(Without::Failed(String::from_utf8_lossy(&out.stderr).into_owned())),
        }
    }
}
