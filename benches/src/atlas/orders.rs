//! Order of convergence of every method from the first tick on: from a displacement, with a speed, and under a moving
//! hand.
//!
//! The error is against a closed form if there is one. Otherwise the order follows from the convergence over three
//! rates, each twice the one before.

use crate::{mat, scene};
use ca_core::tick;
use ca_io::perform::Performance;
use std::f64::consts::TAU;

/// Frequency of the oscillator \[Hz\].
const F: f64 = 20.0;
/// θ of the fourth order.
const TWELFTH: &str = "method = \"implicit\"\ntheta = 0.08333333333333333";

/// A method and its order.
pub struct Case {
    /// Usual name.
    pub name: &'static str,
    /// Its lines in `[model]`.
    pub method: &'static str,
    /// Test scene.
    pub on: On,
    /// Expected order.
    pub order: f64,
}

/// Test scene of a method.
pub enum On {
    /// Oscillator of 1 kg with this viscosity \[N s/m\].
    Oscillator(f64),
    /// Bar tied by this link to a hand at constant speed.
    Hand(&'static str),
}

const BOW: &str = "[BOW]\nrub = { between = [\"hand\", \"bar\"], f = 0.5, v0 = 0.2, method = \"newton\" }";
const TIE: &str = "[REF]\ntie = { between = [\"hand\", \"bar\"], k = 400, z = 0.5 }";
const SPRING: &str = "[REF]\ntie = { between = [\"hand\", \"bar\"], k = 400 }";

/// All cases reported.
pub const CASES: [Case; 12] = [
    Case { name: "`ca`, without viscosity", method: "method = \"ca\"", on: On::Oscillator(0.0), order: 2.0 },
    Case { name: "`ca`, with viscosity", method: "method = \"ca\"", on: On::Oscillator(6.0), order: 1.0 },
    Case { name: "`centred`, with viscosity", method: "method = \"centred\"", on: On::Oscillator(6.0), order: 2.0 },
    Case {
        name: "`implicit` 1/4, with viscosity",
        method: "method = \"implicit\"\ntheta = 0.25",
        on: On::Oscillator(6.0),
        order: 2.0,
    },
    Case {
        name: "`implicit` 1/2, without viscosity",
        method: "method = \"implicit\"\ntheta = 0.5",
        on: On::Oscillator(0.0),
        order: 2.0,
    },
    Case { name: "`implicit` 1/12, without viscosity", method: TWELFTH, on: On::Oscillator(0.0), order: 4.0 },
    Case { name: "`implicit` 1/12, with viscosity", method: TWELFTH, on: On::Oscillator(6.0), order: 2.0 },
    Case { name: "`pefrl`, without viscosity", method: "method = \"pefrl\"", on: On::Oscillator(0.0), order: 4.0 },
    Case { name: "`newton`, a bow at a steady speed", method: "method = \"centred\"", on: On::Hand(BOW), order: 2.0 },
    Case {
        name: "`centred`, tied to a hand at a steady speed",
        method: "method = \"centred\"",
        on: On::Hand(TIE),
        order: 2.0,
    },
    Case {
        name: "`implicit` 1/4, tied to a hand at a steady speed",
        method: "method = \"implicit\"\ntheta = 0.25",
        on: On::Hand(TIE),
        order: 2.0,
    },
    Case {
        name: "`implicit` 1/12, on a spring to a hand at a steady speed",
        method: TWELFTH,
        on: On::Hand(SPRING),
        order: 4.0,
    },
];

/// Initial displacement \[m\] and speed \[m/s\] of an oscillator.
const FROM: [[f64; 2]; 3] = [[1.0, 0.0], [0.0, TAU * F], [0.6, -2.0 * TAU * F]];

impl Case {
    /// Returns the orders measured: for an oscillator from a displacement, with a speed and with both; for a hand a
    /// single one.
    pub fn measured(&self) -> Vec<f64> {
        match self.on {
            On::Oscillator(z) => {
                let e = |rate: f64, from: [f64; 2]| missed(rate, from, z, self.method);
                FROM.map(|from| (e(1000.0, from) / e(4000.0, from)).log2() / 2.0).to_vec()
            }
            On::Hand(link) => vec![converges(link, self.method, 2000.0)],
        }
    }

    /// Formats a row of the page.
    pub fn row(&self) -> String {
        let cells: Vec<String> = match &self.measured()[..] {
            [hand] => vec!["–".into(), "–".into(), "–".into(), format!("{hand:.1}")],
            all => all.iter().map(|o| format!("{o:.1}")).chain(["–".into()]).collect(),
        };
        format!("| {} | {:.0} | {} |", self.name, self.order, cells.join(" | "))
    }
}

/// Returns the largest error of an oscillator in a second.
fn missed(rate: f64, from: [f64; 2], z: f64, method: &str) -> f64 {
    let w = TAU * F;
    let text = format!(
        "[model]\n{method}\n[rate]\nsound = {rate:?}\ngesture = {rate:?}\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = {:?}, v = {:?} }}\n\
         [REF]\nhold = {{ between = [\"wall\", \"bob\"], k = {:?}, z = {z:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n",
        from[0],
        from[1],
        w * w
    );
    let scene = scene(&text);
    let (mut state, i) = (scene.state(), mat(&scene, "bob"));
    let s = 0.5 * z;
    let damped = (w * w - s * s).sqrt();
    let exact = |t: f64| {
        (-s * t).exp() * (from[0] * (damped * t).cos() + (from[1] + s * from[0]) / damped * (damped * t).sin())
    };
    (1..=rate as usize).fold(0.0f64, |worst, n| {
        tick(&scene, &mut state);
        worst.max((state.x[i] - exact(n as f64 / rate)).abs())
    })
}

/// Returns the order of convergence over three rates, for a bar under a hand that moves at constant speed from before
/// the first tick. A port is a tick late, so the gesture is a tick ahead.
fn converges(link: &str, method: &str, slowest: f64) -> f64 {
    let run = |times: usize| -> Vec<f64> {
        let rate = slowest * times as f64;
        let text = format!(
            "[model]\n{method}\n[rate]\nsound = {rate:?}\ngesture = {rate:?}\n[CEL]\nbar = {{ m = 0.01, k = 600, v = 0.1 }}\n[ENX]\nhand = {{}}\n\
             {link}\n[SOX]\nout = {{ from = \"bar\" }}\n[gesture]\nhand = [[0, {:?}], [1, {:?}]]\n",
            0.01 + 0.4 / rate,
            0.41 + 0.4 / rate
        );
        let scene = scene(&text);
        let i = mat(&scene, "bar");
        let Ok(mut p) = Performance::new(&scene, None) else { return Vec::new() };
        let sample = |_| {
            (0..times).for_each(|_| p.tick());
            p.state.x[i]
        };
        (0..(slowest * 0.05) as usize).map(sample).collect()
    };
    let [a, b, c] = [1, 2, 4].map(run);
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    (apart(&a, &b) / apart(&b, &c)).log2()
}
