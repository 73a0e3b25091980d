//! Work and precision: the scenes of `docs/measured/accuracy.md`, what is expected of them, and how the page is written, so that a
//! test finds the same there. The bench itself stands with the command it runs, `ca accuracy`.
//!
//! Decides that what is expected is computed from the rows of the tables, by whoever reads them: the bench after it
//! measured, the test from the page.

pub mod page;
pub mod svg;

use std::fmt::Write as _;

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

/// All scenes of the page with a picture.
pub const CASES: [Case; 7] = [
    Case {
        name: "pluck",
        title: "A plucked string",
        text: || pluck(&[]),
        seconds: "0.1",
        times: "1,2,4,8,32",
        reference: "64",
        about: "64 masses between fixed ends, T²k/m = 1/4, let go from a triangle; the reference case B01. Its highest \
                partials are far from where they belong by the explicit scheme, and four times the rate is four times the \
                work for a quarter of the error. By its modes it is exact, and a fourth-order tick at the rate of the \
                model is worth thirty times that rate.",
    },
    Case {
        name: "bar",
        title: "A stiff bar",
        text: bar,
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "40 masses that resist bending only, free at both ends, pushed by a mass of 20 g that stays on it. All of it \
                is linear, and what is low in pitch is near enough by any method.",
    },
    Case {
        name: "membrane",
        title: "A membrane",
        text: membrane,
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "12 × 10 masses with a fixed border, hit by a felt hammer (Hertz). Once hit it is linear again: the modes are \
                exact, and what is left is the error of the touch.",
    },
    Case {
        name: "impact",
        title: "A Hertz impact",
        text: || IMPACT.into(),
        seconds: "0.01",
        times: "1,2,4,8",
        reference: "128",
        about: "A ball of 10 g on a wall, once, for 10 ms. The explicit contact makes or loses energy (made), the stable one \
                does not; neither is far from the other in the error of the ball's flight.",
    },
    Case {
        name: "bow",
        title: "A bowed mass",
        text: || BOW.into(),
        seconds: "0.3",
        times: "1,2,4,8",
        reference: "128",
        about: "A cell of 220 Hz under a bow. Whether it sticks or slips is decided anew in every period, and the pitch \
                hangs on when: the explicit bow and the linearised one are late by part of a tick each time, the one that \
                is solved is not.",
    },
    Case {
        name: "rattle",
        title: "The rattle",
        text: || include_str!("../../../models/rattle.ca.toml").into(),
        seconds: "0.1",
        times: "1,2,8",
        reference: "128",
        about: "`models/rattle.ca.toml` before the hand moves: three tetrahedra fall into one another, and their first \
                touches ring the sheet. Contacts follow contacts, and no method has a say in what comes after a few: a little \
                later nothing converges. What can be judged there is the energy that is made.",
    },
    Case {
        name: "piano",
        title: "The piano of twelve keys",
        text: || include_str!("../../../models/hammer_piano.ca.toml").into(),
        seconds: "0.2",
        times: "1,2,4,8",
        reference: "64",
        about: "`models/hammer_piano.ca.toml` by its own gestures. Gestures come 3000 times a second at every rate of the \
                sound, the felt of the hammers is lossy, and the strings' damping is centred or not: that is most of the \
                difference.",
    },
];

/// Masses of the plucked string, their mass \[kg\], and the stiffness between them \[N/m\] at 48 kHz.
const N: usize = 64;
const M: f64 = 1e-4;
const K: f64 = 0.25 * M * 48e3 * 48e3;

/// How many links of the plucked string are made stiff, where that is priced.
pub const STIFF: [usize; 3] = [0, 1, 8];

/// The plucked string with these links a million times stiffer than the limit of two masses, by the method `implicit`.
pub fn pluck(stiff: &[usize]) -> String {
    let mut t = String::from("[SOL]\nl = {}\nr = {}\n[MAS]\n");
    for i in 0..N {
        let s = (i + 1) as f64 / (N + 1) as f64;
        let y = 1e-3 * if s < 0.2 { s / 0.2 } else { (1.0 - s) / 0.8 };
        let _ = writeln!(t, "p{i} = {{ m = {M:?}, dx0 = {y:?} }}");
    }
    t += "[RES]\n";
    for i in 0..=N {
        let a = if i == 0 { "l".into() } else { format!("p{}", i - 1) };
        let b = if i == N { "r".into() } else { format!("p{i}") };
        let (k, method) = if stiff.contains(&i) {
            (1e6 * 2.0 * M * 48e3 * 48e3, ", method = \"implicit\", theta = 0.25")
        } else {
            (K, "")
        };
        let _ = writeln!(t, "t{i} = {{ between = [\"{a}\", \"{b}\"], k = {k:?}{method} }}");
    }
    t + "[SOX]\nout = { from = \"p19\" }\n"
}

/// The plucked string with `n` stiff links spread over it.
pub fn stiffened(n: usize) -> String {
    let stiff: Vec<usize> = (0..n).map(|i| (2 * i + 1) * N / (2 * n)).collect();
    pluck(&stiff)
}

fn bar() -> String {
    "[STIFFSTRING]\nbar = { n = 40, m = \"1 g\", k = 0, kb = \"100 kN/m\", ends = \"free\" }\n\
     [MAS]\nfelt = { m = \"20 g\", v = \"1 m/s\" }\n\
     [RES]\ncling = { between = [\"felt\", \"bar[9]\"], k = \"20 kN/m\" }\n[SOX]\nout = { from = \"bar[31]\" }\n"
        .into()
}

fn membrane() -> String {
    "[MESH]\nskin = { nx = 12, ny = 10, m = \"0.1 g\", k = \"20 kN/m\", edges = \"closed\" }\n\
     [MAS]\nhead = { m = \"2 g\", x = \"-0.1 mm\", v = \"1.5 m/s\" }\n\
     [HRZ]\nstrike = { between = [\"head\", \"skin[4,3]\"], k = \"1e6 N/m^1.5\" }\n[SOX]\nout = { from = \"skin[8,6]\" }\n"
        .into()
}

const IMPACT: &str = "[SOL]\nwall = {}\n[MAS]\nball = { m = \"10 g\", x = \"1 mm\", v = \"-2 m/s\" }\n\
                      [HRZ]\nhit = { between = [\"wall\", \"ball\"], k = \"5e7 N/m^1.5\" }\n[SOX]\nout = { from = \"ball\" }\n";

const BOW: &str = "[CEL]\nbob = { m = \"1 g\", f = \"220 Hz\", t60 = \"2 s\" }\n[ENX]\nbow = {}\n\
                   [BOW]\nhair = { between = [\"bow\", \"bob\"], f = \"0.5 N\", v0 = \"0.1 m/s\" }\n[SOX]\nout = { from = \"bob\" }\n\
                   [gesture]\nbow = [[0, 0], [0.3, \"60 mm\"]]\n";

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
        claim("time of `pefrl` over that of `ca` at 32 times the rate", 0.25, fourth_ns / fine_ns),
        claim("time with one link 10⁶ beyond the limit over that without", 2.0, one / none),
        // a row without such links stands folded, which took a quarter of its time; the others do not
        claim("time with eight of 65 links 10⁶ beyond the limit over that without", 2.5, eight / none),
    ]
}
