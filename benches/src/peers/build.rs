//! Compiles the peers, once: a program is named by a hash of all it was made of, and one that is there is taken.
//!
//! Decides for the limit of time as of `timeout`, which ends all that a compiler started. That one did not finish is kept
//! too, and tried again when it is given more time.

use super::net::Net;
use super::write;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// All peers are compiled like this.
pub const FLAGS: [&str; 3] = ["-O3", "-march=native", "-ffast-math"];

/// Why there is no program.
#[derive(Clone, Debug, PartialEq)]
pub enum Without {
    /// what compiles it is not here
    Missing(String),
    /// it took longer than the limit \[s\]
    Late(u32),
    /// it failed, and what it printed
    Failed(String),
}

/// Compiles peers into a folder.
pub struct Builder {
    folder: PathBuf,
    /// of each compiler run \[s\]
    limit: u32,
}

/// The programs of peers.
fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peers")
}

/// The first line a program prints about itself; `None` where it is not here.
pub fn version(program: &str) -> Option<String> {
    let out = Command::new(program).arg("--version").output().ok().filter(|o| o.status.success())?;
    String::from_utf8_lossy(&out.stdout).lines().next().map(|l| l.trim().to_owned())
}

/// A Python that has numba, and the version of both: the one that `crates/ca-py/benches/run` installs, or that of the system.
pub fn numba() -> Option<(PathBuf, String)> {
    let own = folder().join("../venv-bench/bin/python");
    [own, PathBuf::from("python3")].into_iter().find_map(|python| {
        let script = "import numba, platform; print('Python', platform.python_version(), 'numba', numba.__version__)";
        let out = Command::new(&python).args(["-c", script]).output().ok().filter(|o| o.status.success())?;
        Some((python, String::from_utf8_lossy(&out.stdout).trim().to_owned()))
    })
}

/// Where peers are compiled to.
pub fn folder() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    target.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../target")).join("peers")
}

/// `string 24` → `string-24`
fn file(name: &str) -> String {
    name.replace(|c: char| !c.is_ascii_alphanumeric(), "-")
}

impl Builder {
    /// With a limit for each compiler run \[s\].
    ///
    /// # Errors
    /// Where the folder cannot be made.
    pub fn new(folder: PathBuf, limit: u32) -> Result<Builder, std::io::Error> {
        std::fs::create_dir_all(&folder)?;
        Ok(Builder { folder, limit })
    }

    /// The table of a network, for the peers that take any.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn table(&self, net: &Net) -> Result<PathBuf, std::io::Error> {
        let path = self.folder.join(file(&net.name) + ".table");
        std::fs::write(&path, write::table(net))?;
        Ok(path)
    }

    /// One of `benches/peers`, by a compiler.
    ///
    /// # Errors
    /// Where there is no program.
    pub fn peer(&self, source: &str, compiler: &str) -> Result<PathBuf, Without> {
        let path = sources().join(source);
        let text = std::fs::read_to_string(&path).map_err(|e| Without::Failed(e.to_string()))?;
        self.compiled(&file(source), compiler, &path, &text)
    }

    /// A network by Faust and a compiler.
    ///
    /// # Errors
    /// Where there is no program.
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

    /// Makes a file that is not there yet, by a command that writes it.
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
