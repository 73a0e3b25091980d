//! Error and run time: the scenes of `docs/measured/accuracy.md`, their expectations, and the format of the page, which
//! a test compares with it. The bench itself is with the command that it runs, `ca accuracy`.
//!
//! The reader of the tables computes the claims from their rows: the bench after measuring, the test from the page.

pub mod page;
mod scenes;
pub mod svg;

pub use scenes::{CASES, STIFF, pluck, stiffened};

/// A scene and its measurement.
pub struct Case {
    /// Name of its picture and of its section on the page.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// Returns the model file.
    pub text: fn() -> String,
    /// Length of the play \[s\].
    pub seconds: &'static str,
    /// Multiples of the rate.
    pub times: &'static str,
    /// Multiple of the rate for the reference, unless that is in closed form.
    pub reference: &'static str,
    /// Text about the results.
    pub about: &'static str,
}

/// One way to play a scene, as in `ca accuracy --json`.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorRow {
    /// Method.
    pub method: String,
    /// Multiple of the rate.
    pub times: u32,
    /// Relative error of the outputs; infinite if the scene diverged.
    pub error: f64,
    /// Relative error of the levels of the spectrum.
    pub spectrum: f64,
    /// Error of the strongest partial \[cents\].
    pub cents: Option<f64>,
    /// Error of the second half relative to the first \[dB\].
    pub decay: Option<f64>,
    /// Energy made by the scheme, relative.
    pub made: Option<f64>,
    /// Time of a sample at the rate of the model \[ns\].
    pub ns: f64,
    /// Certified stability.
    pub stability: String,
    /// True if nothing is both more exact and faster.
    pub front: bool,
}

/// Results of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Reference of the comparison, in words.
    pub against: String,
    /// Relative accuracy of the reference.
    pub known: f64,
    /// Rows, one for each way.
    pub rows: Vec<ErrorRow>,
    /// Methods that the scene does not support, with the reason, and modules that others leave out.
    pub reported: Vec<String>,
}

impl Found {
    /// Returns the row of a method at a multiple of the rate.
    pub fn row(&self, method: &str, times: u32) -> Option<&ErrorRow> {
        self.rows.iter().find(|r| r.method == method && r.times == times)
    }

    /// Returns error and time of a row; NaN if there is none.
    fn of(&self, method: &str, times: u32) -> [f64; 2] {
        self.row(method, times).map_or([f64::NAN; 2], |r| [r.error.max(self.known), r.ns])
    }
}

/// An expectation and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Description.
    pub what: String,
    /// Largest value expected.
    pub most: f64,
    /// Value found.
    pub is: f64,
}

impl Claim {
    /// Returns true if the expectation is met.
    pub fn holds(&self) -> bool {
        self.is <= self.most
    }
}

/// Returns the claims, from the plucked string for 0.1 s and for 1 s, and from the strings with the numbers of stiff
/// links in [`STIFF`].
pub fn claims(pluck: &Found, long: &Found, stiff: &[Found; 3]) -> Vec<Claim> {
    let claim = |what: &str, most: f64, is: f64| Claim { what: what.into(), most, is };
    let ([modal, modal_ns], [_, ns]) = (pluck.of("modal", 1), pluck.of("as written", 1));
    let [far, far_ns] = long.of("modal", 1);
    let ([fourth, fourth_ns], [fine, fine_ns]) = (pluck.of("pefrl", 1), pluck.of("as written", 32));
    let [none, one, eight] = stiff.each_ref().map(|f| f.of("as written", 1)[1]);
    vec![
        claim("error of `modal` over 0.1 s", 1e-11, modal),
        claim("error of `modal` over 1 s", 1e-9, far),
        claim("time of `modal` over time of `ca`, 0.1 s", 2.0, modal_ns / ns),
        claim("time of `modal` over time of `ca`, 1 s", 2.0, far_ns / long.of("as written", 1)[1]),
        claim("error of `pefrl` over error of `ca` at 32 times the rate", 1.25, fourth / fine),
        claim("time of `pefrl` over time of `ca` at 32 times the rate", 0.35, fourth_ns / fine_ns),
        claim("time with one link 10⁶ beyond the limit over that without", 2.5, one / none),
        // measured on two processors: 0.20 and 0.29 for `pefrl`; 1.7 and 2.0, 2.1 and 3.1 for one and eight stiff
        // links, at
        // the same instructions. A row without stiff links is folded, which saves a quarter of its time; the others are
        // not
        claim("time with eight of 65 links 10⁶ beyond the limit over that without", 3.5, eight / none),
    ]
}
