//! Energy quadratisation for contacts in space, and for all links that share masses with them: the energy of a contact
//! is the square of a stored number, which makes the push linear in the coming motion (Ducceschi, Bilbao, Willemsen and
//! Serafin, JASA 149(5), 2021; docs/numerics.md §3.4).
//!
//! ψ is √(2U) between ticks. With s the change of penetration over two ticks and γ known at the tick,
//! ```text
//! ψ₊ = ψ + γ s/2        N = γ (ψ + ψ₊)/2 + z s/2 = γψ + R s        R = γ²/4 + z/2
//! ```
//! so that the work N s/2 is (ψ₊² − ψ²)/2 plus the heat z s²/4, for **any** γ. While compressed, γ is the slope of
//! √(2U) at the tick, √k for a linear spring. ψ is kept positive, so the contact pushes.
//!
//! Once apart, γ is chosen to return all of ψ in this tick: ψ₊ = 0 with s = s* − Wγψ/2 requires Wψγ²/2 − s*γ − 2ψ = 0,
//! with the positive root 4ψ/(q − s*), q = √(s*² + 4Wψ²). Here s* is the change that all other forces would cause, and
//! W the mobility of this contact. A contact that closes again keeps ψ. An opening contact without energy does not
//! pull. If several release at once, ψ falls over some ticks. Below `nothing` it is zero, since 1/γ² would be infinite.
//!
//! All active contacts are one linear system (`system.rs`) with b = γψ, in y = N − γψ = R s. As s is y/R, an error ε of
//! the solver makes at most the energy N·ε/2, which the bound on the residual limits to the rounding of the impact.
//! Friction enters with γ = 0 and the viscosity of its secant (`friction.rs`).
//!
//! With `sticky = false` contacts that would pull are removed and the rest is solved again. Their ψ follows the motion
//! as far as that loses energy.

use super::spring::{Contact, Spring};
use super::system::{LinearPush, Response, conjugate, join, nothing, reach};
use crate::numeric::Real;
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure, Radial};
use crate::op::{Coupled, Energies, Form, Kernel, Law, LawFns, Op, SolveStage};
use crate::state::State;
use crate::state::active_contacts::ActiveContact;

/// Makes a one-sided spring with this method. Memory: ψ \[√J\], heat of the tick \[J\].
pub const fn law<S: Spring<f64>>(spring: Law) -> Law {
    Law {
        mem: 2,
        stage: SolveStage::Coupled(Coupled { curve: false, at_modes: None }),
        fns: fns::<f64, S>(spring.fns),
        ..spring
    }
}

/// Makes its functions from the functions of the spring.
pub const fn fns<R: Real, S: Spring<R>>(spring: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |c, [e, _], mem| {
            let b = Contact::<R, S>::of(c);
            mem[0] = (R::of(2.0) * b.potential(b.penetration(e))).sqrt();
            mem[1] = R::ZERO;
        },
        energies: Energies::followed(
            |_, mem, _, _, _| R::of(0.5) * mem[0] * mem[0],
            |_, mem, _, _| mem[1],
            |c, e| {
                let b = Contact::<R, S>::of(c);
                b.potential(b.penetration(e))
            },
        ),
        kernel: kernel::<R, S>,
        ..spring
    }
}

fn kernel<R: Real, S: Spring<R>>(form: Form) -> Kernel<R> {
    match (form.measure, form.onto) {
        (MeasureKind::Line, _) => gather::<R, S, Line, Line>,
        (MeasureKind::Along, _) => gather::<R, S, Along, Line>,
        // of a quadripole, the compiler puts a port in space first
        (MeasureKind::Radial, Some(MeasureKind::Radial)) => gather::<R, S, Radial, Radial>,
        (MeasureKind::Radial, _) => gather::<R, S, Radial, Line>,
    }
}

/// Collects the contacts of `op`. `G` measures their ends, and `H` the second pair of ends of a quadripole.
fn gather<R: Real, S: Spring<R>, G: Measure, H: Measure>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let contact = Contact::<R, S>::read(s, op.coef, op.n, i);
        let ends = layout.links.ends[op.first + i].map(|m| m as usize);
        let at = if G::SPACE { layout.links.reach[op.ports.reach + i] } else { [R::ZERO; 4] };
        let mem = op.mem + 2 * i;
        let psi = s.links.mem[mem];
        s.links.mem[mem + 1] = R::ZERO;
        if op.form.tap {
            s.links.tap[op.tap + i] = R::ZERO;
        }
        if psi == R::ZERO && op.ports.onto.is_none() {
            // test for an open contact without the square root
            let d = contact.d.max(R::ZERO);
            if G::square(&s.x, ends, &at).is_some_and(|l| contact.side * (d * d - l) < R::ZERO) {
                continue;
            }
        }
        let measured = G::measure(&s.x, &s.d, ends, &at);
        let second = op.ports.onto.map(|(_, first, reach)| {
            let ends = layout.links.onto[first + i];
            let at = if H::SPACE { layout.links.reach[reach + i] } else { [R::ZERO; 4] };
            (ends, H::measure(&s.x, &s.d, ends.map(|m| m as usize), &at))
        });
        let more = second.map_or(R::ZERO, |(_, measured)| measured.e);
        let eta = contact.penetration(measured.e + more + layout.links.e0[op.first + i]);
        if eta < R::ZERO && psi * psi <= nothing() {
            s.links.mem[mem] = R::ZERO;
            continue;
        }
        let link = reach::<R, G>(op, layout, s, i, contact.side, measured.gradient());
        let link = match second {
            Some((ends, measured)) => link.and::<H>(layout, s, ends, measured.gradient()),
            None => link,
        };
        let (free, w) = (link.free, link.own);
        let (gamma, z) = match (eta >= R::ZERO, free < R::ZERO) {
            (true, opening) => {
                let gamma = if opening && psi == R::ZERO { R::ZERO } else { contact.spring.gamma(contact.k, eta) };
                (gamma, contact.spring.viscosity(contact.k, eta))
            }
            (false, true) => (R::of(4.0) * psi / ((free * free + R::of(4.0) * w * psi * psi).sqrt() - free), R::ZERO),
            (false, false) => (R::ZERO, R::ZERO),
        };
        join(s, mem, link, LinearPush { clip: contact.clip, open: eta < R::ZERO, gamma, psi, z });
    }
}

/// Solves for contacts that use ψ. Contacts that would pull are moved behind the others, whose number it returns.
pub(super) fn pushes<R: Real, const MODES: bool>(all: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) -> usize {
    let mut acting = all.len();
    loop {
        conjugate(&mut all[..acting], acting, to);
        let before = acting;
        let mut i = 0;
        while i < acting {
            if all[i].clip && all[i].gamma * all[i].psi + all[i].y < R::ZERO {
                acting -= 1;
                all.swap(i, acting);
            } else {
                i += 1;
            }
        }
        if acting == before {
            return acting;
        }
    }
}

pub(super) fn keep<R: Real>(t: &mut ActiveContact<R>, mem: &mut [R]) {
    let moved = t.y / t.stiff;
    t.p = t.gamma * t.psi + t.y;
    let left = (t.psi + R::of(0.5) * t.gamma * moved).abs();
    let nothing = t.open && t.psi * t.psi + left * left == t.psi * t.psi;
    mem[t.mem] = if nothing { R::ZERO } else { left };
    mem[t.mem + 1] = R::of(0.25) * t.z * moved * moved;
}

/// Sets the ψ of a contact that was left out. It follows the motion as far as that loses energy, which becomes heat.
pub(super) fn follow<R: Real>(t: &ActiveContact<R>, mem: &mut [R]) {
    let follows = t.psi + R::of(0.5) * t.gamma * (t.free - t.q);
    let left = follows.abs().min(t.psi);
    mem[t.mem] = left;
    mem[t.mem + 1] = R::of(0.5) * (t.psi - left) * (t.psi + left);
}
