//! Rattle of the reference cases C05 and C06: three pyramids in a hollow sphere, which is one mass, without damping.
//! The drift of its energy shows how stiff a contact may be.

pub mod page;

use crate::{compiled, model};
use ca_compile::KernelClass;
use ca_core::{Scene, tick};
use std::fmt::Write as _;
use std::time::Instant;

/// Length of an edge of a pyramid \[m\].
const EDGE: f64 = 0.02;
/// Mass of a corner \[kg\].
const CORNER: f64 = 1e-3;
/// Sound rate \[Hz\].
const RATE: f64 = 48e3;
/// Ratio of the energy to that at the start, beyond which a scene has diverged.
const BLOWN: f64 = 1e7;

/// Returns the model with contacts of stiffness kT²/m = `a` by `method`, and velocities from `seed`. Corners of
/// different pyramids stay 4 mm apart.
pub fn text(a: f64, method: &str, seed: u64) -> String {
    let mut rng = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut roll = || {
        rng ^= rng << 13;
        rng ^= rng >> 7;
        rng ^= rng << 17;
        (rng >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let unit = CORNER * RATE * RATE;
    let (k, contact) = (0.1 * unit, a * unit);
    let mut t = format!("[rate]\nsound = {RATE}\n[room]\ndim = 3\n[room.MAS]\nball = {{ m = 0.05 }}\n");
    let (half, corners) =
        (EDGE / 8f64.sqrt(), [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]);
    let centres = [[0.022, 0.0, 0.0], [-0.011, 0.019, 0.0], [-0.011, -0.019, 0.0]];
    for (name, centre) in ["p", "q", "r"].iter().zip(centres) {
        let speed: [f64; 3] = std::array::from_fn(|_| roll());
        for (i, corner) in corners.iter().enumerate() {
            let x: [f64; 3] = std::array::from_fn(|n| centre[n] + half * corner[n]);
            let v: [f64; 3] = std::array::from_fn(|n| speed[n] + 0.1 * roll());
            let _ = writeln!(t, "{name}{i} = {{ m = {CORNER}, x = {x:?}, v = {v:?} }}");
        }
    }
    let all = |name: &str| (0..4).map(|i| format!("\"room.{name}{i}\"")).collect::<Vec<_>>().join(", ");
    let (p, q, r) = (all("p"), all("q"), all("r"));
    t += "[RES]\n";
    for (name, list) in [("edge_p", &p), ("edge_q", &q), ("edge_r", &r)] {
        let _ = writeln!(t, "{name} = {{ between = [[{list}], [{list}]], k = {k:?} }}");
    }
    let how = format!("k = {contact:?}, method = \"{method}\"");
    let _ = writeln!(
        t,
        "[BUT]\ntouch = {{ between = [\"room.ball\", [{p}, {q}, {r}]], d = 0.05, sense = \"inside\", {how} }}"
    );
    for (name, one, other) in [("touch_pq", &p, &q), ("touch_qr", &q, &r), ("touch_rp", &r, &p)] {
        let _ = writeln!(t, "{name} = {{ between = [[{one}], [{other}]], pairs = \"all\", d = 0.004, {how} }}");
    }
    t + "[SOX]\nout = { from = \"room.p0\", along = \"x\" }\n"
}

fn built(a: f64, method: &str, seed: u64, energy: bool) -> Scene {
    compiled(&model(&text(a, method, seed)), KernelClass::Fast, energy)
}

/// Energy of a run.
#[derive(Clone, Copy, Debug)]
pub struct EnergyFigures {
    /// Energy at the end, or at the divergence, relative to the start.
    pub end: f64,
    /// Largest |E/E₀ − 1| at any tick.
    pub worst: f64,
    /// Largest |residual| relative to the energy at the start.
    pub residual: f64,
    /// Largest |energy made| by a contact, relative to the energy at the start.
    pub made: f64,
    /// Time played \[s\].
    pub seconds: f64,
}

/// Plays the rattle for `seconds`, or until it diverges, with the energy ledger.
pub fn fares(a: f64, method: &str, seed: u64, seconds: f64) -> EnergyFigures {
    let scene = built(a, method, seed, true);
    let mut s = scene.state();
    tick(&scene, &mut s);
    let h0 = s.ledger.as_ref().map_or(f64::NAN, |l| l.h0);
    let touches = |i: &usize| scene.audited_name(*i).is_some_and(|n| n.starts_with("touch"));
    let contacts: Vec<usize> = (0..scene.counts.n_lia).filter(touches).collect();
    let mut f = EnergyFigures { end: 1.0, worst: 0.0, residual: 0.0, made: 0.0, seconds };
    for n in 0..(seconds * RATE) as u64 {
        tick(&scene, &mut s);
        let Some(ledger) = s.ledger.as_ref() else { break };
        f.end = ledger.h / h0;
        f.worst = f.worst.max((f.end - 1.0).abs());
        if f.end.is_nan() || f.end >= BLOWN {
            (f.worst, f.seconds) = (f64::INFINITY, n as f64 / RATE);
            break;
        }
    }
    if let Some(ledger) = s.ledger.as_ref() {
        f.residual = ledger.balance().residual.abs() / h0;
        f.made = contacts.iter().map(|i| ledger.scheme_error[*i].abs()).fold(0.0, f64::max) / h0;
    }
    f
}

/// Returns the time of a tick without the energy ledger \[ns\], the best of three runs of `seconds`.
pub fn costs(a: f64, method: &str, seed: u64, seconds: f64) -> f64 {
    let scene = built(a, method, seed, false);
    let ticks = (seconds * RATE) as u64;
    let run = |_| {
        let mut s = scene.state();
        let begin = Instant::now();
        (0..ticks).for_each(|_| tick(&scene, &mut s));
        std::hint::black_box(&s);
        begin.elapsed().as_secs_f64() * 1e9 / ticks as f64
    };
    (0..3).map(run).fold(f64::INFINITY, f64::min)
}
