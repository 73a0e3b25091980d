//! Runs the built command in an empty directory and collects its output.

use flac_codec::decode::FlacSampleReader;
use flac_codec::metadata::Metadata as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Empty working directory, and a private directory for shared memory and settings.
pub struct Sandbox(pub tempfile::TempDir, tempfile::TempDir);

/// Output of a run.
pub struct RunOutput {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Sandbox {
    pub fn new() -> Sandbox {
        // short, because socket names are limited
        Sandbox(tempfile::tempdir().unwrap(), tempfile::Builder::new().prefix("ca").tempdir_in("/tmp").unwrap())
    }
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
    /// Path prefix of the shared memory: its names begin with the last component.
    pub fn shm(&self) -> PathBuf {
        self.1.path().join(self.1.path().file_name().unwrap())
    }
    pub fn put(&self, name: &str, text: &str) -> &Sandbox {
        fs::write(self.path(name), text).unwrap();
        self
    }
    /// Prepares a program in this directory with private shared memory and settings.
    fn command(&self, program: &str) -> Command {
        let mut c = Command::new(program);
        c.current_dir(&self.0).env("CA_SHM_ROOT", self.shm()).env("CA_CONFIG", self.1.path().join("cfg"));
        c
    }
    /// Starts the built command without waiting for it.
    pub fn start(&self, args: &[&str]) -> Child {
        let mut c = self.command(env!("CARGO_BIN_EXE_ca"));
        c.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }
    pub fn ca(&self, args: &[&str]) -> RunOutput {
        self.with(&[], args)
    }
    /// Runs the built command with additional environment variables.
    pub fn with(&self, environment: &[(&str, &str)], args: &[&str]) -> RunOutput {
        let mut c = self.command(env!("CARGO_BIN_EXE_ca"));
        let o = c.args(args).envs(environment.iter().copied()).output().unwrap();
        let text = |b: &[u8]| String::from_utf8(b.to_vec()).unwrap();
        RunOutput { code: o.status.code().unwrap(), out: text(&o.stdout), err: text(&o.stderr) }
    }
    /// Runs a shell line in which `ca` is the built command.
    #[cfg(unix)]
    pub fn sh(&self, line: &str) -> RunOutput {
        let bin = Path::new(env!("CARGO_BIN_EXE_ca")).parent().unwrap();
        let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
        let o = self.command("sh").args(["-ec", line]).env("PATH", path).output().unwrap();
        let text = |b: &[u8]| String::from_utf8(b.to_vec()).unwrap();
        let err = format!("$ {line}\n{}", text(&o.stderr));
        RunOutput { code: o.status.code().unwrap(), out: text(&o.stdout), err }
    }
    pub fn files(&self) -> Vec<String> {
        let mut list: Vec<String> =
            fs::read_dir(&self.0).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
        list.sort();
        list
    }
    /// Rate \[Hz\], channels and bits of a FLAC file, and its samples; full scale is 1.
    pub fn flac(&self, name: &str) -> ([u32; 3], Vec<f64>) {
        let mut flac = FlacSampleReader::open(self.path(name)).unwrap();
        let of = flac.metadata();
        let info = [of.sample_rate(), u32::from(of.channel_count()), of.bits_per_sample()];
        let full = f64::from(1 << (info[2] - 1));
        let mut samples = Vec::new();
        flac.read_to_end(&mut samples).unwrap();
        (info, samples.into_iter().map(|s| f64::from(s) / full).collect())
    }
    /// Format and samples of a WAV file; full scale is 1.
    pub fn wav(&self, name: &str) -> (hound::WavSpec, Vec<f64>) {
        let mut r = hound::WavReader::open(self.path(name)).unwrap();
        let spec = r.spec();
        let samples = match spec.sample_format {
            hound::SampleFormat::Float => r.samples::<f32>().map(|s| f64::from(s.unwrap())).collect(),
            hound::SampleFormat::Int => {
                let full = f64::from(1 << (spec.bits_per_sample - 1));
                r.samples::<i32>().map(|s| f64::from(s.unwrap()) / full).collect()
            }
        };
        (spec, samples)
    }
}

impl RunOutput {
    #[track_caller]
    pub fn is(self, code: i32) -> RunOutput {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.out, self.err);
        self
    }
    #[track_caller]
    pub fn says(self, words: &[&str]) -> RunOutput {
        for w in words {
            assert!(self.out.contains(w) || self.err.contains(w), "no `{w}` in\n{}\n{}", self.out, self.err);
        }
        self
    }
    #[track_caller]
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}\n{}", self.out))
    }
}

pub fn peak(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |p, s| p.max(s.abs()))
}

pub fn from_root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

pub fn mims(name: &str) -> String {
    fs::read_to_string(from_root("tests/mims").join(name)).unwrap()
}

/// Finds the code blocks of a Markdown page in one language, each with the text before it.
pub fn blocks<'a>(page: &'a str, language: &str) -> Vec<(&'a str, &'a str)> {
    let fence = format!("\n```{language}\n");
    page.match_indices(&fence)
        .map(|(at, _)| {
            let start = at + fence.len();
            let end = page[start..].find("```").map_or(page.len(), |n| start + n);
            (&page[..at], &page[start..end])
        })
        .collect()
}

/// A model with one cell, whose peak is its displacement at load.
pub const BAR: &str = r#"
[model]
title = "One bar"
seconds = "100 ms"
[param]
loud = 500
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s", dx0 = "1 mm" }
[SOX]
out = { from = "bar", gain = "loud" }
"#;

/// A copy of the hammered string, independent of changes to the bundled model.
pub const STRUCK: &str = include_str!("struck.ca.toml");

pub const KEY: &str = "time,key\n0,-0.003\n0.05,-0.003\n0.056,-0.0005\n0.09,-0.003\n";
