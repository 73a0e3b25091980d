//! Start: the state at load.

use crate::op::{Op, pass};
use crate::scene::Scene;
use crate::state::State;
use alloc::vec::Vec;

/// The second-order start (numerics 1.1): d₀ = v T − ½ (T²/m) F(x₀).
pub fn start(scene: &Scene, mut s: State) -> State {
    let n = scene.n_mat;
    let memory = |s: &mut State| {
        for op in &scene.forces {
            let Some(law) = op.law.filter(|l| l.mem > 0) else { continue };
            for i in 0..op.n {
                let [a, b] = scene.ends[op.first + i].map(|m| m as usize);
                let e = s.x[b] - s.x[a] + scene.e0[op.first + i];
                let c: Vec<f64> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n + i]).collect();
                (law.start)(&c, e, &mut s.mem[op.mem + i * law.mem..][..law.mem]);
            }
        }
    };
    for (k, p) in scene.proxies.iter().enumerate() {
        s.cells[k] = pass::cell(scene, &s, p);
    }
    let project = Op::pass("points", pass::project, scene.proxies.len());
    pass::project(&project, scene, &mut s);
    memory(&mut s);
    let mut trial = s.clone();
    for op in scene.forces.iter().filter(|op| op.name != "TGR out" && op.name != "ENF") {
        (op.kernel)(op, scene, &mut trial);
    }
    for i in 0..n {
        let (p, q, c) = (s.coef[i], s.coef[n + i], s.coef[2 * n + i]);
        if c == 0.0 {
            s.d[i] = 0.0;
        } else {
            s.d[i] -= 0.5 * (c * trial.f[i] + q * s.x[i] - (1.0 - p) * s.d[i]);
        }
    }
    pass::project(&project, scene, &mut s);
    s
}
