//! A law as data: functions that the compiler, the ledger and the certificate call without knowing which law it is.

use super::select_kernel::kernel;
use crate::law::Phi;
use crate::numeric::{Real, Table};
use crate::op::account::{Energies, numbers};
use crate::op::{Cheaper, LoadFns};
use crate::op::{Law, LawFns, ParamBinding, SolveStage};
use alloc::vec::Vec;

impl Law {
    /// Makes the record of a law.
    pub const fn of<P: Phi<C, M> + 'static, const C: usize, const M: usize>(code: &'static str) -> Law {
        Law {
            code,
            coefs: C,
            mem: M,
            linear: P::LINEAR,
            wide: P::WIDE,
            contact: P::CONTACT,
            stage: SolveStage::Explicit,
            implicit: false,
            at_load: LoadFns {
                load: |p, tick_dt, out| out.copy_from_slice(&P::coefs(p, tick_dt)),
                bound: |c, tables| P::bound(&numbers(c), tables),
                steepest: |c, tables, between| P::steepest(&numbers(c), tables, between),
            },
            cheaper: Cheaper::NONE,
            table: None,
            fns: LawFns::of::<P, C, M>(),
        }
    }

    /// Adds a rule that picks a cheaper law among `variants`.
    #[must_use]
    pub const fn or(
        mut self,
        variants: &'static [&'static Law],
        simpler: fn(&[ParamBinding]) -> Option<&'static Law>,
    ) -> Law {
        self.cheaper.variants = variants;
        self.cheaper.simpler = simpler;
        self
    }

    /// Replaces the function that loads the coefficients, for parameters in another order.
    pub(crate) const fn loaded_by(mut self, load: fn(&[Option<f64>], f64, &mut [f64])) -> Law {
        self.at_load.load = load;
        self
    }

    /// Adds a table that the law needs.
    #[must_use]
    pub const fn with_table(mut self, table: fn() -> Table) -> Law {
        self.table = Some(table);
        self
    }
}

/// Returns the coefficients of one link of a law, from its parameters in SI and the tick, `tick_dt` \[s\].
pub fn loaded(law: &Law, p: &[Option<f64>], tick_dt: f64) -> Vec<f64> {
    let mut c = alloc::vec![0.0; law.coefs];
    (law.at_load.load)(p, tick_dt, &mut c);
    c
}

/// Returns the memory of one link of a law at load, for elongation `e` and ends at rest.
pub fn started(law: &Law, c: &[f64], e: f64) -> Vec<f64> {
    let mut mem = alloc::vec![0.0; law.mem];
    (law.fns.start)(c, [e, 0.0], &mut mem);
    mem
}

/// Returns a law and all laws that may replace it.
pub fn family(law: &'static Law) -> Vec<&'static Law> {
    let mut all = alloc::vec![law];
    let mut next = 0;
    while let Some(law) = all.get(next).copied() {
        let others = if let SolveStage::Single(others) = law.stage { Some([others.line, others.space]) } else { None };
        for variant in law.cheaper.variants.iter().copied().chain(others.into_iter().flatten().flatten()) {
            if !all.iter().any(|known| core::ptr::eq(*known, variant)) {
                all.push(variant);
            }
        }
        next += 1;
    }
    all
}

impl<R: Real> LawFns<R> {
    /// Makes the functions of a [`Phi`].
    pub const fn of<P: Phi<C, M> + 'static, const C: usize, const M: usize>() -> LawFns<R> {
        LawFns {
            start: |c, [e, _], mem| mem[..M].copy_from_slice(&P::start(&numbers(c), e)),
            force: |c, mem, tables, e, w| {
                let mut m = numbers(mem);
                let f = P::force(&numbers(c), &mut m, tables, e, w);
                mem[..M].copy_from_slice(&m);
                f
            },
            energies: Energies::of::<P, C, M>(),
            idle: |c| P::idle(&numbers(c)),
            kernel: kernel::<R, P, C, M>,
        }
    }
}
