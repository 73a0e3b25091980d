//! Start: the state at load.

use crate::layout::Layout;
use crate::op::{Op, gauge, pass};
use crate::real::Real;
use crate::state::State;
use alloc::vec::Vec;

/// The second-order start (numerics 1.1): d₀ = v T − ½ (T²/m) F(x₀); `exact`, where d is motion itself, d₀ = v T.
pub fn start(layout: &Layout, forces: &[Op], exact: bool, mut s: State) -> State {
    let n = layout.n_mat;
    let memory = |s: &mut State| {
        for op in forces {
            let Some(law) = op.law.filter(|l| l.mem > 0) else { continue };
            for i in 0..op.n {
                let felt = gauge::ports(layout, &op.ports, op.first, i)
                    .map(|(gauge, ends, reach)| gauge::measure(gauge, &s.x, &s.d, ends, &reach).e);
                let e = layout.e0[op.first + i] + felt.sum::<Real>();
                let c: Vec<Real> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n + i]).collect();
                (law.start)(&c, e, &mut s.mem[op.mem + i * law.mem..][..law.mem]);
            }
        }
    };
    for (k, p) in layout.proxies.iter().enumerate() {
        s.cells[k] = pass::cell(layout, &s, p);
    }
    pass::sum(&Op::pass("modal ports", pass::sum, layout.modal.len()), layout, &mut s);
    let project = Op::pass("points", pass::project, layout.proxies.len());
    pass::project(&project, layout, &mut s);
    memory(&mut s);
    let mut trial = s.clone();
    let counts = |op: &&Op| !exact && !matches!(op.name, "TGR out" | "border booked" | "TGR mute" | "ENF");
    for op in forces.iter().filter(counts) {
        (op.kernel)(op, layout, &mut trial);
    }
    for i in 0..n {
        let (p, q, c) = (s.coef[i], s.coef[n + i], s.coef[2 * n + i]);
        if c == 0.0 {
            s.d[i] = 0.0;
        } else if !exact {
            s.d[i] -= 0.5 * (c * trial.f[i] + q * s.x[i] - (1.0 - p) * s.d[i]);
        }
    }
    pass::sum(&Op::pass("modal ports", pass::sum, layout.modal.len()), layout, &mut s);
    pass::project(&project, layout, &mut s);
    s
}
