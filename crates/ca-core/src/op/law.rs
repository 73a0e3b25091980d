//! A law as data: what the compiler, the ledger and the certificate call without knowing which law it is.

use super::{Form, Kernel, kernel};
use crate::law::{Bound, Force, Idle, Lost, Phi, Stored};
use crate::real::Real;
use crate::table::Table;
use alloc::vec::Vec;

/// A law as data: the functions of a [`Phi`] over slices, and its kernels.
#[derive(Clone, Copy)]
pub struct Law {
    /// code of the law that runs, e.g. `RES` for a REF without viscosity
    pub code: &'static str,
    /// coefficients per link
    pub coefs: usize,
    /// numbers of memory per link
    pub mem: usize,
    /// see [`Phi::LINEAR`]
    pub linear: bool,
    /// see [`Phi::CONTACT`]
    pub contact: bool,
    /// when its force is computed
    pub turn: Turn,
    /// true where part of its force comes from the time to come, for all such links at once
    pub ahead: bool,
    /// see [`Phi::coefs`]; `out` has [`Law::coefs`] places
    pub load: fn(p: &[Option<f64>], te: f64, out: &mut [f64]),
    /// see [`Phi::start`]
    pub start: fn(c: &[Real], e: Real, mem: &mut [Real]),
    /// see [`Phi::force`]
    pub force: Force,
    /// see [`Phi::stored`]
    pub stored: Stored,
    /// see [`Phi::lost`]
    pub lost: Lost,
    /// see [`Phi::idle`]
    pub idle: Idle,
    /// see [`Phi::bound`]
    pub bound: fn(c: &[f64], tables: &[Table]) -> Bound,
    /// the pass for one form of the law
    pub kernel: fn(Form) -> Kernel,
    /// a cheaper law for these parameters (`None` marks one that may change while playing), if there is one
    pub simpler: fn(p: &[Fixed]) -> Option<&'static Law>,
    /// a table the law needs whatever its parameters; its number is handed over after the last parameter
    pub table: Option<fn() -> Table>,
}

/// When the force of a law is computed among the forces of a tick.
#[derive(Clone, Copy)]
pub enum Turn {
    /// from what is known at its beginning
    Any,
    /// after all forces of turn `Any`, from the motion they would cause: on a line, where no other link of a later turn
    /// moves the same place. Elsewhere this law runs instead
    Alone(&'static Law),
    /// after all others, collected link by link and then computed at once by this pass
    Together(Kernel),
}

/// What is known of a parameter when a law is specialised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fixed {
    /// not written
    Absent,
    /// this value, for good
    At(f64),
    /// may change while playing
    Live,
}

impl Fixed {
    /// True where the parameter is nothing and stays so.
    pub fn is_zero(self) -> bool {
        matches!(self, Fixed::Absent | Fixed::At(0.0))
    }
}

fn arr<T: Copy + Default, const N: usize>(s: &[T]) -> [T; N] {
    s.first_chunk::<N>().copied().unwrap_or([T::default(); N])
}

impl Law {
    /// The coefficients of one link, from its parameters in SI and the tick `te` \[s\].
    pub fn loaded(&self, p: &[Option<f64>], te: f64) -> Vec<f64> {
        let mut c = alloc::vec![0.0; self.coefs];
        (self.load)(p, te, &mut c);
        c
    }

    /// Its memory at load, for elongation `e`.
    pub fn started(&self, c: &[Real], e: Real) -> Vec<Real> {
        let mut mem = alloc::vec![0.0; self.mem];
        (self.start)(c, e, &mut mem);
        mem
    }

    /// The record of a law.
    pub const fn of<P: Phi<C, M> + 'static, const C: usize, const M: usize>(code: &'static str) -> Law {
        Law {
            code,
            coefs: C,
            mem: M,
            linear: P::LINEAR,
            contact: P::CONTACT,
            turn: Turn::Any,
            ahead: false,
            load: |p, te, out| out.copy_from_slice(&P::coefs(p, te)),
            start: |c, e, mem| mem[..M].copy_from_slice(&P::start(&arr(c), e)),
            force: |c, mem, tables, e, w| {
                let mut m = arr(mem);
                let f = P::force(&arr(c), &mut m, tables, e, w);
                mem[..M].copy_from_slice(&m);
                f
            },
            stored: |c, mem, tables, e0, e1| P::stored(&arr(c), &arr(mem), tables, e0, e1),
            lost: |c, mem, tables, e| P::lost(&arr(c), &arr(mem), tables, e),
            idle: |c| P::idle(&arr(c)),
            bound: |c, tables| P::bound(&arr(c), tables),
            kernel: kernel::<P, C, M>,
            simpler: |_| None,
            table: None,
        }
    }

    /// True where the force depends on the motion that others would cause.
    pub const fn is_late(&self) -> bool {
        !matches!(self.turn, Turn::Any)
    }

    /// The same law with a rule that picks a cheaper one.
    #[must_use]
    pub const fn or(mut self, simpler: fn(&[Fixed]) -> Option<&'static Law>) -> Law {
        self.simpler = simpler;
        self
    }

    /// The same law with a table of its own.
    #[must_use]
    pub const fn with_table(mut self, table: fn() -> Table) -> Law {
        self.table = Some(table);
        self
    }
}
