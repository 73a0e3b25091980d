//! Work and precision: the scenes of `docs/measured/accuracy.md`, what is expected of them, and how the page is written, so that a
//! test finds the same there. The bench itself stands with the command it runs, `ca accuracy`.
//!
//! Decides that what is expected is computed from the rows of the tables, by whoever reads them: the bench after it
//! measured, the test from the page.

pub mod page;
mod scenes;
pub mod svg;

pub use scenes::{CASES, STIFF, pluck, stiffened};

/// A scene, and how it is measured.
pub struct Case {
    /// of its picture and of its place on the page
    pub name: &'static str,
    /// what it is
    pub title: &'static str,
    /// the model file
    pub text: fn() -> String,
    /// as long as it is played \[s\]
    pub seconds: &'static str,
    /// multiples of the rate
    pub times: &'static str,
    /// the multiple of the reference, where it is not a closed form
    pub reference: &'static str,
    /// what there is to be seen
    pub about: &'static str,
}

/// One way to play a scene, as `ca accuracy --json` tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorRow {
    /// method
    pub method: String,
    /// multiple of the rate
    pub times: u32,
    /// of the outputs, relative; infinite where it diverged
    pub error: f64,
    /// of the levels of the spectrum, relative
    pub spectrum: f64,
    /// of the strongest partial \[cents\]
    pub cents: Option<f64>,
    /// of the second half against the first \[dB\]
    pub decay: Option<f64>,
    /// energy that the scheme made, relative
    pub made: Option<f64>,
    /// time of a sample of the model's rate \[ns\]
    pub ns: f64,
    /// what is certified
    pub stability: String,
    /// nothing is both more exact and quicker
    pub front: bool,
}

/// All that was found of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// what it was held against, in words
    pub against: String,
    /// how well that is known, relative
    pub known: f64,
    /// a way each
    pub rows: Vec<ErrorRow>,
    /// methods that the scene cannot take, with the reason, and what others leave out
    pub reported: Vec<String>,
}

impl Found {
    /// The row of a method at a multiple of the rate.
    pub fn row(&self, method: &str, times: u32) -> Option<&ErrorRow> {
        self.rows.iter().find(|r| r.method == method && r.times == times)
    }

    /// Error and time of a row; not a number where there is none.
    fn of(&self, method: &str, times: u32) -> [f64; 2] {
        self.row(method, times).map_or([f64::NAN; 2], |r| [r.error.max(self.known), r.ns])
    }
}

/// What is expected, and what is.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// what
    pub what: String,
    /// at most this
    pub most: f64,
    /// it is
    pub is: f64,
}

impl Claim {
    /// True where it is as expected.
    pub fn holds(&self) -> bool {
        self.is <= self.most
    }
}

/// What is expected: of the plucked string for 0.1 s and for 1 s, and with so many links stiff as [`STIFF`] says.
pub fn claims(pluck: &Found, long: &Found, stiff: &[Found; 3]) -> Vec<Claim> {
    let claim = |what: &str, most: f64, is: f64| Claim { what: what.into(), most, is };
    let ([modal, modal_ns], [_, ns]) = (pluck.of("modal", 1), pluck.of("as written", 1));
    let [far, far_ns] = long.of("modal", 1);
    let ([fourth, fourth_ns], [fine, fine_ns]) = (pluck.of("pefrl", 1), pluck.of("as written", 32));
    let [none, one, eight] = stiff.each_ref().map(|f| f.of("as written", 1)[1]);
    vec![
        claim("error of `modal` over 0.1 s", 1e-11, modal),
        claim("error of `modal` over 1 s", 1e-9, far),
        claim("time of `modal` over that of `ca`, 0.1 s", 2.0, modal_ns / ns),
        claim("time of `modal` over that of `ca`, 1 s", 2.0, far_ns / long.of("as written", 1)[1]),
        claim("error of `pefrl` over that of `ca` at 32 times the rate", 1.25, fourth / fine),
        claim("time of `pefrl` over that of `ca` at 32 times the rate", 0.35, fourth_ns / fine_ns),
        claim("time with one link 10⁶ beyond the limit over that without", 2.5, one / none),
        // as on two processors: 0.20 and 0.29 for `pefrl`, 1.7 and 2.0, 2.1 and 3.1 for stiff links at the same instructions.
        // A row without such links stands folded, which took a quarter of its time; the others do not
        claim("time with eight of 65 links 10⁶ beyond the limit over that without", 3.5, eight / none),
    ]
}
