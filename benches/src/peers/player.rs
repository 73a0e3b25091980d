//! Players of a network: the engine in this process, or a peer that receives requests line by line.

use super::net::Net;
use super::write;
use ca_accuracy::timing::processor;
use cordis_anima::ca_core::Location;
use cordis_anima::{Loaded, Options, Scene, State, process};
use std::io::{BufRead as _, BufReader, Error, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Ticks before the clock starts, as in `benches/peers/player.h`.
pub const WARM: usize = 1024;
/// Ticks per call, as in `benches/peers/player.h`.
pub const BLOCK: usize = 64;

/// Plays one network.
pub trait Player {
    /// Returns the output of the first ticks.
    ///
    /// # Errors
    /// If a process has ended.
    fn play(&mut self, ticks: usize) -> Result<Vec<f64>, Error>;

    /// Returns the processor time of `ticks` ticks \[ns\], after [`WARM`] ticks from the start.
    ///
    /// # Errors
    /// If a process has ended.
    fn time(&mut self, ticks: usize) -> Result<f64, Error>;
}

/// The engine: a model loaded, compiled and played as by any program with the engine as a library.
///
/// Each round resets the same state, because a peer keeps the memory that it was given at its start. Both are started
/// equally often.
pub struct Engine {
    scene: Scene,
    state: State,
}

impl Engine {
    /// Compiles the model of a network; panics on errors in it.
    pub fn new(net: &Net) -> Engine {
        let loaded = Loaded::read(&write::model(net), "peer.ca.toml");
        let compiled = loaded.compile(&Options::default());
        let scene = compiled.unwrap_or_else(|e| panic!("{}: {}", net.name, e.diags)).scene;
        Engine { state: scene.state(), scene }
    }

    /// Returns the network with the position of every MAT in the first sample and the step that leads there. Peers thus
    /// start like the engine, which subtracts half the force of the first tick from the step at load.
    pub fn started(&self, net: &Net) -> Net {
        let (mut started, state) = (net.clone(), &self.scene.initial);
        for symbol in &self.scene.symbols {
            let name = symbol.name.to_string();
            let number = name.rsplit('.').next().and_then(|name| name.strip_prefix('m'));
            let (Some(i), Location::Mat(at)) = (number.and_then(|n| n.parse::<usize>().ok()), symbol.location) else {
                continue;
            };
            for e in 0..symbol.axes as usize {
                let at = at as usize + e;
                started.mats[i].x[e] = self.scene.layout.places.rest[at] + state.x[at];
                started.mats[i].v[e] = state.d[at];
            }
        }
        started
    }

    /// Returns the number of modules computed, with all pairs of a line as one.
    pub fn modules(&self) -> usize {
        self.scene.symbols.len()
    }

    fn begin(&mut self) {
        self.state.clone_from(&self.scene.initial);
    }

    fn blocks(&mut self, ticks: usize, mut heard: impl FnMut(&[f64])) {
        let mut out = [0.0; BLOCK];
        for _ in 0..ticks / BLOCK {
            assert!(process(&self.scene, &mut self.state, &mut out), "a state of this scene");
            heard(&out);
        }
    }
}

impl Player for Engine {
    fn play(&mut self, ticks: usize) -> Result<Vec<f64>, Error> {
        let mut all = Vec::with_capacity(ticks);
        self.begin();
        self.blocks(ticks, |out| all.extend_from_slice(out));
        Ok(all)
    }

    fn time(&mut self, ticks: usize) -> Result<f64, Error> {
        self.begin();
        self.blocks(WARM, |_| ());
        let begin = processor();
        self.blocks(ticks, |out| {
            std::hint::black_box(out);
        });
        Ok(processor().saturating_sub(begin).as_nanos() as f64)
    }
}

/// A peer process; it ends when its input ends.
pub struct Peer {
    child: Child,
    asked: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts a program with the file that it plays.
    ///
    /// # Errors
    /// If it does not start.
    pub fn start(command: &[&Path], what: &Path) -> Result<Peer, Error> {
        let [program, args @ ..] = command else { return Err(Error::other("no program")) };
        let mut child =
            Command::new(program).args(args).arg(what).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let (Some(asked), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(Error::other("no pipes"));
        };
        Ok(Peer { child, asked: Some(asked), answers: BufReader::new(answers) })
    }

    fn ask(&mut self, what: &str, ticks: usize) -> Result<(), Error> {
        let asked = self.asked.as_mut().ok_or_else(|| Error::other("it has ended"))?;
        writeln!(asked, "{what} {ticks}")?;
        asked.flush()
    }

    fn number(&mut self) -> Result<f64, Error> {
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        line.trim().parse().map_err(|_| Error::other(format!("the player answered `{}`, not a number", line.trim())))
    }
}

impl Player for Peer {
    fn play(&mut self, ticks: usize) -> Result<Vec<f64>, Error> {
        self.ask("hear", ticks)?;
        (0..ticks).map(|_| self.number()).collect()
    }

    fn time(&mut self, ticks: usize) -> Result<f64, Error> {
        self.ask("time", ticks)?;
        self.number()
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.asked.take());
        let _ = self.child.wait();
    }
}

/// Returns the largest difference of two sounds, relative to the largest value of the first; NaN if either contains
/// NaN.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let top = a.iter().fold(0.0, |top: f64, v| top.max(v.abs()));
    // `max` ignores NaN, and a plain comparison loses it at the next value
    let most = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |most: f64, d| if most.is_nan() || d <= most { most } else { d });
    most / top
}
