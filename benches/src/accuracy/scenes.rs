//! Scenes of the page of error against run time: small ones with a single source of error each, and two bundled models.

use super::Case;
use std::fmt::Write as _;

/// All scenes of the page with a picture.
pub const CASES: [Case; 12] = [
    Case {
        name: "pluck",
        title: "A plucked string",
        text: || pluck(&[]),
        seconds: "0.1",
        times: "1,2,4,8,32",
        reference: "64",
        about: "64 masses between fixed ends, T²k/m = 1/4, released from a triangle; the reference case B01. With the \
                explicit scheme its highest partials have large errors, and four times the rate is four times the \
                work for a quarter of the error. With its modes it is exact, and a fourth-order tick at the rate of \
                the model is as exact as the explicit scheme at thirty times that rate.",
    },
    Case {
        name: "bar",
        title: "A stiff bar",
        text: bar,
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "40 masses that resist bending only, free at both ends, pushed by a mass of 20 g that stays on it. All \
                of it is linear, and low partials are accurate with any method.",
    },
    Case {
        name: "membrane",
        title: "A membrane",
        text: membrane,
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "12 × 10 masses with a fixed border, hit by a felt hammer (Hertz). After the impact it is linear \
                again: the modes are exact, and only the error of the contact remains.",
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
        about: "A cell of 220 Hz under a bow. It changes between sticking and slipping in every period, and the pitch \
                depends on the moment: the explicit bow and the linearised one are late by part of a tick each time, \
                the solved one is not.",
    },
    Case {
        name: "belt",
        title: "A block on a belt",
        text: || BELT.into(),
        seconds: "0.3",
        times: "1,2,4,8",
        reference: "64",
        about: "10 g on a spring, on a belt at 0.1 m/s, with friction that sticks exactly (`method = \
                \"set-valued\"`): it sticks and slips ten times. Single precision refuses it: the rounding of the \
                motion of the belt, times m/T², exceeds the friction.",
    },
    Case {
        name: "plectrum",
        title: "A plectrum that comes from afar",
        text: || PLECTRUM.into(),
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "2 g fly at a string of 40 masses, take hold of it from one side (PLK, `side`, `engaged = false`) and let go at \
                1 mm. The string by itself is exact at the limit it is tuned to, so only the error of the moment of \
                release remains.",
    },
    Case {
        name: "stop",
        title: "A reed that beats on a stop",
        text: || STOP.into(),
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "A cell of 180 Hz and a stop whose damping works only while it presses and cannot pull (`sticky = false`): 18 \
                blows. The explicit contact makes energy, less at higher rates; the stable one makes none.",
    },
    Case {
        name: "modes",
        title: "A stable blow on a bar that goes by its modes",
        text: || MODES.into(),
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "A head of 10 g strikes a bar of 30 masses, free at both ends; the bar is modal, the contact is \
                `stable`. Energy is kept to rounding at every rate; the error comes from the force within a tick.",
    },
    Case {
        name: "rates",
        title: "A body at the gesture rate",
        text: || RATES.into(),
        seconds: "0.1",
        times: "1,2,4,8",
        reference: "64",
        about: "200 g on a spring, computed 3000 times a second (`rate = \"gesture\"`), tied to a string of 40 masses. All rows \
                and the reference have the same 3 kHz: this is the error of the sound. The error of the body is of \
                second order in the frame, and a test compares it with the same model at the sound rate.",
    },
    Case {
        name: "rattle",
        title: "The rattle",
        text: || include_str!("../../../models/rattle.ca.toml").into(),
        seconds: "0.1",
        times: "1,2,8",
        reference: "128",
        about: "`models/rattle.ca.toml` before the hand moves: three tetrahedra fall into one another, and their \
                first contacts excite the sheet. Contacts follow contacts, and after a few the motion is chaotic: no \
                method converges. Only the energy that is made can be judged there.",
    },
    Case {
        name: "piano",
        title: "The piano of twelve keys",
        text: || include_str!("../../../models/hammer_piano.ca.toml").into(),
        seconds: "0.3",
        times: "1,2,4",
        reference: "32",
        about: "`models/hammer_piano.ca.toml` by its own gestures, the first note. Gestures come 3000 times a second at every rate of the \
                sound, the felt of the hammers is lossy, and the strings' damping is centred or not: that is most of the \
                difference.",
    },
];

/// Masses of the plucked string, their mass \[kg\], and the stiffness between them \[N/m\] at 48 kHz.
const N: usize = 64;
const M: f64 = 1e-4;
const K: f64 = 0.25 * M * 48e3 * 48e3;

/// Numbers of stiff links in the plucked string, for the price of stiff links.
pub const STIFF: [usize; 3] = [0, 1, 8];

/// Returns the plucked string with these links a million times stiffer than the limit of two masses, by the method
/// `implicit`.
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

/// Returns the plucked string with `n` stiff links, evenly spread.
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

const BELT: &str = "[SOL]\nwall = {}\n[ENX]\nbelt = {}\n[MAS]\nblock = { m = \"10 g\" }\n\
                    [RES]\nspring = { between = [\"wall\", \"block\"], k = \"1 kN/m\" }\n\
                    [BOW]\nrub = { between = [\"block\", \"belt\"], curve = \"coulomb\", method = \"set-valued\", f = \"1.6 N\", \
                    fd = \"0.8 N\" }\n[SOX]\nout = { from = \"block\" }\n[gesture]\nbelt = [[0, 0], [0.3, \"30 mm\"]]\n";

const PLECTRUM: &str = "[STRING]\nlow = { n = 40, f = \"110 Hz\", t60 = \"3 s\", m = \"0.1 g\" }\n\
                        [MAS]\npick = { m = \"2 g\", x = \"-2 mm\", v = \"0.8 m/s\" }\n\
                        [PLK]\npluck = { between = [\"low[7]\", \"pick\"], k = \"2 kN/m\", d = \"1 mm\", side = \"up\", engaged = false }\n[SOX]\nout = { from = \"low[30]\" }\n";

const STOP: &str = "[SOL]\nceiling = { x = \"1 mm\" }\n[CEL]\nreed = { m = \"1 g\", f = \"180 Hz\", t60 = \"1 s\", dx0 = \"-2 mm\" }\n\
                    [BUT]\nbeat = { between = [\"reed\", \"ceiling\"], k = \"20 kN/m\", z = \"2 N s/m\", sticky = false }\n\
                    [SOX]\nout = { from = \"reed\" }\n";

const MODES: &str = "[bar]\nmethod = \"modal\"\n[bar.STIFFSTRING]\nrod = { n = 30, m = \"2 g\", k = 0, kb = \"100 kN/m\", ends = \"free\" }\n\
                     [MAS]\nhead = { m = \"10 g\", x = \"-0.1 mm\", v = \"1.5 m/s\" }\n\
                     [HRZ]\nstrike = { between = [\"head\", \"bar.rod[9]\"], k = \"1e7 N/m^1.5\", method = \"stable\" }\n\
                     [SOX]\nout = { from = \"bar.rod[21]\" }\n";

const RATES: &str = "[slow]\nrate = \"gesture\"\n[slow.MAS]\nheavy = { m = \"200 g\", v = \"0.3 m/s\" }\n[slow.SOL]\npost = {}\n\
                     [slow.RES]\nspring = { between = [\"slow.post\", \"slow.heavy\"], k = \"2 kN/m\" }\n\
                     [STRING]\nlow = { n = 40, f = \"110 Hz\", t60 = \"3 s\", m = \"0.1 g\" }\n\
                     [RES]\ntie = { between = [\"slow.heavy\", \"low[9]\"], k = \"500 N/m\" }\n[SOX]\nout = { from = \"low[30]\" }\n";
