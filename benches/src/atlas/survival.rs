//! Survival table: the result of extreme cases, for each method.
//!
//! There is a list of cases and a list of methods. A method has a name, and a function from a case to its model, or to
//! `None` if the method does not apply. Energy is from the scene's own ledger, which other tests verify; everything
//! else is read from the state.

use super::friction::gripped;
use crate::{compiled, mat, model, string};
use ca_compile::KernelClass;
use ca_core::{Scene, State, tick};

/// An extreme case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Case {
    /// Mass on a spring and damper with this kT²/m and zT/m, released from 1.
    Oscillator(f64, f64),
    /// Bar of kT²/m = 0.1 gripped by a bow, with this zT/m as its steepest slope, slightly displaced.
    Bow(f64),
    /// Ball of kT²/m = 0.01 on a spring, which hits a wall at its rest position in every swing, with this kT²/m.
    Contact(f64),
    /// Two masses of this ratio on one spring and damper, with kT²/m = 1 and this zT/m by their mobility.
    Ratio(f64, f64),
    /// Struck string with a hardening end, with forces and lengths multiplied.
    Scale(f64, f64),
    /// String of 40 masses without damping.
    Undamped,
    /// Resonator of this zT/m that has died away.
    Dead(f64),
    /// One mass in free flight.
    Flight,
}

/// Result of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Largest displacement, and whether it still increased at the end.
    Largest(f64, bool),
    /// Factor per tick, and the tick at which it passed 1e200.
    Blown(f64, u64),
    /// Largest |E/E₀ − 1|, and |Σ m v| relative to one mass.
    Energy(f64, f64),
    /// Energy relative to the start when it passed all bounds, and the tick.
    Made(f64, u64),
    /// Largest difference from the plain case, relative to its peak.
    Differs(f64),
    /// Number of ticks with a denormal number, and whether all numbers are 0 at the end.
    Denormal(u64, bool),
    /// Error of the position relative to the distance.
    Astray(f64),
}

/// All rows of the table.
pub const CASES: &[Case] = &[
    Case::Oscillator(3.99, 0.0),
    Case::Oscillator(4.0, 0.0),
    Case::Oscillator(4.01, 0.0),
    Case::Oscillator(1e6, 0.0),
    Case::Oscillator(1e12, 0.0),
    Case::Oscillator(4e16, 0.0),
    Case::Oscillator(0.1, 1.94),
    Case::Oscillator(0.1, 1.96),
    Case::Oscillator(0.1, 1e3),
    Case::Oscillator(0.1, 1e9),
    Case::Bow(2.5),
    Case::Bow(100.0),
    Case::Contact(1.0),
    Case::Contact(3.0),
    Case::Contact(4.5),
    Case::Contact(1e8),
    Case::Contact(1e16),
    Case::Ratio(1e6, 0.0),
    Case::Ratio(1e6, 0.1),
    Case::Scale(1e9, 1.0),
    Case::Scale(1e-9, 1.0),
    Case::Scale(1.0, 1e9),
    Case::Scale(1.0, 1e-9),
    Case::Undamped,
    Case::Dead(1e-3),
    Case::Dead(0.5),
    Case::Flight,
];

/// A way to run a scene.
pub struct Method {
    /// Name, at the head of its column.
    pub name: &'static str,
    /// Returns the model of a case by this method; `None` if the method does not apply.
    pub text: fn(&Case) -> Option<String>,
}

/// All columns of the table.
pub const METHODS: &[Method] = &[
    Method { name: "ca", text: |case| Some(case.text("", "")) },
    Method { name: "stable", text: |case| contact(case, "stable") },
    Method { name: "stable3d", text: |case| contact(case, "stable3d") },
    Method { name: "centred", text: |case| linear(case, "method = \"centred\"") },
    Method { name: "implicit 1/4", text: |case| linear(case, "method = \"implicit\"\ntheta = 0.25") },
    Method { name: "implicit 1/2", text: |case| linear(case, "method = \"implicit\"\ntheta = 0.5") },
    Method { name: "modal", text: |case| matches!(case, Case::Undamped).then(|| by(case, "method = \"modal\"")) },
    Method { name: "secant", text: |case| rubbed(case, "secant") },
    Method { name: "newton", text: |case| rubbed(case, "newton") },
];

/// Returns the model of a case with one method for all of it.
fn by(case: &Case, method: &str) -> String {
    format!("[model]\n{method}\n{}", case.text("", ""))
}

/// Returns the model of a case by a method, if the case is about linear links and cells.
fn linear(case: &Case, method: &str) -> Option<String> {
    let about = matches!(case, Case::Oscillator(..) | Case::Ratio(..) | Case::Undamped | Case::Dead(_));
    about.then(|| by(case, method))
}

/// Returns the model of a case with its bow by a method; `None` if there is no bow.
fn rubbed(case: &Case, method: &str) -> Option<String> {
    let rub = "[BOW]\nrub = { ";
    matches!(case, Case::Bow(_)).then(|| case.text("", "").replace(rub, &format!("{rub}method = \"{method}\", ")))
}

/// Returns the model of a case with its contact by a method; `None` if there is no contact.
fn contact(case: &Case, method: &str) -> Option<String> {
    matches!(case, Case::Contact(_)).then(|| case.text("", &format!(", method = \"{method}\"")))
}

/// Returns a string struck by a hammer, with a hardening end, with forces multiplied by `k` and lengths by `l`.
pub fn scaled(k: f64, l: f64) -> String {
    let [m, link, z, zo, hammer] = [1e-3, 9e5, 0.01, 0.002, 5e-3].map(|v| v * k);
    let [blow, blow_z, soft, hard] = [2e4 * k, 0.1 * k, 1e3 * k, 1e8 * k / (l * l)];
    let [x, v] = [-1e-3 * l, 2.0 * l];
    format!(
        "[STRING]\ns = {{ n = 12, m = {m:?}, k = {link:?}, z = {z:?}, zo = {zo:?} }}\n[MAS]\n\
         hammer = {{ m = {hammer:?}, x = {x:?}, v = {v:?} }}\n[BUT]\n\
         strike = {{ between = [\"hammer\", \"s[3]\"], k = {blow:?}, z = {blow_z:?} }}\n[SOL]\nend = {{}}\n[CUB]\n\
         hard = {{ between = [\"end\", \"s[7]\"], k = {soft:?}, k3 = {hard:?} }}\n[SOX]\nout = {{ from = \"s[5]\" }}\n"
    )
}

const RATE: &str = "[rate]\nsound = 1\ngesture = 1\n";
const OUT: &str = "[SOX]\nout = { from = \"bob\" }\n";

impl Case {
    /// Returns the description for the first cell of a row.
    pub fn name(&self) -> String {
        let number = |v: f64| if (1e-2..1e4).contains(&v) || v == 0.0 { format!("{v}") } else { format!("{v:e}") };
        match *self {
            Case::Oscillator(a, 0.0) => format!("oscillator, a = {}", number(a)),
            Case::Oscillator(a, b) => format!("oscillator, a = {}, b = {}", number(a), number(b)),
            Case::Bow(b) => format!("bow, a = 0.1, b = {}", number(b)),
            Case::Contact(a) => format!("contact, a = {}", number(a)),
            Case::Ratio(r, 0.0) => format!("mass ratio {}, a = 1 on the pair", number(r)),
            Case::Ratio(r, b) => format!("mass ratio {}, a = 1, b = {} on the pair", number(r), number(b)),
            Case::Scale(k, 1.0) => format!("forces and masses × {}", number(k)),
            Case::Scale(_, l) => format!("lengths × {}", number(l)),
            Case::Undamped => "a string without damping".into(),
            Case::Dead(b) => format!("a resonator died away, b = {}", number(b)),
            Case::Flight => "free flight at 1 m/s".into(),
        }
    }

    /// Returns the ticks for the page and for the core suite.
    pub fn ticks(&self) -> [u64; 2] {
        match self {
            Case::Oscillator(..) | Case::Bow(_) => [48_000; 2],
            Case::Contact(_) => [1_000_000, 20_000],
            Case::Ratio(..) => [100 * 48_000, 48_000],
            Case::Scale(..) => [20_000; 2],
            Case::Undamped => [60 * 48_000, 48_000],
            Case::Dead(_) => [2_000_000; 2],
            Case::Flight => [3600 * 48_000, 10 * 48_000],
        }
    }

    /// Returns the model; `spring` and `contact` are appended to the parameters of the links of that kind.
    pub fn text(&self, spring: &str, contact: &str) -> String {
        match *self {
            Case::Oscillator(a, b) => format!(
                "{RATE}[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = 1 }}\n[REF]\n\
                 tie = {{ between = [\"wall\", \"bob\"], k = {a:?}, z = {b:?}{spring} }}\n{OUT}"
            ),
            Case::Bow(b) => gripped(0.1, b).replace("k = 0.1", "k = 0.1, dx0 = 1e-6"),
            Case::Contact(a) => format!(
                "{RATE}[SOL]\nwall = {{}}\n[CEL]\nbob = {{ m = 1, k = 0.01, v = 0.37123 }}\n[BUT]\n\
                 hit = {{ between = [\"wall\", \"bob\"], k = {a:?}{contact} }}\n{OUT}"
            ),
            Case::Ratio(r, b) => {
                let [k, z] = [1.0, b].map(|v| v / (1.0 + 1.0 / r));
                format!(
                    "{RATE}[MAS]\nbob = {{ m = 1, dx0 = 1 }}\nheavy = {{ m = {r:?} }}\n[REF]\n\
                     tie = {{ between = [\"heavy\", \"bob\"], k = {k:?}, z = {z:?}{spring} }}\n{OUT}"
                )
            }
            Case::Scale(k, l) => scaled(k, l),
            Case::Undamped => string(40).replace("z = \"1 mN s/m\"", "z = 0"),
            Case::Dead(b) => format!("{RATE}[CEL]\nbob = {{ m = 1, k = 0.1, z = {b:?}, dx0 = 1 }}\n{OUT}"),
            Case::Flight => format!("[MAS]\nbob = {{ m = \"1 g\", v = 1 }}\n{OUT}"),
        }
    }

    /// Plays the model of this case for `ticks` ticks.
    pub fn outcome(&self, text: &str, ticks: u64) -> Outcome {
        match *self {
            Case::Oscillator(..) | Case::Bow(_) => largest(text, ticks),
            Case::Contact(_) => energy(text, ticks, &[], 0.0),
            Case::Ratio(r, _) => energy(text, ticks, &[1.0, r], 0.0),
            Case::Undamped => energy(text, ticks, &[], 1e-3),
            Case::Scale(_, l) => {
                let (plain, here) = (scaled_output(&scaled(1.0, 1.0), ticks, 1.0), scaled_output(text, ticks, l));
                let peak = plain.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                Outcome::Differs(plain.iter().zip(&here).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / peak)
            }
            Case::Dead(_) => denormal(text, ticks),
            Case::Flight => {
                let (scene, mut s) = ready(text, false);
                (0..ticks).for_each(|_| tick(&scene, &mut s));
                let way = ticks as f64 * scene.rates.sample_dt;
                Outcome::Astray((s.x[0] / way - 1.0).abs())
            }
        }
    }
}

fn ready(text: &str, energy: bool) -> (Scene, State) {
    let scene = compiled(&model(text), KernelClass::Fast, energy);
    let s = scene.state();
    (scene, s)
}

/// Returns the output divided by `l`.
pub fn scaled_output(text: &str, ticks: u64, l: f64) -> Vec<f64> {
    let (scene, mut s) = ready(text, false);
    let step = |_| {
        tick(&scene, &mut s);
        s.output[0] / l
    };
    (0..ticks).map(step).collect()
}

/// Displacement, starting at 1, beyond which a scene has diverged.
const FAR: f64 = 1e200;

fn largest(text: &str, ticks: u64) -> Outcome {
    let (scene, mut s) = ready(text, false);
    let bob = mat(&scene, "bob");
    // as the cases of docs/numerics.md §3.6 start: at 1, and at 1 in the tick before
    s.d[bob] = 0.0;
    let mut most = [s.x[bob].abs(), 0.0];
    for n in 0..ticks {
        let before = s.x[bob].abs();
        tick(&scene, &mut s);
        let now = s.x[bob].abs();
        if now.is_nan() || now > FAR {
            return Outcome::Blown(now / before, n + 1);
        }
        let half = &mut most[usize::from(2 * n >= ticks)];
        *half = half.max(now);
    }
    Outcome::Largest(most[0].max(most[1]), most[1] > 1.5 * most[0])
}

/// Ratio of the energy to that at the start, beyond which a scene has diverged.
const BLOWN: f64 = 1e7;

/// Measures the energy with heat, and the momentum if `masses` are given, in the order of the model. Each mass that can
/// move starts with an additional `kick` \[m/tick\].
fn energy(text: &str, ticks: u64, masses: &[f64], kick: f64) -> Outcome {
    let (scene, mut s) = ready(text, true);
    for (d, c) in s.d.iter_mut().zip(&s.coef[2 * scene.counts.n_mat..]) {
        *d += if *c > 0.0 { kick } else { 0.0 };
    }
    let held = |s: &State| s.ledger.as_ref().map_or(f64::NAN, |l| l.h + l.balance().lost);
    tick(&scene, &mut s);
    let h0 = held(&s);
    let (mut worst, mut moment) = (0.0f64, 0.0f64);
    for n in 1..ticks {
        tick(&scene, &mut s);
        let h = held(&s) / h0;
        if h.is_nan() || h > BLOWN {
            return Outcome::Made(h, n);
        }
        worst = worst.max((h - 1.0).abs());
        moment = moment.max(masses.iter().zip(&s.d).map(|(m, d)| m * d).sum::<f64>().abs());
    }
    Outcome::Energy(worst, moment)
}

fn denormal(text: &str, ticks: u64) -> Outcome {
    let (scene, mut s) = ready(text, false);
    let mut n = 0;
    for _ in 0..ticks {
        tick(&scene, &mut s);
        n += u64::from(s.x.iter().chain(&s.d).any(|v| v.is_subnormal()));
    }
    Outcome::Denormal(n, s.x.iter().chain(&s.d).all(|v| *v == 0.0))
}

impl Outcome {
    /// Describes the result for a cell of the table.
    pub fn words(&self) -> String {
        match *self {
            Outcome::Largest(x, true) => format!("rises, to {x:.0}"),
            Outcome::Largest(x, false) => format!("bounded, {x:.3}"),
            Outcome::Blown(factor, n) if factor < 1e4 => format!("× {factor:.4} per tick, beyond 10²⁰⁰ after {n}"),
            Outcome::Blown(factor, n) => format!("× {factor:.1e} per tick, beyond 10²⁰⁰ after {n}"),
            Outcome::Energy(worst, 0.0) => format!("energy to {worst:.0e}"),
            Outcome::Energy(worst, moment) => format!("energy to {worst:.0e}, momentum to {moment:.0e}"),
            Outcome::Made(_, n) => format!("energy passes × 10⁷ after {n} ticks"),
            Outcome::Differs(0.0) => "the same bits".into(),
            Outcome::Differs(by) => format!("differs by {by:.0e}"),
            Outcome::Denormal(n, true) => format!("0, after {n} denormal ticks"),
            Outcome::Denormal(n, false) => format!("not 0, {n} denormal ticks"),
            Outcome::Astray(by) => format!("off by {by:.0e} of the way"),
        }
    }
}
